"""The summary that a report keeps of a run: rates with intervals, and what its answers came to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.declaration import declaration_of
from eai.results.certainty import Cases, Certainty, certainty_of_rate
from eai.results.cost import Spending, cost_cases, sum_spending
from eai.results.coverage import Coverage, ErrataEffect
from eai.results.rate import Rate
from eai.results.runs import Run, RunKey
from eai.results.summary import Breakdown, break_down, cases_of
from eai.results.totals import Totals


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A run without its records.

    Attributes:
        coverage: how much of the suite is answered.
        excluded: reason -> how many tasks are left out of all rates for it.
        repaired: how many answers were read only after a repair.
        planners: what judged operators, by name; none where nothing did or older records do not say.
        errata: what errata of the data did to it; None if none were used.
        data_sha256: digests of the data that it was scored against, usually one.
        rates: metric -> rate.
        certainties: metric -> how sure the rate is, None where it is not defined.
        cases: main metric -> what each task adds to it.
        spent: what the answers took, as far as records say.
        per_success: what each answer took, and whether it is a success (`eai.results.cost.cost_cases`).
        unnamed: how many records do not say what their tasks are like, so that each task stands for itself.
    """

    key: RunKey
    coverage: Coverage
    excluded: Mapping[str, int]
    repaired: int
    planners: tuple[str, ...]
    errata: ErrataEffect | None
    data_sha256: tuple[str, ...]
    rates: Mapping[str, Rate]
    certainties: Mapping[str, Certainty | None]
    cases: Mapping[str, Cases]
    spent: Spending
    per_success: Mapping[str, Cases]
    unnamed: int
    breakdown: Breakdown


def plain_runs(runs: Sequence[RunSummary]) -> list[RunSummary]:
    """Those of the runs that are no experiments: what is ranked and set beside the paper's tables."""
    return [item for item in runs if item.key.is_plain]


def summary_of(run: Run) -> RunSummary:
    """The summary of a run."""
    key = run.key
    reasons = [record.verdict.excluded for record in run.records]
    totals, cases = Totals.from_records(run.records), cases_of(run.records, key.ability)
    return RunSummary(
        key,
        totals.coverage,
        dict(Counter(reason for reason in reasons if reason is not None)),
        sum(bool(record.repairs) for record in run.records),
        totals.planners,
        totals.errata,
        tuple(sorted({record.data_sha256 for record in run.records})),
        totals.counted,
        {metric: certainty_of_rate(found) for metric, found in cases.items()},
        {
            metric: found
            for metric, found in cases.items()
            if metric in declaration_of(key.ability).overview_headings
        },
        sum_spending(run.records),
        cost_cases(run.records),
        sum(record.task is None for record in run.records),
        break_down(run.records, key.ability),
    )
