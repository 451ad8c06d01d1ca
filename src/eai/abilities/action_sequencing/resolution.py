"""From what a model has written to what it means in a task: written steps as ground actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias, cast

from eai.abilities.action_sequencing.notation import PlanNotation
from eai.abilities.action_sequencing.plan import WrittenPlan, WrittenStep
from eai.abilities.error_report import UNKNOWN_ACTION
from eai.abilities.verdict import ErrorReport
from eai.logic.signature import MisuseKind
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
            return _unknown(number, step, operator in arities, objects, stranger)
        if misapplied is None and len(objects) != arities[operator]:
            detail = f"{operator} takes {arities[operator]} objects, not {len(objects)}"
            check = MisuseKind.WRONG_ARITY.value
            misapplied = ErrorReport(FaultKind.ARGUMENT_NUMBER, number, detail, check)
        actions.append(Action(operator, cast("tuple[int, ...]", objects)))
    return misapplied or tuple(actions)


def _unknown(
    number: int, step: WrittenStep, is_operator: bool, objects: tuple[int | None, ...], stranger: str
) -> ErrorReport:
    """What a step names that there is not: its action, or else its first such object."""
    if not is_operator:
        detail = f"{step.action} is not an action"
        return ErrorReport(FaultKind.HALLUCINATION, number, detail, UNKNOWN_ACTION)
    name = step.objects[objects.index(None)]
    detail, check = f"{step.action}: {stranger} {name}", MisuseKind.UNKNOWN_OBJECT.value
    return ErrorReport(FaultKind.HALLUCINATION, number, detail, check, (str(name),))
