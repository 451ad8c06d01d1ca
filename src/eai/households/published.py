"""The published prompts, byte for byte, and gold operators: the tasks of transition modeling."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.protocol import Ability
from eai.data.progress import Report, silent
from eai.data.store import PackFile, Store
from eai.households.packs import (
    BEHAVIOR_PDDL,
    PROBLEMS_MEMBER,
    PROMPTS,
    RESOURCES,
    open_published,
    task_id_of,
)
from eai.prompts.prompt import Prompt, PromptFiles, PublishedPrompts, prompt_file
from eai.tasks.source import TaskSet

if TYPE_CHECKING:
    from eai.abilities.transition_modeling.declaration import Category
    from eai.abilities.transition_modeling.task import TransitionTask
    from eai.pddl.model import OperatorText

Render = Callable[[Store | None, Report], Mapping[str, str]]
"""Renders prompts of which the data set ships only a template: task id -> question."""


@dataclass(frozen=True, slots=True)
class _OfficialPrompts:
    name: str
    rendered: Mapping[Ability, Render]

    def prompts(
        self, ability: Ability, store: Store | None = None, *, report: Report = silent
    ) -> Mapping[str, Prompt]:
        """The prompts by task id, in the order of the data set.

        Raises:
            DataError: they cannot be obtained.
        """
        if ability in self.rendered:
            return {i: Prompt(text) for i, text in self.rendered[ability](store, report).items()}
        files = self.files(ability, store, report=report)
        settings = {} if files.system is None else json.loads(files.system)
        system, stop = settings.get("system_prompt"), tuple(settings.get("stop_sequences", ()))
        rows = json.loads(files.prompts)
        return {task_id_of(row["identifier"]): Prompt(row["llm_prompt"], system, stop) for row in rows}

    def files(self, ability: Ability, store: Store | None = None, *, report: Report = silent) -> PromptFiles:
        """The files of the prompts, byte for byte where the data set ships them.

        Raises:
            DataError: they cannot be obtained.
        """
        if ability in self.rendered:
            return PromptFiles(prompt_file(self.prompts(ability, store, report=report)), None)
        pack = open_published(PROMPTS, store, report=report)
        setup = f"{self.name}/{ability.value}_system.json"
        system = pack.read(setup) if setup in pack.manifest.members else None
        return PromptFiles(pack.read(f"{self.name}/{ability.value}.json"), system)


def official_prompts(name: str, rendered: Mapping[Ability, Render] | None = None) -> PublishedPrompts:
    """The official prompts of one benchmark.

    Args:
        name: the benchmark's folder in the pack of prompts.
        rendered: the abilities whose prompts the data set ships as a template only, and how to render them.
    """
    return _OfficialPrompts(name, rendered or {})


TransitionTasks: TypeAlias = "TaskSet[TransitionTask]"


def open_virtualhome(store: Store | None = None, *, report: Report = silent) -> TransitionTasks:
    """VirtualHome's 296 tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return _transition_tasks(open_published(RESOURCES, store, report=report), "virtualhome_pd.pddl")


def open_behavior(store: Store | None = None, *, report: Report = silent) -> TransitionTasks:
    """BEHAVIOR's 100 tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return _transition_tasks(open_published(BEHAVIOR_PDDL, store, report=report), "behavior_pd.pddl")


def _transition_tasks(pack: PackFile, header: str) -> TransitionTasks:
    """The tasks of the published files, given the member with the planning domain."""
    from eai.abilities.transition_modeling.task import OperatorLibrary, TransitionTask
    from eai.pddl.reader import read_domain

    library = OperatorLibrary(
        header=read_domain(pack.read(header).decode() + ")"),
        operators={
            name: _operator(name, values) for name, values in pack.read_json("gold_action.json").items()
        },
        categories={
            name: _category(label) for name, label in pack.read_json("predicates_category.json").items()
        },
    )
    problems, operators = pack.read_json(PROBLEMS_MEMBER), pack.read_json("id2action.json")
    categories = pack.read_json("id2category_2.json")

    def build(task_id: str) -> TransitionTask:
        kinds = [_category(label) for label in categories[task_id]]
        return TransitionTask(task_id, library, operators[task_id], kinds, problems[task_id])

    tasks = {task_id: build(task_id) for task_id in pack.read_json("success_task.json")}
    return TaskSet(tasks, tasks.__getitem__, pack.manifest.sha256)


def _operator(name: str, values: Mapping[str, str]) -> OperatorText:
    from eai.pddl.model import OperatorText

    parts = [values[key] for key in ("action_parameters", "action_preconditions", "action_effects")]
    return OperatorText(name, *parts)


def _category(label: str) -> Category:
    """The category that a label of the data set means: ``non-spatial_relations``, ``object states``, ..."""
    from eai.abilities.transition_modeling.declaration import Category

    return Category(label.replace("-", "_").replace(" ", "_"))
