"""Goals written as BEHAVIOR answers: the first ground option of each goal."""

from __future__ import annotations

import json
from collections.abc import Iterable

from eai.abilities.goal_interpretation.behavior_conditions import STATES
from eai.benchmarks.behavior.tasks import BehaviorTask

_SECTIONS = ("node goals", "edge goals")


def write_goals(task: BehaviorTask) -> tuple[str, ...]:
    """Each condition of the task's goals, in order, as ``["open", "jar.n.01_1"]``."""
    first_options = (options[0] for options in task.interpretation_goals if options)
    return tuple(json.dumps(condition) for option in first_options for condition in option)


def join_goals(conditions: Iterable[str]) -> str:
    """The conditions as one answer: those of one object before those of two."""
    sections: dict[str, list[object]] = {name: [] for name in _SECTIONS}
    for condition in map(json.loads, conditions):
        predicate, *_ = condition[1] if condition[0] == "not" else condition
        sections[_SECTIONS[predicate not in STATES]].append(condition)
    return json.dumps(sections)
