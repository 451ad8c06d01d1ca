"""The metrics of a run, as its ability declares them, also by the number of attempts; and their average.

By the number of attempts they are what a run of an experiment would have come to, had it ended earlier. The
average performance of a model in a domain is as the paper has it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from eai.abilities.declaration import declaration_of, the_four
from eai.abilities.protocol import FOUR, Ability
from eai.abilities.record import Record
from eai.abilities.verdict import NOTHING as NO_SHARE
from eai.abilities.verdict import Shares, Verdict, of_all
from eai.data.grouping import grouped
from eai.results.certainty import Case
from eai.results.rate import NOTHING, Rate, total
from eai.results.table import Estimate


def summarise(verdicts: Sequence[Verdict], ability: Ability) -> dict[str, Rate]:
    """All metrics of the paper's tables for an ability, by name, over the verdicts that are not excluded.

    Metrics without any verdict are there all the same, as nothing of nothing.
    """
    declared = declaration_of(ability)
    nothing = dict.fromkeys(declared.contributions(declared.verdict()), NOTHING)
    return {**nothing, **total(contributions(verdicts, ability))}


def contributions(verdicts: Sequence[Verdict], ability: Ability) -> Iterator[Shares]:
    """The shares that each verdict of a run that is not excluded contributes to each metric, in order.

    They come one after the other: of a long run all at once are a great many small objects.
    """
    declared = declaration_of(ability)
    scored = [verdict for verdict in verdicts if verdict.excluded is None]
    void = dict.fromkeys((metric for verdict in scored for metric in declared.void(verdict)), NO_SHARE)
    shares = map(declared.contributions, scored)
    return ({**share, **void} for share in shares) if void else shares


def cases_of(records: Sequence[Record], ability: Ability) -> dict[str, list[Case]]:
    """The cases that the records of a run add to each metric, in order; excluded ones add nothing."""
    scored = [record for record in records if record.verdict.excluded is None]
    contributed = contributions([record.verdict for record in scored], ability)
    return grouped(
        (metric, Case(task, name, share))
        for record, shares in zip(scored, contributed, strict=True)
        for task, name in [(record.task_id, name_of(record))]
        for metric, share in shares.items()
    )


def name_of(record: Record) -> str:
    """The name that near copies of a task share; where it is not known, the task stands for itself."""
    return record.task_id if record.task is None else record.task.name


def share_of(records: Sequence[Record], counted: Sequence[bool]) -> Estimate:
    """The share of records that count."""
    cases = zip(records, counted, strict=True)
    return Estimate.of([Case(record.task_id, name_of(record), of_all(counts)) for record, counts in cases])


AVERAGE = "average_performance"
"""The name of the metric."""


Place: TypeAlias = tuple[Ability, str]
"""A metric of an ability."""


def average_weights(values: Mapping[Place, float | None] | None = None) -> dict[Place, float]:
    """How much each metric counts in the average: a quarter an ability, halved where it has two metrics.

    Args:
        values: what is known in percent; a metric that is declared to stand in the place of one of the
            paper's does so where it is known. Without values the metrics are the paper's.
    """
    known = values or {}
    weights: dict[Place, float] = {}
    for ability, declared in the_four().items():
        for metric in declared.averaged:
            place = ability, declared.instead.get(metric, metric)
            place = place if known.get(place) is not None else (ability, metric)
            weights[place] = 1 / (len(FOUR) * len(declared.averaged))
    return weights


def average_performance(values: Mapping[Place, float | None]) -> float | None:
    """The mean over the four abilities in percent, or None unless all are known.

    ``(goal F1 + subgoal task success + action task success + (operator F1 + planner success) / 2) / 4``: the
    paper's section "Average Performance". Where it is known which plans work, that rate stands in the place
    of planner success.

    Args:
        values: (ability, metric) -> percent.
    """
    total = 0.0
    for place, weight in average_weights(values).items():
        value = values.get(place)
        if value is None:
            return None
        total += weight * value
    return total


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
