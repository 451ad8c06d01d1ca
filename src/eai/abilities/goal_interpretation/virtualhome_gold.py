"""The goals of a VirtualHome task in the words of an answer."""

from __future__ import annotations

from typing import NamedTuple

from eai.abilities.goal_interpretation.written import RelationGoal, StateGoal
from eai.abilities.task import GoalKind, Task
from eai.benchmarks.virtualhome.tasks import PREDICATE_OF_RELATION
from eai.logic.formula import Atom, Formula, Occurs, Or

RELATION_OF_PREDICATE = {predicate: name for name, predicate in PREDICATE_OF_RELATION.items()}
"""How answers name the relations of the vocabulary."""


class GoldGoals(NamedTuple):
    """The goals of a task, without duplicates, in the order of the data set.

    Attributes:
        states: state goals, with the full names of objects (``sofa.352``).
        relations: relation goals, likewise.
        actions: the alternatives of each action goal.
    """

    states: tuple[StateGoal, ...]
    relations: tuple[RelationGoal, ...]
    actions: tuple[tuple[str, ...], ...]


def gold_goals(task: Task) -> GoldGoals:
    """The goals of a task."""
    states, relations = (
        [goal.formula for goal in task.goals_of(kind) if isinstance(goal.formula, Atom)]
        for kind in (GoalKind.STATE, GoalKind.RELATION)
    )
    return GoldGoals(
        tuple(StateGoal(atom.arguments[0].name, atom.predicate) for atom in states),
        tuple(
            RelationGoal(
                atom.arguments[0].name, RELATION_OF_PREDICATE[atom.predicate], atom.arguments[1].name
            )
            for atom in relations
        ),
        tuple(_alternatives(goal.formula) for goal in task.goals_of(GoalKind.ACTION)),
    )


def _alternatives(formula: Formula) -> tuple[str, ...]:
    operands = formula.operands if isinstance(formula, Or) else (formula,)
    return tuple(operand.action for operand in operands if isinstance(operand, Occurs))


def by_class(gold: GoldGoals) -> GoldGoals:
    """The same goals, with the classes of objects instead of their full names."""
    return GoldGoals(
        tuple(StateGoal(_class_of(name), state) for name, state in gold.states),
        tuple(
            RelationGoal(_class_of(name), relation, _class_of(other))
            for name, relation, other in gold.relations
        ),
        gold.actions,
    )


def _class_of(name: str) -> str:
    return name.rpartition(".")[0]
