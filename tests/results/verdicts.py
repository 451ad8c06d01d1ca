"""Verdicts for the tests of metrics and reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import ErrorReport, PlanVerdict, Verdict
from eai.results.record import Record
from eai.tasks.share import Share, TalliesByGoalKind
from eai.world.fault import FaultKind


def goals(
    state: tuple[float, float],
    relation: tuple[float, float] = (0, 0),
    action: tuple[float, float] = (0, 0),
) -> TalliesByGoalKind:
    """Return goal tallies by kind."""
    return TalliesByGoalKind(Share(*state), Share(*relation), Share(*action))


def failed(kind: FaultKind) -> PlanVerdict:
    """Return the verdict of a plan that an error ended."""
    return PlanVerdict(
        executable=False, success=False, error=ErrorReport(kind, 0, "why"), goals=goals((0, 1))
    )


SUCCEEDED = PlanVerdict(executable=True, success=True, goals=goals((1, 1)))
"""A plan that reaches its goal."""


def record(
    task_id: str,
    verdict: Verdict,
    *,
    ability: Ability = Ability.ACTION_SEQUENCING,
    model: str = "m",
    domain: str = "virtualhome",
    protocol: Protocol = Protocol.STRICT,
    response: str = "{}",
) -> Record:
    """Return a record with a verdict."""
    return Record(protocol, domain, ability, model, task_id, response, "0" * 64, verdict)


def whole(records: Sequence[Record]) -> tuple[Record, ...]:
    """Return the records as those of a suite without further tasks."""
    return tuple(replace(record, suite_size=len(records)) for record in records)
