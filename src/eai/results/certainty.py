"""How sure a number is: intervals of rates and of their differences that know which tasks are near copies.

Tasks of one name succeed and fail together, so that 342 of them may say no more than 40 unlike ones would.
The unit of all intervals is therefore the *name*; the interval with the task as its unit stands beside it.
The design effect says how many times the variance grows by that, and 342 divided by it is the number of
tasks that they are worth.

An interval is Wilson's (1927) for the number of tasks that a rate is worth, which is right at 0 and at 100
percent too. Because that number is estimated, from few names, it is taken with care (`eai.results.deviation`)
and with Student's quantile: ``bench/coverage.py`` measures that the truth is within as often as is said, and
that percentiles of a bootstrap and Wilson's interval with the observed design effect hold it less often.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist, fmean
from typing import NamedTuple, TypeAlias

from eai.abilities.share import Share
from eai.results import deviation
from eai.results.deviation import Deviations
from eai.results.rate import Rate
from eai.results.student import two_sided_quantile

LEVEL = 0.95
"""How often an interval holds the truth."""


class Interval(NamedTuple):
    """The bounds of an interval, in percent or, of a difference, in percentage points."""

    low: float
    high: float


class Case(NamedTuple):
    """What one task contributes to a rate.

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
        """How many independent tasks would be as sure."""
        return self.tasks / self.design_effect if self.design_effect else None


def of_tasks(cases: Cases) -> dict[str, Share]:
    """What each task adds to a rate."""
    return _sums([(case.task, case.share) for case in cases])


def of_names(cases: Cases) -> dict[str, Share]:
    """What the tasks of each name add to a rate."""
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
    tasks = deviation.of_rate(each_task)
    names = tasks if len(each_name) == len(each_task) else deviation.of_rate(each_name)
    if tasks is None or names is None:
        return None
    yes_no = len(tasks.of_units) == len(cases) and all(case.share in _YES_NO for case in cases)
    return _certainty(_binomial(tasks) if yes_no else _within_one(tasks), _within_one(names), _wilson)


def certainty_of_mean(parts: Sequence[tuple[float, Cases]]) -> Certainty | None:
    """How sure a weighted mean of rates on the same tasks is; None if one of them is of nothing.

    Args:
        parts: weight and rate; the weights add up to 1.
    """
    tasks = [(weight, deviation.of_rate(of_tasks(cases))) for weight, cases in parts]
    names = [(weight, deviation.of_rate(of_names(cases))) for weight, cases in parts]
    known = [[(weight, rate) for weight, rate in rates if rate is not None] for rates in (tasks, names)]
    if len(known[0]) < len(parts):
        return None
    by_task, by_name = (_within_one(deviation.mean(rates)) for rates in known)
    return _certainty(by_task, by_name, _wilson)


def certainty_of_difference(first: Cases, second: Cases) -> Certainty | None:
    """How sure the difference of two rates on the same tasks is; None if one of them is of nothing.

    The intervals are in percentage points, symmetric around second minus first.
    """
    pairs = [
        (deviation.of_rate(sums(first)), deviation.of_rate(sums(second))) for sums in (of_tasks, of_names)
    ]
    known = [_as_is(deviation.difference(one, other)) for one, other in pairs if one and other]
    if len(known) < len(pairs):
        return None
    by_task, by_name = known
    return _certainty(by_task, by_name, _between_ones)


_YES_NO = (Share(0, 1), Share(1, 1))
_NORMAL = NormalDist().inv_cdf((1 + LEVEL) / 2)


class _Noise(NamedTuple):
    """What an interval is made from.

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


def _as_is(spread: Deviations) -> _Noise:
    quantile = two_sided_quantile(LEVEL, spread.freedom)
    return _Noise(spread.value, spread.variance, spread.observed_variance, quantile, len(spread.of_units))


def _within_one(spread: Deviations) -> _Noise:
    """The variance in multiples of that of one yes or no."""
    noise = _as_is(spread)
    return noise._replace(variance=noise.variance / (spread.centre * (1 - spread.centre)))


def _binomial(spread: Deviations) -> _Noise:
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


def _symmetric(noise: _Noise) -> Interval:
    half = noise.quantile * math.sqrt(noise.variance)
    return Interval(100 * (noise.value - half), 100 * (noise.value + half))


def _between_ones(noise: _Noise) -> Interval:
    low, high = _symmetric(noise)
    return Interval(max(-100.0, low), min(100.0, high))
