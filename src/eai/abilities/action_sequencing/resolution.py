"""From what a model has written to what it means in a task: written steps as ground actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from eai.abilities.action_sequencing.notation import PlanNotation
from eai.abilities.action_sequencing.plan import WrittenPlan
from eai.abilities.error_report import UNKNOWN_ACTION
from eai.abilities.verdict import ErrorReport
from eai.logic.signature import MisuseKind, takes
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
        if operator not in arities:
            detail = f"{step.action} is not an action"
            return ErrorReport(FaultKind.HALLUCINATION, number, detail, UNKNOWN_ACTION)
        objects = []
        for name in step.objects:
            index = object_of(name)
            if index is None:
                return _unknown(number, f"{step.action}: {stranger} {name}", str(name))
            objects.append(index)
        if misapplied is None and len(objects) != arities[operator]:
            detail = f"{takes(operator, arities[operator], 'object')}, not {len(objects)}"
            check = MisuseKind.WRONG_ARITY.value
            misapplied = ErrorReport(FaultKind.ARGUMENT_NUMBER, number, detail, check)
        actions.append(Action(operator, tuple(objects)))
    return misapplied or tuple(actions)


def _unknown(number: int, detail: str, name: str) -> ErrorReport:
    """A step names an object that there is not."""
    return ErrorReport(FaultKind.HALLUCINATION, number, detail, MisuseKind.UNKNOWN_OBJECT.value, (name,))
