"""Metrics by the number of attempts: what a run of an experiment would have come to, had it ended earlier."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from eai.abilities.record import Record
from eai.results.rate import Rate
from eai.results.summary import summarise


def after(record: Record, attempts: int) -> Record:
    """The record as it would be if a task had no more attempts than so many; one without any is as it is."""
    made = record.attempts[:attempts]
    if not made:
        return record
    last = made[-1]
    return replace(
        record, response=last.response, verdict=last.verdict, explanation=last.explanation, attempts=made
    )


def most_attempts(records: Sequence[Record]) -> int:
    """How many attempts the tasks of a run could have; 0 where answers were not carried out."""
    if not any(record.attempts for record in records):
        return 0
    return max(1 + record.experiment.replans for record in records if record.experiment is not None)


def by_attempt(records: Sequence[Record]) -> list[Mapping[str, Rate]]:
    """The metrics of a run by the number of attempts, from 1 on.

    The errors are those of the last attempt that was made. Success never falls: a trial ends with it.
    """
    return [
        summarise([after(record, number).verdict for record in records], records[0].ability)
        for number in range(1, most_attempts(records) + 1)
    ]
