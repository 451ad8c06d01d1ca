"""Compares two runs on the same tasks: difference, confidence intervals, and the tasks that differ.

Randomisation tests exchange, unit by unit, the answers of the two runs with even chance. If the runs are
equally good, their difference is distributed like the differences after such exchanges. A unit is a task, or
all tasks with one name, because near copies of a task have the same name. With tasks as units and a yes or no
from each, the test is McNemar's.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import compress

from eai.abilities.declaration import get_declaration
from eai.abilities.verdict import EMPTY_SHARE, ShareByMetric
from eai.results.certainty import (
    ConfidenceIntervals,
    TaskRateContribution,
    TaskRateContributions,
    compute_difference_intervals,
    sum_shares_by_task,
    sum_shares_by_task_name,
)
from eai.results.rate import Rate, compute_rate
from eai.results.record import Record
from eai.results.summary import compute_metric_contributions_by_task, find_task_name
from eai.tasks.share import Share

SEED = 20240901
REPETITIONS = 5000


_ROUNDING = 1e-12


def compute_sign_flip_p(differences: Sequence[int]) -> float:
    """Return the exact two-sided p value of a sum of differences (sign-flip test).

    Under the null hypothesis, each difference is positive or negative with equal probability.

    Args:
        differences: for each unit (a task or a name), how many more of its tasks are right in the second run
            than in the first run.
    """
    counts = Counter({0: 1})
    sizes = Counter(abs(difference) for difference in differences if difference)
    for size, units in sizes.items():
        earlier, counts = counts, Counter()
        for total, count in earlier.items():
            for flips in range(units + 1):
                counts[total + size * (2 * flips - units)] += count * math.comb(units, flips)
    observed = abs(sum(differences))
    return sum(count for total, count in counts.items() if abs(total) >= observed) / sum(counts.values())


def compute_permutation_p_value(first: Sequence[Share], second: Sequence[Share]) -> float | None:
    """Return the two-sided p value of the difference of two rates, from random exchanges of answers.

    The result is None if a denominator is zero. Exchanges are drawn with a fixed seed. The runs as they are
    count as one more draw, so that no p value is zero.

    Args:
        first: for each unit (a task or a name), the numerator and denominator that it adds to the first rate.
        second: for the same units in the same order, the numerator and denominator for the second rate.
    """
    sums = (_add_shares(first), _add_shares(second))
    if not sums[0].denominator or not sums[1].denominator:
        return None
    observed = _compute_absolute_rate_difference(*sums)
    gains = [b.numerator - a.numerator for a, b in zip(first, second, strict=True)]
    growths = [b.denominator - a.denominator for a, b in zip(first, second, strict=True)]
    generator = random.Random(SEED)  # noqa: S311 - statistics, not secrets
    extreme = 1
    for _ in range(REPETITIONS):
        heads = generator.choices((0, 1), k=len(gains))
        gain, growth = sum(compress(gains, heads)), sum(compress(growths, heads))
        one = Share(sums[0].numerator + gain, sums[0].denominator + growth)
        other = Share(sums[1].numerator - gain, sums[1].denominator - growth)
        extreme += _compute_absolute_rate_difference(one, other) >= observed - _ROUNDING
    return extreme / (REPETITIONS + 1)


def _add_shares(shares: Sequence[Share]) -> Share:
    return Share(sum(share.numerator for share in shares), sum(share.denominator for share in shares))


def _compute_absolute_rate_difference(one: Share, other: Share) -> float:
    """Return the absolute difference of two rates; infinite if a denominator is zero."""
    if not one.denominator or not other.denominator:
        return math.inf
    return abs(other.numerator / other.denominator - one.numerator / one.denominator)


@dataclass(frozen=True, slots=True)
class MetricDifference:
    """One metric in two runs, on the tasks that both runs answered.

    The p values are two-sided, of tests that exchange the runs' answers at random (`eai.results.comparison`).
    They are exact if each task contributes 0 or 1.

    Attributes:
        first: the rate in the first run.
        second: the rate in the second run.
        certainty: confidence intervals of second minus first, in percentage points; None if no task
            contributes.
        p_value: p value of the test that exchanges all tasks with the same name together.
        p_by_task: p value of the test that exchanges each task alone, as if all were independent.
        yes_no: whether each task contributes 0 or 1; then the test by task is McNemar's.
        only_first: tasks that only the first run gets right; empty for metrics without yes or no.
        only_second: tasks that only the second run gets right.
    """

    first: Rate
    second: Rate
    certainty: ConfidenceIntervals | None
    p_value: float | None
    p_by_task: float | None
    yes_no: bool
    only_first: tuple[str, ...] = ()
    only_second: tuple[str, ...] = ()

    @property
    def percentage_points(self) -> float | None:
        """Rate of the second run minus rate of the first run, in percentage points.

        It is None if a run has no tasks to which the metric applies.
        """
        if self.first.percent is None or self.second.percent is None:
            return None
        return self.second.percent - self.first.percent


@dataclass(frozen=True, slots=True)
class RunComparison:
    """Comparison of two runs of one ability in one domain under one protocol (scoring rules).

    Attributes:
        differences: the difference of each main metric.
        tasks: number of tasks with scored answers in both runs.
        names: number of different names of these tasks.
        only_in_first: tasks with scored answers in the first run only; the comparison leaves them out.
        only_in_second: tasks with scored answers in the second run only; the comparison leaves them out.
    """

    differences: Mapping[str, MetricDifference]
    tasks: int
    names: int
    only_in_first: tuple[str, ...]
    only_in_second: tuple[str, ...]


def compare_runs(first: Sequence[Record], second: Sequence[Record]) -> RunComparison:
    """Compare two runs of one ability, domain and protocol (scoring rules), each with at least one record.

    The comparison leaves out a task that one of the runs excludes or lacks. It also leaves out an id that
    names different tasks in the two runs. A missing answer counts as a failure.
    """
    first_shares = compute_metric_contributions_by_task(first)
    second_shares = compute_metric_contributions_by_task(second)
    named = {record.task_id: find_task_name(record) for record in (*first, *second) if record.task}
    declared = get_declaration(first[0].ability)
    verdicts = {record.task_id: record.verdict for record in first}
    shared = [record for record in second if record.task_id in verdicts]
    different = {r.task_id for r in shared if not declared.is_same_task(verdicts[r.task_id], r.verdict)}
    names = {
        task: named.get(task, task)
        for task in first_shares
        if task in second_shares and task not in different
    }
    contributions_by_metric = {
        metric: [_make_task_contributions(metric, names, shares) for shares in (first_shares, second_shares)]
        for metric in declared.overview_headings
    }
    return RunComparison(
        {
            metric: compare_metric(*contributions, yes_no=metric in declared.yes_no_metrics)
            for metric, contributions in contributions_by_metric.items()
        },
        len(names),
        len(set(names.values())),
        tuple(task for task in first_shares if task not in names),
        tuple(task for task in second_shares if task not in names),
    )


def _make_task_contributions(
    metric: str, task_name_by_id: Mapping[str, str], shares_by_task: Mapping[str, ShareByMetric]
) -> TaskRateContributions:
    return [
        TaskRateContribution(task, name, shares_by_task[task].get(metric, EMPTY_SHARE))
        for task, name in task_name_by_id.items()
    ]


_WRONG_AND_RIGHT_NUMERATOR = (0, 1)
"""Possible numerators of one answer in a metric without partial credit: 0 if wrong, 1 if right."""


def compare_metric(
    first: TaskRateContributions, second: TaskRateContributions, *, yes_no: bool
) -> MetricDifference:
    """Compare one metric of two runs on the same tasks in the same order.

    Args:
        first: contribution of each task in the first run.
        second: contribution of each task in the second run.
        yes_no: whether the metric counts a single answer as 0 or 1. With several answers to a task, the
            contribution of the task may still be a fraction.
    """
    yes_no = yes_no and all(
        contribution.share.numerator in _WRONG_AND_RIGHT_NUMERATOR for contribution in (*first, *second)
    )
    right_in_first, right_in_second = (
        [bool(contribution.share.numerator) for contribution in contributions]
        for contributions in (first, second)
    )
    changed = [
        (contribution.task, b)
        for contribution, a, b in zip(first, right_in_first, right_in_second, strict=True)
        if yes_no and a != b
    ]
    p_value = _compute_exact_p_value if yes_no else compute_permutation_p_value
    return MetricDifference(
        compute_rate(contribution.share for contribution in first),
        compute_rate(contribution.share for contribution in second),
        compute_difference_intervals(first, second),
        p_value([*sum_shares_by_task_name(first).values()], [*sum_shares_by_task_name(second).values()]),
        p_value([*sum_shares_by_task(first).values()], [*sum_shares_by_task(second).values()]),
        yes_no,
        tuple(task for task, won in changed if not won),
        tuple(task for task, won in changed if won),
    )


def _compute_exact_p_value(first: Sequence[Share], second: Sequence[Share]) -> float:
    return compute_sign_flip_p([round(b.numerator - a.numerator) for a, b in zip(first, second, strict=True)])
