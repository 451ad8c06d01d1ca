"""What a report keeps of a run: rates with intervals, and what its answers came to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from eai.abilities.declarations import DECLARATIONS
from eai.metrics.bootstrap import Bootstrap, Interval, Replicates
from eai.metrics.breakdown import Breakdown, break_down
from eai.metrics.coverage import Coverage, coverage_of
from eai.metrics.rate import Rate, total
from eai.metrics.summary import contributions
from eai.report.runs import Run, RunKey


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A run without its records.

    Attributes:
        coverage: how much of the suite is answered.
        excluded: reason -> how many tasks are left out of all rates for it.
        repaired: how many answers were read only after a repair.
        data_sha256: digests of the data that it was scored against, usually one.
        rates: metric -> rate.
        intervals: metric -> 95 % interval, None where the rate is not defined.
        averaged: the replicates of what enters the average over abilities.
    """

    key: RunKey
    coverage: Coverage
    excluded: Mapping[str, int]
    repaired: int
    data_sha256: tuple[str, ...]
    rates: Mapping[str, Rate]
    intervals: Mapping[str, Interval | None]
    averaged: Mapping[str, Replicates]
    breakdown: Breakdown


def summary_of(run: Run, bootstrap: Bootstrap) -> RunSummary:
    """What is kept of a run."""
    key = run.key
    verdicts = [record.verdict for record in run.records]
    scored = contributions(verdicts, key.ability)
    rates = total(scored)
    replicates = bootstrap.replicates(scored, list(rates))
    return RunSummary(
        key,
        coverage_of(run.records),
        dict(Counter(v.excluded for v in verdicts if v.excluded is not None)),
        sum(bool(record.repairs) for record in run.records),
        tuple(sorted({record.data_sha256 for record in run.records})),
        rates,
        {name: bootstrap.interval(values) for name, values in replicates.items()},
        {name: replicates[name] for name in DECLARATIONS[key.ability].averaged if name in replicates},
        break_down(run.records, key.ability),
    )
