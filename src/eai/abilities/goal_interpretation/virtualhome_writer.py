"""Writes the goals of a VirtualHome task as a model should: for built-in models and tests."""

from __future__ import annotations

import json

from eai.abilities.goal_interpretation.virtualhome_gold import by_class, gold_goals
from eai.abilities.goal_interpretation.written import SECTIONS
from eai.data.task import GoalKind, Task


def write_goals(task: Task) -> str:
    """The answer with exactly the task's goals; of an action goal, the first alternative."""
    gold = by_class(gold_goals(task))
    sections = {
        GoalKind.STATE: [goal._asdict() for goal in gold.states],
        GoalKind.RELATION: [goal._asdict() for goal in gold.relations],
        GoalKind.ACTION: [{"action": words[0], "description": words[0].lower()} for words in gold.actions],
    }
    return json.dumps({SECTIONS[kind]: goals for kind, goals in sections.items()}, indent=1)
