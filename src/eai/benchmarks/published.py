"""Read the published prompts unchanged, and the published tasks of transition modeling."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.protocol import Ability
from eai.base.store import PackFile
from eai.benchmarks import reference_wheel as packs
from eai.benchmarks.benchmark import PublishedPrompts
from eai.benchmarks.packs import open_pack
from eai.tasks.prompts.prompt import Prompt, PromptFiles
from eai.tasks.source import Source, TaskSet

if TYPE_CHECKING:
    from eai.tasks.operator_task import StepTranslator, TransitionTask
    from eai.tasks.task import PredicateCategory

Render = Callable[[Source], Mapping[str, str]]
"""Renders prompts for which the data set has only a template. Returns a mapping from task id to question."""


def make_reader_of_published_prompts(
    folder_in_pack: str, renderer_by_ability: Mapping[Ability, Render] | None = None
) -> PublishedPrompts:
    """Return a function that reads a benchmark's official prompts. Stored prompts are read byte for byte.

    Args:
        folder_in_pack: the benchmark's folder in the pack (data package) of prompts.
        renderer_by_ability: ability -> renderer of prompts, for abilities for which the data set has only a
            template.
    """

    def open_prompt_files(ability: Ability, source: Source) -> PromptFiles:
        if renderer_by_ability is not None and ability in renderer_by_ability:
            texts = renderer_by_ability[ability](source)
            return PromptFiles.from_prompts({i: Prompt(text) for i, text in texts.items()})
        pack = open_pack(packs.PROMPTS, source)
        setup = f"{folder_in_pack}/{ability.value}_system.json"
        system = pack.read_member(setup) if setup in pack.members else None
        return PromptFiles(pack.read_member(f"{folder_in_pack}/{ability.value}.json"), system)

    return open_prompt_files


TransitionTasks: TypeAlias = "TaskSet[TransitionTask]"


def open_virtualhome_transition_tasks(source: Source | None = None) -> TransitionTasks:
    """Return VirtualHome's 296 tasks of transition modeling; download them first if they are missing.

    Raises:
        DataError: the tasks cannot be obtained, or the store is damaged.
    """
    from eai.benchmarks.virtualhome.counterparts import translate_to_household_actions

    pack = open_pack(packs.RESOURCES, source)
    return _build_transition_tasks(pack, "virtualhome_pd.pddl", translate_to_household_actions)


def open_behavior_transition_tasks(source: Source | None = None) -> TransitionTasks:
    """Return BEHAVIOR's 100 tasks of transition modeling; download them first if they are missing.

    Raises:
        DataError: the tasks cannot be obtained, or the store is damaged.
    """
    from eai.benchmarks.behavior.counterparts import translate_to_household_actions

    pack = open_pack(packs.BEHAVIOR_PDDL, source)
    return _build_transition_tasks(pack, "behavior_pd.pddl", translate_to_household_actions)


_PARTS = ("parameters", "preconditions", "effects")


def _build_transition_tasks(
    pack: PackFile, domain_file: str, translate_steps: StepTranslator
) -> TransitionTasks:
    """Return the tasks of transition modeling in the published files.

    Args:
        pack: the pack (data package) with the files.
        domain_file: name of the file with types and predicates of the planning domain.
        translate_steps: translates the steps of a plan in the planning domain to household actions.
    """
    from eai.pddl.model import OperatorText
    from eai.pddl.reader import read_domain
    from eai.tasks.operator_task import OperatorLibrary, TransitionTask

    library = OperatorLibrary(
        header=read_domain(pack.read_member(domain_file).decode() + ")"),
        operators={
            name: OperatorText(name, *[values[f"action_{part}"] for part in _PARTS])
            for name, values in pack.read_json("gold_action.json").items()
        },
        categories={
            name: _read_predicate_category(label)
            for name, label in pack.read_json("predicates_category.json").items()
        },
    )
    problems, operators = pack.read_json(packs.PROBLEMS_MEMBER), pack.read_json("id2action.json")
    categories = pack.read_json("id2category_2.json")

    def build_task(task_id: str) -> TransitionTask:
        kinds = tuple(map(_read_predicate_category, categories[task_id]))
        return TransitionTask(
            task_id, library, tuple(operators[task_id]), kinds, problems[task_id], translate_steps
        )

    tasks = {task_id: build_task(task_id) for task_id in pack.read_json("success_task.json")}
    return TaskSet(tasks, tasks.__getitem__, pack.sha256)


def _read_predicate_category(label: str) -> PredicateCategory:
    """Return the predicate category that a label in the data set means, such as ``non-spatial_relations``."""
    from eai.tasks.task import PredicateCategory

    return PredicateCategory(label.replace("-", "_").replace(" ", "_"))
