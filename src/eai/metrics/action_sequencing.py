"""The paper's metrics of action sequencing (tables "trajectory evaluation" and "goal satisfaction")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from eai.abilities.protocol import Protocol
from eai.abilities.verdict import Tally, Verdict
from eai.metrics.rate import Rate
from eai.world.fault import FaultKind

TABLE_COLUMNS = (
    "task_success",
    "execution_success",
    "parsing",
    "hallucination",
    "argument_number",
    "wrong_order",
    "missing_step",
    "affordance",
    "additional_step",
    "state_goal",
    "relation_goal",
    "action_goal",
    "total_goal",
)
"""What a terminal shows: the paper's columns."""

_ENDING_FAULTS = (
    FaultKind.HALLUCINATION,
    FaultKind.ARGUMENT_NUMBER,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
    FaultKind.UNCATEGORISED,
)


def summarise(verdicts: Sequence[Verdict], protocol: Protocol) -> dict[str, Rate]:
    """All rates over the verdicts that are not excluded.

    Under `eai-1.0.5` parsing errors count as often as the reference counts them, additional steps are steps
    and not tasks, and action goals are taken in data set order, which a summary of the reference has only by
    chance (spec section d).
    """
    scored = [v for v in verdicts if v.excluded is None]
    as_in_reference = protocol is Protocol.EAI_1_0_5
    count = len(scored)
    additional = sum(
        (v.additional_steps or 0) if as_in_reference else bool(v.additional_steps) for v in scored
    )
    parsing = [v for v in scored if _kind(v) is FaultKind.PARSING]
    rates = {
        "task_success": Rate(sum(_success(v) for v in scored), count),
        "execution_success": Rate(sum(bool(v.executable) for v in scored), count),
        "parsing": Rate(sum(_times_counted(v) for v in parsing), count),
    }
    for kind in _ENDING_FAULTS:
        rates[kind.value] = Rate(sum(_kind(v) is kind for v in scored), count)
    rates["additional_step"] = Rate(additional, count)
    return {**rates, **goal_rates(scored)}


def goal_rates(verdicts: Sequence[Verdict]) -> dict[str, Rate]:
    """Satisfied goals by kind, and in total."""
    tallies = [_tallies(v) for v in verdicts]
    rates = {
        f"{kind}_goal": _sum([tally[kind] for tally in tallies]) for kind in ("state", "relation", "action")
    }
    rates["total_goal"] = _sum([part for tally in tallies for part in tally.values()])
    return rates


def _sum(tallies: Sequence[Tally]) -> Rate:
    return Rate(sum(t.satisfied for t in tallies), sum(t.total for t in tallies))


def _kind(verdict: Verdict) -> FaultKind | None:
    return None if verdict.error is None else verdict.error.kind


def _times_counted(verdict: Verdict) -> int:
    times = (verdict.details or {}).get("times_counted", 1)
    return times if isinstance(times, int) else 1


def _success(verdict: Verdict) -> bool:
    in_order = _in_data_set_order(verdict)
    return bool(verdict.success if in_order is None else in_order["success"])


def _tallies(verdict: Verdict) -> dict[str, Tally]:
    if verdict.goals is None:
        return {}
    in_order = _in_data_set_order(verdict)
    tallies = verdict.goals._asdict()
    if in_order is not None and isinstance(in_order["action"], list):
        tallies["action"] = Tally(*in_order["action"])
    return tallies


def _in_data_set_order(verdict: Verdict) -> Mapping[str, object] | None:
    found = (verdict.details or {}).get("data_set_order")
    return found if isinstance(found, Mapping) else None
