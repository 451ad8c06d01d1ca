"""Two runs on the same tasks: how much they differ, how surely, and on which tasks.

Randomisation tests ask what if a coin decided, unit by unit, which run gave which answers: under the
hypothesis that the runs are alike their difference varies like that, whatever the tasks are like. Units are
names or tasks; with tasks as units, and a yes or no from each, the test is McNemar's.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import compress

from eai.abilities.declaration import declaration_of
from eai.abilities.verdict import EMPTY_SHARE, Shares
from eai.results.certainty import Case, Cases, Certainty, certainty_of_difference, sum_by_name, sum_by_task
from eai.results.rate import Rate, rate_of
from eai.results.record import Record
from eai.results.summary import name_of, shares_by_task
from eai.tasks.share import Share

SEED = 20240901
REPETITIONS = 5000


_ROUNDING = 1e-12


def sign_flip_p(differences: Sequence[int]) -> float:
    """The exact two-sided p value of a sum of differences, each of which could as well have the other sign.

    Args:
        differences: for each unit, how many more tasks the second run gets right than the first.
    """
    ways = Counter({0: 1})
    sizes = Counter(abs(difference) for difference in differences if difference)
    for size, units in sizes.items():
        before, ways = ways, Counter()
        for total, count in before.items():
            for up in range(units + 1):
                ways[total + size * (2 * up - units)] += count * math.comb(units, up)
    observed = abs(sum(differences))
    return sum(count for total, count in ways.items() if abs(total) >= observed) / sum(ways.values())


def exchange_p(first: Sequence[Share], second: Sequence[Share]) -> float | None:
    """The two-sided p value of a difference of two rates by random exchanges; None if a rate is of nothing.

    Exchanges are drawn with a fixed seed. The runs as they are count as one, so that no value is zero.

    Args:
        first: what each unit adds to the first rate.
        second: what the same units add to the second.
    """
    sums = (_sum(first), _sum(second))
    if not sums[0].denominator or not sums[1].denominator:
        return None
    observed = _distance(*sums)
    gains = [b.numerator - a.numerator for a, b in zip(first, second, strict=True)]
    growths = [b.denominator - a.denominator for a, b in zip(first, second, strict=True)]
    generator = random.Random(SEED)  # noqa: S311 - statistics, not secrets
    extreme = 1
    for _ in range(REPETITIONS):
        heads = generator.choices((0, 1), k=len(gains))
        gain, growth = sum(compress(gains, heads)), sum(compress(growths, heads))
        one = Share(sums[0].numerator + gain, sums[0].denominator + growth)
        other = Share(sums[1].numerator - gain, sums[1].denominator - growth)
        extreme += _distance(one, other) >= observed - _ROUNDING
    return extreme / (REPETITIONS + 1)


def _sum(shares: Sequence[Share]) -> Share:
    return Share(sum(share.numerator for share in shares), sum(share.denominator for share in shares))


def _distance(one: Share, other: Share) -> float:
    """How far two rates are apart; one of nothing is as far as can be from the other."""
    if not one.denominator or not other.denominator:
        return math.inf
    return abs(other.numerator / other.denominator - one.numerator / one.denominator)


@dataclass(frozen=True, slots=True)
class MetricDifference:
    """One metric in two runs, over the tasks that both answered.

    The p values are two-sided, of tests in which a coin decides which run gave which answers
    (`eai.results.comparison`). Where each task contributes a yes or a no they are exact.

    Attributes:
        first: the rate in the first run.
        second: the rate in the second run.
        certainty: how sure second minus first is, in percentage points.
        p_value: of the test in which the tasks of a name share a coin.
        p_by_task: of the test in which each task has its own, as if all were independent.
        yes_no: whether each task contributes a yes or a no; then the test by task is McNemar's.
        only_first: tasks that only the first run gets right; empty for metrics that are no yes or no.
        only_second: tasks that only the second run gets right.
    """

    first: Rate
    second: Rate
    certainty: Certainty | None
    p_value: float | None
    p_by_task: float | None
    yes_no: bool
    only_first: tuple[str, ...] = ()
    only_second: tuple[str, ...] = ()

    @property
    def points(self) -> float | None:
        """Second minus first in percentage points."""
        if self.first.percent is None or self.second.percent is None:
            return None
        return self.second.percent - self.first.percent


@dataclass(frozen=True, slots=True)
class RunComparison:
    """Two runs of one ability in one domain under one protocol.

    Attributes:
        differences: by each main metric.
        tasks: how many tasks both runs have scored answers to.
        names: how many names these have.
        only_in_first: tasks that only the first run has scored answers to; they are left out.
        only_in_second: tasks that only the second run has scored answers to.
    """

    differences: Mapping[str, MetricDifference]
    tasks: int
    names: int
    only_in_first: tuple[str, ...]
    only_in_second: tuple[str, ...]


def compare(first: Sequence[Record], second: Sequence[Record]) -> RunComparison:
    """Compare two runs of the same ability, domain and protocol, each with at least one record.

    Tasks that either run excludes, or was not asked, or that are other ones of the same id, are left out of
    both; a missing answer counts as a failure, as everywhere.
    """
    before, after = shares_by_task(first), shares_by_task(second)
    known = {record.task_id: name_of(record) for record in (*first, *second) if record.task}
    declared = declaration_of(first[0].ability)
    verdicts = {record.task_id: record.verdict for record in first}
    shared = [record for record in second if record.task_id in verdicts]
    others = {r.task_id for r in shared if not declared.is_same_task(verdicts[r.task_id], r.verdict)}
    names = {task: known.get(task, task) for task in before if task in after and task not in others}
    sides = {
        metric: [_cases(metric, names, shares) for shares in (before, after)]
        for metric in declared.overview_headings
    }
    return RunComparison(
        {
            metric: compare_metric(*cases, yes_no=metric in declared.yes_no_metrics)
            for metric, cases in sides.items()
        },
        len(names),
        len(set(names.values())),
        tuple(task for task in before if task not in names),
        tuple(task for task in after if task not in names),
    )


def _cases(metric: str, names: Mapping[str, str], shares: Mapping[str, Shares]) -> Cases:
    return [Case(task, name, shares[task].get(metric, EMPTY_SHARE)) for task, name in names.items()]


_WHOLE = (0, 1)
"""The additions of a yes and a no to a rate."""


def compare_metric(first: Cases, second: Cases, *, yes_no: bool) -> MetricDifference:
    """Compare one metric on the same tasks in the same order.

    Args:
        first: what each task adds to it in the first run.
        second: the same in the second run.
        yes_no: whether each answer contributes a yes or a no; of a mean over several a task need not.
    """
    yes_no = yes_no and all(case.share.numerator in _WHOLE for case in (*first, *second))
    right, also = ([bool(case.share.numerator) for case in cases] for cases in (first, second))
    changed = [(case.task, b) for case, a, b in zip(first, right, also, strict=True) if yes_no and a != b]
    p_value = _sign_flip_p if yes_no else exchange_p
    return MetricDifference(
        rate_of(case.share for case in first),
        rate_of(case.share for case in second),
        certainty_of_difference(first, second),
        p_value([*sum_by_name(first).values()], [*sum_by_name(second).values()]),
        p_value([*sum_by_task(first).values()], [*sum_by_task(second).values()]),
        yes_no,
        tuple(task for task, won in changed if not won),
        tuple(task for task, won in changed if won),
    )


def _sign_flip_p(first: Sequence[Share], second: Sequence[Share]) -> float:
    return sign_flip_p([round(b.numerator - a.numerator) for a, b in zip(first, second, strict=True)])
