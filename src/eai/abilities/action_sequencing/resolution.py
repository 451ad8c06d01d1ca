"""From what a model has written to what it means in a task: written steps as ground actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias, cast

from eai.abilities.action_sequencing.notation import PlanNotation
from eai.abilities.action_sequencing.plan import WrittenPlan, WrittenStep
from eai.abilities.verdict import ErrorReport
from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.fault import FaultKind

ObjectOf: TypeAlias = Callable[[object], int | None]
"""The index of the object that something written stands for, or None."""


def resolve(
    plan: WrittenPlan,
    domain: Domain,
    notation: PlanNotation,
    object_of: ObjectOf,
    stranger: str = "there is no",
) -> tuple[Action, ...] | ErrorReport:
    """A written plan as ground actions, or its first grammar error: of all names before of any arity.

    Args:
        plan: the plan.
        domain: whose operators are named.
        notation: what operators are called.
        object_of: what objects are called.
        stranger: what there is to say of what stands for no object, before its name.
    """
    arities, operator_of = domain.arities, notation.operator
    actions = []
    misapplied = None
    for number, step in enumerate(plan.steps):
        operator = operator_of(step.action)
        objects = tuple(map(object_of, step.objects))
        if operator not in arities or None in objects:
            detail = _unknown(step, operator in arities, objects, stranger)
            return ErrorReport(FaultKind.HALLUCINATION, number, detail)
        if misapplied is None and len(objects) != arities[operator]:
            detail = f"{operator} takes {arities[operator]} objects, not {len(objects)}"
            misapplied = ErrorReport(FaultKind.ARGUMENT_NUMBER, number, detail)
        actions.append(Action(operator, cast("tuple[int, ...]", objects)))
    return misapplied or tuple(actions)


def _unknown(step: WrittenStep, is_operator: bool, objects: tuple[int | None, ...], stranger: str) -> str:
    """What a step names that there is not: its action, or else its first such object."""
    if not is_operator:
        return f"{step.action} is not an action"
    return f"{step.action}: {stranger} {step.objects[objects.index(None)]}"
