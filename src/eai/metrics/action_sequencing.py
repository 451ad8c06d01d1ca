"""The paper's metrics of action sequencing (tables "trajectory evaluation" and "goal satisfaction")."""

from __future__ import annotations

from collections.abc import Mapping

from eai.abilities.protocol import Protocol
from eai.abilities.verdict import Tally, Verdict
from eai.metrics.goals import GOAL_COLUMNS, goal_rates, tallies_of
from eai.metrics.rate import Rate, share
from eai.world.fault import FaultKind

TRAJECTORY_COLUMNS = (
    "task_success",
    "execution_success",
    "parsing",
    "hallucination",
    "argument_number",
    "wrong_order",
    "missing_step",
    "affordance",
    "additional_step",
)
"""The columns of the paper's table "trajectory evaluation"."""

TABLE_COLUMNS = (*TRAJECTORY_COLUMNS, *GOAL_COLUMNS)
"""What a terminal shows: the paper's columns."""

_ENDING_FAULTS = (
    FaultKind.HALLUCINATION,
    FaultKind.ARGUMENT_NUMBER,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
    FaultKind.UNCATEGORISED,
)


def contribution(verdict: Verdict, domain: str, protocol: Protocol) -> dict[str, Rate]:
    """What one answer contributes to each rate.

    Under `eai-1.0.5` parsing errors count as often as the reference counts them, VirtualHome's additional
    steps are steps and not tasks, and action goals are taken in data set order, which a summary of the
    reference has only by chance (spec section d).
    """
    kind = None if verdict.error is None else verdict.error.kind
    additional = verdict.additional_steps or 0
    rates = {
        "task_success": share(_success(verdict)),
        "execution_success": share(verdict.executable),
        "parsing": share(_times_counted(verdict) if kind is FaultKind.PARSING else 0),
    }
    for fault in _ENDING_FAULTS:
        rates[fault.value] = share(kind is fault)
    counts_steps = protocol is Protocol.EAI_1_0_5 and domain == "virtualhome"
    rates["additional_step"] = share(additional if counts_steps else bool(additional))
    return {**rates, **goal_rates(_tallies(verdict))}


def _times_counted(verdict: Verdict) -> int:
    times = (verdict.details or {}).get("times_counted", 1)
    return times if isinstance(times, int) else 1


def _success(verdict: Verdict) -> bool:
    in_order = _in_data_set_order(verdict)
    return bool(verdict.success if in_order is None else in_order["success"])


def _tallies(verdict: Verdict) -> Mapping[str, Tally]:
    tallies = tallies_of(verdict)
    in_order = _in_data_set_order(verdict)
    if tallies and in_order is not None and isinstance(in_order["action"], list):
        return {**tallies, "action": Tally(*in_order["action"])}
    return tallies


def _in_data_set_order(verdict: Verdict) -> Mapping[str, object] | None:
    found = (verdict.details or {}).get("data_set_order")
    return found if isinstance(found, Mapping) else None
