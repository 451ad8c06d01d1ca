"""How sure a number is: intervals of rates and of their differences that know which tasks are near copies.

Tasks of one name succeed and fail together, so that 342 of them may say no more than 40 unlike ones would.
The unit of all intervals is therefore the *name*; the interval with the task as its unit stands beside it.
The design effect says how many times the variance grows by that, and 342 divided by it is the number of
tasks that they are worth.

An interval is Wilson's (1927) for the number of tasks that a rate is worth, which is right at 0 and at 100
percent too. Because that number is estimated, from few names, it is taken with care
and with Student's quantile: ``bench/coverage.py`` measures that the truth is within as often as is said, and
that percentiles of a bootstrap and Wilson's interval with the observed design effect hold it less often.

A rate is a ratio of sums over units. To first order its variance is the sum of the squares of what the units
add: the linearisation of cluster samples, and the limit of a bootstrap over units. That is too small where
units are few: a large one draws the rate to itself, and where all agree there is no variance at all. So a
unit counts by how far the rate is from what it would be without it (the jackknife), and two units of mean
size are thought to be there besides, each all right or all wrong with even chance. They move no rate, but are
part of its variance, as the two successes and two failures of Agresti and Coull (1998) are. Student's t is
for intervals whose variance is itself estimated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from statistics import NormalDist, fmean
from typing import NamedTuple, TypeAlias

from eai.results.rate import Rate
from eai.tasks.share import Share

_WIDEST = 1e4
_HALVINGS = 60


@lru_cache(maxsize=1024)
def two_sided_quantile(level: float, freedom: int) -> float:
    """How many standard errors to either side hold this share of the distribution.

    Args:
        level: the share, up to 0.999.
        freedom: degrees of freedom, at least 1.
    """
    low, high = 0.0, _WIDEST
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if _share_within(middle, freedom) < level:
            low = middle
        else:
            high = middle
    return high


def _share_within(width: float, freedom: int) -> float:
    """The share between ``-width`` and ``width``, a finite series (Abramowitz and Stegun, 26.7.3-4)."""
    angle = math.atan(width / math.sqrt(freedom))
    cosine, odd = math.cos(angle), freedom % 2
    term = cosine if odd else 1.0
    series = term if freedom > 1 else 0.0
    for power in range(2 + odd, freedom, 2):
        term *= cosine**2 * (power - 1) / power
        series += term
    value = math.sin(angle) * series
    return 2 / math.pi * (angle + value) if odd else value


_BESIDES = 2


@dataclass(frozen=True, slots=True)
class _Deviations:
    """A number, as a share of 1, with what each unit adds to its distance from the truth.

    Attributes:
        value: the number.
        centre: what it would be with the units besides, half of them right.
        of_units: unit -> what it adds; the sum is 0.
        of_besides: what a unit besides adds, in each of the cases of equal chance.
        weights: unit -> its part of the whole; they add up to 1.
    """

    value: float
    centre: float
    of_units: Mapping[str, float]
    of_besides: tuple[float, ...]
    weights: Mapping[str, float]

    @property
    def observed_variance(self) -> float:
        """The variance of the number, as the units alone say."""
        return sum(added * added for added in self.of_units.values())

    @property
    def variance(self) -> float:
        """The variance of the number, each unit left out in turn, with the units besides; never zero."""
        left_out = (
            added / (1 - self.weights[unit])
            for unit, added in self.of_units.items()
            if self.weights[unit] < 1
        )
        besides = _BESIDES * fmean(added * added for added in self.of_besides)
        return sum(change * change for change in left_out) + besides

    @property
    def freedom(self) -> int:
        """Degrees of freedom: the number of units of equal size that weigh the same (Kish), and one."""
        alike = 1 / sum(weight * weight for weight in self.weights.values())
        return math.floor(alike) + _BESIDES - 1


def deviations_of_rate(sums: Mapping[str, Share]) -> _Deviations | None:
    """The deviations of a rate; None if it is of nothing.

    Args:
        sums: what each unit adds to the rate.
    """
    parts = {unit: share for unit, share in sums.items() if share.denominator}
    whole, units = sum(share.denominator for share in parts.values()), len(parts)
    if not units:
        return None
    value = sum(share.numerator for share in parts.values()) / whole
    centre = (value * units + _BESIDES / 2) / (units + _BESIDES)
    return _Deviations(
        value,
        centre,
        {unit: (share.numerator - value * share.denominator) / whole for unit, share in parts.items()},
        ((1 - centre) / units, -centre / units),
        {unit: share.denominator / whole for unit, share in parts.items()},
    )


def deviations_of_mean(parts: Sequence[tuple[float, _Deviations]]) -> _Deviations:
    """The deviations of a mean of rates of the same units; a unit besides is right in all of them or in none.

    Args:
        parts: weight and rate; the weights add up to 1.
    """
    return _Deviations(
        sum(weight * each.value for weight, each in parts),
        sum(weight * each.centre for weight, each in parts),
        _weighted([(weight, each.of_units) for weight, each in parts]),
        tuple(sum(weight * each.of_besides[case] for weight, each in parts) for case in (0, 1)),
        _weighted([(weight, each.weights) for weight, each in parts]),
    )


def deviations_of_difference(first: _Deviations, second: _Deviations) -> _Deviations:
    """The deviations of second minus first; of a unit besides, each is right or wrong by itself."""
    return _Deviations(
        second.value - first.value,
        second.centre - first.centre,
        _weighted([(1, second.of_units), (-1, first.of_units)]),
        tuple(b - a for a, b in product(first.of_besides, second.of_besides)),
        _weighted([(0.5, first.weights), (0.5, second.weights)]),
    )


def _weighted(parts: Sequence[tuple[float, Mapping[str, float]]]) -> dict[str, float]:
    """The weighted sum of numbers by unit."""
    total: dict[str, float] = {}
    for weight, numbers in parts:
        for unit, number in numbers.items():
            total[unit] = total.get(unit, 0) + weight * number
    return total


LEVEL = 0.95
"""How often an interval holds the truth."""


class Interval(NamedTuple):
    """The bounds of an interval, in percent or, of a difference, in percentage points."""

    low: float
    high: float


class Case(NamedTuple):
    """The contribution of one task to a rate.

    Attributes:
        task: its id.
        name: what it shares with near copies of itself.
        share: what it adds to the rate.
    """

    task: str
    name: str
    share: Share


Cases: TypeAlias = Sequence[Case]


@dataclass(frozen=True, slots=True)
class Certainty:
    """How sure a number is.

    Attributes:
        interval: 95 %, with names as units.
        by_task: 95 %, as if all tasks were independent.
        tasks: how many tasks the number is made from.
        names: how many names they have.
        design_effect: how many times the variance is that of as many independent tasks, as observed; None
            where nothing varies.
    """

    interval: Interval
    by_task: Interval
    tasks: int
    names: int
    design_effect: float | None

    @property
    def effective_tasks(self) -> float | None:
        """How many independent tasks would be as sure: never more than there are."""
        return self.tasks / max(1.0, self.design_effect) if self.design_effect else None


def of_tasks(cases: Cases) -> dict[str, Share]:
    """The share that each task adds to a rate."""
    return _sums([(case.task, case.share) for case in cases])


def of_names(cases: Cases) -> dict[str, Share]:
    """The share that the tasks of each name add to a rate."""
    return _sums([(case.name, case.share) for case in cases])


def mean_over_names(cases: Cases) -> float | None:
    """The rate in percent if every name counted alike; None if it is of nothing."""
    rates = [Rate(*share).percent for share in of_names(cases).values() if share.denominator]
    return fmean(rate for rate in rates if rate is not None) if rates else None


def certainty_of_rate(cases: Cases) -> Certainty | None:
    """How sure a rate is; None if it is of nothing.

    Where a task can add more than one (errors that count several times), the rate is taken as a share of the
    most that any task adds.
    """
    most = max([1, *(share.numerator / share.denominator for _, _, share in cases if share.denominator)])
    if most == 1:
        return _certainty_of_share(cases)
    shares = (Share(case.share.numerator / most, case.share.denominator) for case in cases)
    found = _certainty_of_share([case._replace(share=s) for case, s in zip(cases, shares, strict=True)])
    if found is None:
        return None
    by_name, by_task = (Interval(low * most, high * most) for low, high in (found.interval, found.by_task))
    return replace(found, interval=by_name, by_task=by_task)


def _certainty_of_share(cases: Cases) -> Certainty | None:
    each_task, each_name = of_tasks(cases), of_names(cases)
    tasks = deviations_of_rate(each_task)
    names = tasks if len(each_name) == len(each_task) else deviations_of_rate(each_name)
    if tasks is None or names is None:
        return None
    yes_no = len(tasks.of_units) == len(cases) and all(case.share in _YES_NO for case in cases)
    return _certainty(_binomial(tasks) if yes_no else _within_one(tasks), _within_one(names), _wilson)


def certainty_of_mean(parts: Sequence[tuple[float, Cases]]) -> Certainty | None:
    """How sure a weighted mean of rates on the same tasks is; None if one of them is of nothing.

    Args:
        parts: weight and rate; the weights add up to 1.
    """
    tasks = [(weight, deviations_of_rate(of_tasks(cases))) for weight, cases in parts]
    names = [(weight, deviations_of_rate(of_names(cases))) for weight, cases in parts]
    known = [[(weight, rate) for weight, rate in rates if rate is not None] for rates in (tasks, names)]
    if len(known[0]) < len(parts):
        return None
    by_task, by_name = (_within_one(deviations_of_mean(rates)) for rates in known)
    return _certainty(by_task, by_name, _wilson)


def certainty_of_difference(first: Cases, second: Cases) -> Certainty | None:
    """How sure the difference of two rates on the same tasks is; None if one of them is of nothing.

    The intervals are in percentage points, symmetric around second minus first.
    """
    pairs = [
        (deviations_of_rate(sums(first)), deviations_of_rate(sums(second))) for sums in (of_tasks, of_names)
    ]
    known = [_as_is(deviations_of_difference(one, other)) for one, other in pairs if one and other]
    if len(known) < len(pairs):
        return None
    by_task, by_name = known
    return _certainty(by_task, by_name, _between_ones)


def interval_of_ratio(cases: Cases) -> Interval | None:
    """The interval of what a success costs: a ratio of sums, on the scale of its logarithm, by names.

    None if there is no success, nothing is spent, or one name alone.

    Args:
        cases: for each answer what it cost, and whether it is a success.
    """
    units = of_names(cases).values()
    spent, won = sum(unit.numerator for unit in units), sum(unit.denominator for unit in units)
    if not spent or not won or len(units) < 2:
        return None
    shifts = [unit.numerator / spent - unit.denominator / won for unit in units]
    variance = len(units) / (len(units) - 1) * sum(shift * shift for shift in shifts)
    half = two_sided_quantile(LEVEL, len(units) - 1) * math.sqrt(variance)
    return Interval(spent / won * math.exp(-half), spent / won * math.exp(half))


_YES_NO = (Share(0, 1), Share(1, 1))
_NORMAL = NormalDist().inv_cdf((1 + LEVEL) / 2)


class _Noise(NamedTuple):
    """The parts that an interval is made from.

    Attributes:
        value: the number, as a share of 1.
        variance: its own, or the inverse of the number of independent tasks that it is worth.
        observed: the variance of the number, as its units alone say.
        quantile: how many standard errors lie to either side.
        units: how many units the variance is from.
    """

    value: float
    variance: float
    observed: float
    quantile: float
    units: int


def _as_is(spread: _Deviations) -> _Noise:
    quantile = two_sided_quantile(LEVEL, spread.freedom)
    return _Noise(spread.value, spread.variance, spread.observed_variance, quantile, len(spread.of_units))


def _within_one(spread: _Deviations) -> _Noise:
    """The variance in multiples of that of one yes or no."""
    noise = _as_is(spread)
    return noise._replace(variance=noise.variance / (spread.centre * (1 - spread.centre)))


def _binomial(spread: _Deviations) -> _Noise:
    """The same of independent yes and no, where nothing has to be estimated."""
    units = len(spread.of_units)
    return _Noise(spread.value, 1 / units, spread.observed_variance, _NORMAL, units)


def _sums(shares: Sequence[tuple[str, Share]]) -> dict[str, Share]:
    last = dict(shares)
    if len(last) == len(shares):
        return last
    numerators, denominators = dict.fromkeys(last, 0.0), dict.fromkeys(last, 0.0)
    for unit, (numerator, denominator) in shares:
        numerators[unit] += numerator
        denominators[unit] += denominator
    return {unit: Share(numerators[unit], denominators[unit]) for unit in last}


def _certainty(tasks: _Noise, names: _Noise, bounds: Callable[[_Noise], Interval]) -> Certainty:
    """Names without copies are tasks; copies never say more than unlike tasks would."""
    if names.units == tasks.units:
        return Certainty(bounds(tasks), bounds(tasks), tasks.units, names.units, 1.0)
    return Certainty(
        bounds(names._replace(variance=max(names.variance, tasks.variance))),
        bounds(tasks),
        tasks.units,
        names.units,
        names.observed / tasks.observed if tasks.observed else None,
    )


def _wilson(noise: _Noise) -> Interval:
    value, spread = noise.value, noise.quantile**2 * noise.variance
    middle = (value + spread / 2) / (1 + spread)
    half = math.sqrt(spread * (value * (1 - value) + spread / 4)) / (1 + spread)
    return Interval(
        0.0 if value <= 0 else 100 * max(0.0, middle - half),
        100.0 if value >= 1 else 100 * min(1.0, middle + half),
    )


def _between_ones(noise: _Noise) -> Interval:
    half = noise.quantile * math.sqrt(noise.variance)
    return Interval(max(-100.0, 100 * (noise.value - half)), min(100.0, 100 * (noise.value + half)))
