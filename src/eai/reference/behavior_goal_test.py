"""Which goals of a BEHAVIOR task hold, as eai-eval 1.0.5 finds out.

A goal holds if one of the ground options does that bddl keeps (`truncated_options`), where a thing is inside
its direct container only (``evolving_graph.py`` get_state_dict).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from eai.abilities.goal_test import GoalTest
from eai.abilities.task import Task
from eai.households.behavior import predicates as p
from eai.logic.formula import And, Atom, Formula, Not, Or
from eai.reference.truncated_options import truncated_options
from eai.world.scene_objects import SceneObjects
from eai.world.state import Scene

_IN_REFERENCE: Mapping[str, str] = {"inside": p.directly_inside.name}


def behavior_goal_test(task: Task) -> GoalTest:
    """The reference's test of a task's goals; they count by the kinds of their own formulas."""
    return GoalTest(task, [_asked(goal.formula, task.scene) for goal in task.goals])


def _asked(formula: Formula, scene: Scene) -> Formula:
    """What the reference asks in a goal's place: that all literals of one of its truncated options hold."""
    options = truncated_options(formula, SceneObjects(scene))
    return Or(tuple([And(tuple([_literal(part) for part in option])) for option in options]))


def _literal(literal: Formula) -> Formula:
    """A literal as the reference sees it."""
    if isinstance(literal, Not):
        return Not(_literal(literal.operand))
    if not isinstance(literal, Atom):
        raise TypeError(f"{literal} is no condition of BDDL")
    return replace(literal, predicate=_IN_REFERENCE.get(literal.predicate, literal.predicate))
