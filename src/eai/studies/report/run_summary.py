"""Summarize a run for a report: rates with intervals, outcomes of answers, and cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.declaration import get_declaration
from eai.results.certainty import ConfidenceIntervals, TaskRateContributions, compute_rate_intervals
from eai.results.cost import Spending, group_costs_and_successes_by_cost_unit, sum_spending
from eai.results.coverage import TaskCoverageByAnswers, TasksChangedByErrata
from eai.results.rate import Rate
from eai.results.runs import Run, RunKey
from eai.results.summary import AnswerBreakdown, break_down_records, make_contributions_by_metric
from eai.results.totals import RunTotals


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A summary of a run that replaces the run's records (stored verdicts on answers) in reports.

    Attributes:
        coverage: share of the suite's tasks that are answered.
        excluded: reason -> number of tasks that it excludes from all rates.
        repaired: number of answers whose text had to be corrected before it could be read.
        planners: names of the planners that judged operators; empty without such verdicts, or in older
            records.
        errata: effect of corrections of the data set; None without corrections.
        data_sha256: digests of the data that answers were scored against, usually one.
        rates: metric -> rate.
        certainties: metric -> interval of the rate; None if no interval is defined.
        cases: main metric -> numerator and denominator that each task adds.
        spent: tokens and cost of the answers; answers without recorded numbers add nothing.
        per_success: effort and success of each answer
            (`eai.results.cost.group_costs_and_successes_by_cost_unit`).
        unnamed: number of records without the name of their task; each such task counts as independent.
    """

    key: RunKey
    coverage: TaskCoverageByAnswers
    excluded: Mapping[str, int]
    repaired: int
    planners: tuple[str, ...]
    errata: TasksChangedByErrata | None
    data_sha256: tuple[str, ...]
    rates: Mapping[str, Rate]
    certainties: Mapping[str, ConfidenceIntervals | None]
    cases: Mapping[str, TaskRateContributions]
    spent: Spending
    per_success: Mapping[str, TaskRateContributions]
    unnamed: int
    breakdown: AnswerBreakdown


def select_runs_with_standard_rules_and_no_study(runs: Sequence[RunSummary]) -> list[RunSummary]:
    """Return the runs without study options and with standard game rules.

    Only these are ranked and compared with the paper.
    """
    return [item for item in runs if item.key.has_standard_rules_and_no_study_options]


def summarize_run(run: Run) -> RunSummary:
    """Return the summary of a run, computed from its records (stored verdicts on answers)."""
    key = run.key
    reasons = [record.verdict.excluded for record in run.records]
    totals = RunTotals.from_records(run.records)
    cases = make_contributions_by_metric(run.records, key.ability)
    return RunSummary(
        key,
        totals.coverage,
        dict(Counter(reason for reason in reasons if reason is not None)),
        sum(bool(record.all_answer_repairs) for record in run.records),
        totals.planners,
        totals.errata,
        tuple(sorted({record.data_sha256 for record in run.records})),
        totals.rates_of_applicable_metrics,
        {metric: compute_rate_intervals(shares) for metric, shares in cases.items()},
        {
            metric: shares
            for metric, shares in cases.items()
            if metric in get_declaration(key.ability).overview_headings
        },
        sum_spending(run.records),
        group_costs_and_successes_by_cost_unit(run.records),
        sum(record.task is None for record in run.records),
        break_down_records(run.records, key.ability),
    )
