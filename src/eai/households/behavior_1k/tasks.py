"""The activities of BEHAVIOR-1K as tasks, made of the pack when they are asked for."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cached_property
from importlib.resources import files

from eai.abilities.task import Task, goal
from eai.data.files import parse_toml
from eai.data.store import PackFile
from eai.english import English
from eai.households.behavior_1k.kinds import ACTIVITIES, KINDS, PLANS, RULES, Kinds
from eai.households.behavior_1k.operators import READING
from eai.households.behavior_1k.scene import Scenes
from eai.households.behavior_1k.sentences import instruction
from eai.households.packs import BEHAVIOR_1K, open_published
from eai.logic.formula import And, operands
from eai.tasks.source import Source, TaskSet
from eai.world.execution import Action


def _evidence() -> bytes:
    """The table of facts of activities besides their definitions."""
    return (files("eai.households.behavior_1k") / "evidence.toml").read_bytes()


def left_out() -> Mapping[str, str]:
    """Why an activity is in no rate, by its name."""
    entries = parse_toml(_evidence().decode())["left_out"]
    return {name: entry["reason"] for entry in entries for name in entry["activities"]}


def subsets() -> Mapping[str, tuple[str, ...]]:
    """Named lists of activities."""
    return {name: tuple(each) for name, each in parse_toml(_evidence().decode())["subsets"].items()}


class _ActivityTasks(TaskSet[Task]):
    """The tasks of a pack, in alphabetical order; their digest is that of the data, evidence and reading.

    Args:
        pack: the pack.
        english: the sentences of predicates.
    """

    def __init__(self, pack: PackFile, english: English) -> None:
        self._pack = pack
        self._english = english
        self._left_out = left_out()
        self._texts = _lines(pack, ACTIVITIES)
        digest = f"{pack.sha256}{hashlib.sha256(_evidence()).hexdigest()}{READING}"
        super().__init__(self._texts, self._task, hashlib.sha256(digest.encode()).hexdigest())

    @cached_property
    def _scenes(self) -> Scenes:
        kinds = Kinds(self._pack.read_json(KINDS), self._pack.read_json(RULES))
        return Scenes(kinds, self._texts)

    @cached_property
    def _plans(self) -> Mapping[str, str]:
        return _lines(self._pack, PLANS)

    def _task(self, task_id: str) -> Task:
        activity, setting = self._scenes.set_up(task_id)
        title = task_id.replace("_", " ")
        goals = tuple(dict.fromkeys(map(goal, operands(activity.problem.goal, And))))
        return Task(
            id=task_id,
            title=title,
            instruction=instruction(title, [each.formula for each in goals], activity.objects, self._english),
            initial=setting.state,
            goals=goals,
            relevant=tuple(range(setting.nameable)),
            script=_plan(self._plans.get(task_id, "")),
            unsolvable=self._left_out.get(task_id),
            unnamed=tuple(range(setting.nameable, len(setting.state.scene.objects))),
        )


def _plan(line: str) -> tuple[Action, ...]:
    """The plan of a line, ``OPERATOR 3 5;...``, objects by index; none of an empty one."""
    steps = [step.split(" ") for step in line.split(";")] if line else []
    return tuple(Action(operator, tuple(map(int, names))) for operator, *names in steps)


def _lines(pack: PackFile, member: str) -> Mapping[str, str]:
    return dict(line.split("\t") for line in pack.read(member).decode().splitlines())


def open_tasks(english: English, source: Source | None = None) -> _ActivityTasks:
    """The tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return _ActivityTasks(open_published(BEHAVIOR_1K, source), english)
