"""Records of schema 1, which left it to the reader what an answer counts as in a summary of the reference.

The fields are those of schema 2. What schema 2 says as `Counted` is to be worked out: the reference counts
some unreadable plans twice, VirtualHome's additional steps by step and not by task, action goals in the order
of the data set, and the errors of a subgoal plan by entry, none of them where the plan only misses the goal.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pydantic import TypeAdapter, ValidationError

from eai.abilities import codec
from eai.abilities.misfit import misfit
from eai.abilities.protocol import Protocol
from eai.abilities.record import Record
from eai.abilities.subgoal_decomposition.verdict import SubgoalCategory, SubgoalVerdict
from eai.abilities.verdict import Counted, GoalTallies, PlanVerdict, Tally
from eai.errors import InputError
from eai.world.fault import FaultKind

SCHEMA = 1

_VIRTUALHOME = "virtualhome"
_RUNTIME_FAULTS = (FaultKind.WRONG_ORDER, FaultKind.MISSING_STEP, FaultKind.AFFORDANCE)


@dataclass(frozen=True, slots=True)
class _InDataSetOrder:
    """What a plan counts as with the action goals in the order of the data set."""

    success: bool
    action: Tally


@dataclass(frozen=True, slots=True)
class _Counting:
    """What a line says of how its plan is counted."""

    times_counted: int = 1
    data_set_order: _InDataSetOrder | None = None


def record_from_json(values: Mapping[str, Any]) -> Record:
    """The record that a JSON object of schema 1 is.

    Raises:
        InputError: it is not a record; the message names the field.
    """
    record = codec.record_from_json(values)
    verdict = record.verdict
    if record.protocol is not Protocol.EAI_1_0_5 or not isinstance(verdict, PlanVerdict):
        return record
    counted = counted_as(verdict, values, additional_by_step=record.domain == _VIRTUALHOME)
    return replace(record, verdict=replace(verdict, counted=counted))


def counted_as(
    verdict: PlanVerdict, values: Mapping[str, Any], *, additional_by_step: bool
) -> Counted | None:
    """What a verdict under `eai-1.0.5` counts as; None if it is excluded or has no goals.

    Args:
        verdict: the verdict as its line has it.
        values: the line.
        additional_by_step: whether each additional step of a plan counts.
    """
    if verdict.excluded is not None or verdict.goals is None:
        return None
    if isinstance(verdict, SubgoalVerdict):
        return Counted(bool(verdict.success), verdict.goals, _subgoal_errors(verdict))
    counting = _counting(values)
    errors = [] if verdict.error is None else [verdict.error.kind]
    if errors == [FaultKind.PARSING]:
        errors *= counting.times_counted
    additional = verdict.additional_steps or 0
    errors += [FaultKind.ADDITIONAL_STEP] * (additional if additional_by_step else bool(additional))
    in_order = counting.data_set_order
    if in_order is None:
        return Counted(bool(verdict.success), verdict.goals, _numbered(errors))
    goals: GoalTallies = verdict.goals._replace(action=in_order.action)
    return Counted(in_order.success, goals, _numbered(errors))


def _subgoal_errors(verdict: SubgoalVerdict) -> tuple[tuple[FaultKind, int], ...]:
    if verdict.category is SubgoalCategory.GOAL_UNREACHABLE:
        return ()
    if verdict.search is None:
        return _numbered([] if verdict.error is None else [verdict.error.kind])
    entries = [kind for kind in verdict.errors if kind in _RUNTIME_FAULTS]
    return _numbered([*entries, *([FaultKind.ADDITIONAL_STEP] if verdict.additional_steps else [])])


def _numbered(errors: list[FaultKind]) -> tuple[tuple[FaultKind, int], ...]:
    """How often each kind occurs, in the order of first mention."""
    return tuple((kind, errors.count(kind)) for kind in dict.fromkeys(errors))


def _counting(values: Mapping[str, Any]) -> _Counting:
    known = {name: values[name] for name in _Counting.__slots__ if name in values}
    try:
        return TypeAdapter(_Counting).validate_python(known)
    except ValidationError as error:
        raise InputError(f"field {misfit(error)}") from error
