"""Writes the goals of a VirtualHome task as a model should: for built-in models and tests."""

from __future__ import annotations

import json
from collections.abc import Iterable

from eai.abilities.goal_interpretation.virtualhome_gold import by_class, gold_goals
from eai.abilities.goal_interpretation.written import SECTIONS
from eai.abilities.task import GoalKind, Task


def write_goals(task: Task) -> tuple[str, ...]:
    """Each goal of a task as an object with its section as key; of an action goal the first alternative."""
    gold = by_class(gold_goals(task))
    entries: list[tuple[GoalKind, dict[str, str]]] = [
        *((GoalKind.STATE, goal._asdict()) for goal in gold.states),
        *((GoalKind.RELATION, goal._asdict()) for goal in gold.relations),
        *((GoalKind.ACTION, {"action": goal[0], "description": goal[0].lower()}) for goal in gold.actions),
    ]
    return tuple(json.dumps({SECTIONS[kind]: entry}) for kind, entry in entries)


def join_goals(goals: Iterable[str]) -> str:
    """The goals as one answer: sorted into their sections, in order."""
    sections: dict[str, list[object]] = {key: [] for key in SECTIONS.values()}
    for goal in goals:
        for key, entry in json.loads(goal).items():
            sections[key].append(entry)
    return json.dumps(sections, indent=1)
