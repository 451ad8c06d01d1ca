"""The published prompts, byte for byte, and gold operators: the tasks of transition modeling."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.declaration import Category
from eai.abilities.transition_modeling.task import OperatorLibrary, TransitionTask
from eai.data.progress import Report, silent
from eai.data.store import PackFile, Store
from eai.households.packs import BEHAVIOR_PDDL, PROMPTS, RESOURCES, open_published
from eai.households.published_files import PROBLEMS_MEMBER, task_id_of
from eai.pddl.model import OperatorText
from eai.pddl.reader import read_domain
from eai.prompts.prompt import Prompt, PromptFiles, prompt_file
from eai.tasks.source import TaskSet

Render = Callable[[Store | None, Report], Mapping[str, str]]
"""Renders prompts of which the data set ships only a template: task id -> question."""


@dataclass(frozen=True, slots=True)
class OfficialPrompts:
    """The official prompts of one benchmark.

    Attributes:
        name: the benchmark's folder in the pack of prompts.
        rendered: the abilities whose prompts the data set ships as a template only, and how to render them.
    """

    name: str
    rendered: Mapping[Ability, Render] = field(default_factory=dict)

    def prompts(
        self, ability: Ability, store: Store | None = None, *, report: Report = silent
    ) -> Mapping[str, Prompt]:
        """The prompts by task id, in the order of the data set.

        Raises:
            DataError: they cannot be obtained.
        """
        if ability in self.rendered:
            return {i: Prompt(text) for i, text in self.rendered[ability](store, report).items()}
        pack = open_published(PROMPTS, store, report=report)
        setup = self._setup(ability)
        settings = pack.read_json(setup) if setup in pack.manifest.members else {}
        system, stop = settings.get("system_prompt"), tuple(settings.get("stop_sequences", ()))
        rows = pack.read_json(self._member(ability))
        return {task_id_of(row["identifier"]): Prompt(row["llm_prompt"], system, stop) for row in rows}

    def files(self, ability: Ability, store: Store | None = None, *, report: Report = silent) -> PromptFiles:
        """The files of the prompts, byte for byte where the data set ships them.

        Raises:
            DataError: they cannot be obtained.
        """
        if ability in self.rendered:
            return PromptFiles(prompt_file(self.prompts(ability, store, report=report)), None)
        pack = open_published(PROMPTS, store, report=report)
        setup = self._setup(ability)
        system = pack.read(setup) if setup in pack.manifest.members else None
        return PromptFiles(pack.read(self._member(ability)), system)

    def _member(self, ability: Ability) -> str:
        return f"{self.name}/{ability.value}.json"

    def _setup(self, ability: Ability) -> str:
        return f"{self.name}/{ability.value}_system.json"


class TransitionTasks(TaskSet[TransitionTask]):
    """The tasks of a household.

    Args:
        pack: the published files.
        header_member: the one with the planning domain.

    Attributes:
        domain: what they share.
    """

    def __init__(self, pack: PackFile, header_member: str) -> None:
        self.domain = OperatorLibrary(
            header=read_domain(pack.read(header_member).decode() + ")"),
            operators={
                name: OperatorText(
                    name,
                    values["action_parameters"],
                    values["action_preconditions"],
                    values["action_effects"],
                )
                for name, values in pack.read_json("gold_action.json").items()
            },
            categories={
                name: category_of(label) for name, label in pack.read_json("predicates_category.json").items()
            },
        )
        problems = pack.read_json(PROBLEMS_MEMBER)
        operators = pack.read_json("id2action.json")
        categories = pack.read_json("id2category_2.json")
        tasks = {
            task_id: TransitionTask(
                task_id,
                self.domain,
                operators[task_id],
                [category_of(label) for label in categories[task_id]],
                problems[task_id],
            )
            for task_id in pack.read_json("success_task.json")
        }
        super().__init__(tasks, tasks.__getitem__, pack.manifest.sha256)


def category_of(label: str) -> Category:
    """The category that a label of the data set means: ``non-spatial_relations``, ``object states``, ..."""
    return Category(label.replace("-", "_").replace(" ", "_"))


def open_virtualhome(store: Store | None = None, *, report: Report = silent) -> TransitionTasks:
    """VirtualHome's 296 tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return TransitionTasks(open_published(RESOURCES, store, report=report), "virtualhome_pd.pddl")


def open_behavior(store: Store | None = None, *, report: Report = silent) -> TransitionTasks:
    """BEHAVIOR's 100 tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return TransitionTasks(open_published(BEHAVIOR_PDDL, store, report=report), "behavior_pd.pddl")
