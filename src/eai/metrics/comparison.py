"""Two runs on the same tasks: how much they differ, how surely, and on which tasks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.record import Record
from eai.abilities.share import Shares
from eai.metrics.bootstrap import Bootstrap, Interval
from eai.metrics.rate import Rate, total
from eai.metrics.summary import contributions


@dataclass(frozen=True, slots=True)
class Difference:
    """One metric in two runs, over the tasks that both answered.

    Attributes:
        metric: its name.
        first: the rate in the first run.
        second: the rate in the second run.
        interval: of second minus first, in percentage points, by paired bootstrap over tasks.
        p_value: exact McNemar for successes, else by paired bootstrap; two-sided.
        test: the name of the test.
        only_first: tasks that only the first run gets right; empty for metrics that are no yes or no.
        only_second: tasks that only the second run gets right.
    """

    metric: str
    first: Rate
    second: Rate
    interval: Interval | None
    p_value: float | None
    test: str
    only_first: tuple[str, ...] = ()
    only_second: tuple[str, ...] = ()

    @property
    def points(self) -> float | None:
        """Second minus first in percentage points."""
        if self.first.percent is None or self.second.percent is None:
            return None
        return self.second.percent - self.first.percent


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two runs of one ability in one domain under one protocol.

    Attributes:
        differing: tasks whose contribution to any of the ability's main metrics differs.
        only_in_first: tasks that only the first run has scored answers to; they are left out.
        only_in_second: tasks that only the second run has scored answers to.
    """

    differences: tuple[Difference, ...]
    tasks: int
    differing: tuple[str, ...]
    only_in_first: tuple[str, ...]
    only_in_second: tuple[str, ...]


def compare(first: Sequence[Record], second: Sequence[Record], bootstrap: Bootstrap) -> Comparison:
    """Compare two runs of the same ability, domain and protocol, each with at least one record.

    Tasks that either run excludes, or did not answer, are left out of both.
    """
    before, after = _by_task(first), _by_task(second)
    shared = [task for task in before if task in after]
    declared = DECLARATIONS[first[0].ability]
    columns = tuple(declared.main)
    ours, theirs = [before[task] for task in shared], [after[task] for task in shared]
    return Comparison(
        tuple(
            _difference(name, shared, ours, theirs, bootstrap, yes_no=name in declared.yes_no)
            for name in columns
        ),
        len(shared),
        tuple(t for t in shared if any(before[t].get(name) != after[t].get(name) for name in columns)),
        tuple(task for task in before if task not in after),
        tuple(task for task in after if task not in before),
    )


def mcnemar(only_first: int, only_second: int) -> float:
    """The exact two-sided p-value of McNemar's test from the numbers of discordant pairs.

    Under the null hypothesis a discordant pair falls to either side like a fair coin.
    """
    flips = only_first + only_second
    tail = sum(math.comb(flips, k) for k in range(min(only_first, only_second) + 1))
    return min(1.0, 2 * tail / (1 << flips))


def _by_task(records: Sequence[Record]) -> Mapping[str, Shares]:
    scored = [record for record in records if record.verdict.excluded is None]
    rates = contributions([r.verdict for r in scored], records[0].ability)
    return {record.task_id: rate for record, rate in zip(scored, rates, strict=True)}


def _difference(
    metric: str,
    tasks: Sequence[str],
    first: Sequence[Shares],
    second: Sequence[Shares],
    bootstrap: Bootstrap,
    *,
    yes_no: bool,
) -> Difference:
    """Compare one metric; the contributions are of the same tasks in the same order.

    McNemar's test applies where every task contributes a yes or a no.
    """
    whole, other = total(first).get(metric, Rate(0, 0)), total(second).get(metric, Rate(0, 0))
    pairs = zip(
        bootstrap.replicates(first, [metric])[metric],
        bootstrap.replicates(second, [metric])[metric],
        strict=True,
    )
    changes = [b - a for a, b in pairs if a is not None and b is not None]
    interval = bootstrap.interval(changes)
    if not yes_no:
        return Difference(metric, whole, other, interval, _two_sided(changes), "paired bootstrap")
    right = [bool(rates[metric].numerator) for rates in first]
    also = [bool(rates[metric].numerator) for rates in second]
    lost = tuple(task for task, a, b in zip(tasks, right, also, strict=True) if a and not b)
    won = tuple(task for task, a, b in zip(tasks, right, also, strict=True) if b and not a)
    p_value = mcnemar(len(lost), len(won))
    return Difference(metric, whole, other, interval, p_value, "exact McNemar", lost, won)


def _two_sided(changes: Sequence[float]) -> float | None:
    """Twice the share of replicates on the rarer side of zero, counting the observed run as one of them."""
    if not changes:
        return None
    rarer = min(sum(change <= 0 for change in changes), sum(change >= 0 for change in changes))
    return min(1.0, 2 * (rarer + 1) / (len(changes) + 1))
