"""How the published replanning run was counted (``eval_action.py``, ``end_to_end_action_eval``).

Its script, which the package lost, counts the errors of the third and last attempt alone. A success before
it counts none, although under ``eai-1.0.5`` a plan that reaches all goals and then fails is a success: such a
task is neither executable nor an error, and stands in no column. The paper's table has three of them.
"""

from __future__ import annotations

from dataclasses import replace

from eai.abilities.record import Record
from eai.abilities.verdict import PlanVerdict


def counted_as_published(record: Record) -> Record:
    """The record of an experiment without the errors of a success that is not the last possible attempt."""
    if record.experiment is None or not record.attempts:
        return record
    early = record.attempts[: record.experiment.replans]
    attempts = (
        *[replace(attempt, verdict=_without_errors(attempt.verdict)) for attempt in early],
        *record.attempts[len(early) :],
    )
    return replace(record, attempts=attempts, verdict=attempts[-1].verdict)


def _without_errors(verdict: PlanVerdict) -> PlanVerdict:
    if not verdict.success:
        return verdict
    counted = verdict.counted and replace(verdict.counted, errors=())
    return replace(verdict, error=None, additional_steps=0, counted=counted)
