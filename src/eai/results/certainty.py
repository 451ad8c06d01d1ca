"""Confidence intervals of rates and of their differences, with near copies of a task counted together.

Near copies of a task share a *name*. They tend to succeed and fail together: 342 such tasks may give no more
information than 40 different ones. Therefore all tasks of one name are one unit of an interval: only units
count as independent. A second interval takes each task as a unit. The design effect is the factor by which
the variance grows because near copies agree. The number of tasks divided by the design effect is the
effective number of tasks.

An interval is Wilson's (1927) for the effective number of tasks; it also holds at 0 and at 100 percent. This
number is estimated from few names, therefore the estimate is conservative and uses Student's quantile.
``bench/coverage.py`` measures that the intervals cover the true value as often as they claim. Bootstrap
percentiles and Wilson's interval with the observed design effect cover it less often.

A rate is a ratio of sums over units. To first order its variance is the sum of squares of the units'
contributions: the linearisation of cluster samples, and the limit of a bootstrap over units. This variance is
too small for few units: a large unit pulls the rate to itself, and if all units agree the variance is zero.
Therefore a unit counts by how much the rate would change without it (the jackknife). Two pseudo-units of mean
size are added, each all right or all wrong with even chance. They change no rate, but they add to its
variance, as the two successes and two failures of Agresti and Coull (1998) do. Student's t is used for
intervals with an estimated variance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import product
from statistics import NormalDist, fmean
from typing import NamedTuple, TypeAlias

from eai.results.rate import Rate
from eai.tasks.share import Share

_MAX_QUANTILE = 1e4
_BISECTION_STEPS = 60


@lru_cache(maxsize=1024)
def compute_student_quantile(level: float, degrees_of_freedom: int) -> float:
    """Return the quantile of Student's distribution for a two-sided interval.

    The result is in standard errors: the interval from minus to plus the quantile has the given probability.

    Args:
        level: probability of the interval, up to 0.999.
        degrees_of_freedom: number, at least 1.
    """
    low, high = 0.0, _MAX_QUANTILE
    for _ in range(_BISECTION_STEPS):
        middle = (low + high) / 2
        if _compute_student_probability(middle, degrees_of_freedom) < level:
            low = middle
        else:
            high = middle
    return high


def _compute_student_probability(width: float, degrees_of_freedom: int) -> float:
    """Return the probability of Student's distribution between ``-width`` and ``width``, as a finite series.

    The series is Abramowitz & Stegun, 26.7.3-4.
    """
    angle = math.atan(width / math.sqrt(degrees_of_freedom))
    cosine, odd = math.cos(angle), degrees_of_freedom % 2
    term = cosine if odd else 1.0
    series = term if degrees_of_freedom > 1 else 0.0
    for power in range(2 + odd, degrees_of_freedom, 2):
        term *= cosine**2 * (power - 1) / power
        series += term
    value = math.sin(angle) * series
    return 2 / math.pi * (angle + value) if odd else value


_PSEUDO_UNITS = 2


@dataclass(frozen=True, slots=True)
class _RateWithResidualsOfSamplingUnits:
    """An estimated rate, or difference of rates, with the residual (error) that each unit adds to it.

    A unit is a task, or a group of near copies of a task. Few units make the variance too small. Therefore
    two pseudo-units add to the variance: imagined units of mean size, each right with probability 1/2.

    Attributes:
        value: the estimate from the real units, as a fraction of 1.
        centre: the estimate from the real units and two pseudo-units, one of them right and one wrong.
        residual_by_unit: mapping from each real unit to the residual that it adds; the residuals sum to 0.
        possible_residuals_of_pseudo_unit: the residuals that one pseudo-unit may add, all equally likely.
            For a rate there are two: one if the pseudo-unit is right, one if it is wrong.
        weights: mapping from each unit to its share of the denominator; the shares sum to 1.
    """

    value: float
    centre: float
    residual_by_unit: Mapping[str, float]
    possible_residuals_of_pseudo_unit: tuple[float, ...]
    weights: Mapping[str, float]

    @property
    def observed_variance(self) -> float:
        """Variance of the estimate from the real units, without the two pseudo-units (imagined units)."""
        return sum(added * added for added in self.residual_by_unit.values())

    @property
    def variance(self) -> float:
        """Variance of the estimate, never zero.

        It is the jackknife variance over the real units, plus the variance from the two pseudo-units.
        Pseudo-units are imagined units, each right with probability 1/2. They keep the variance above zero
        even if all tasks are right, or all wrong.
        """
        left_out = (
            added / (1 - self.weights[unit])
            for unit, added in self.residual_by_unit.items()
            if self.weights[unit] < 1
        )
        pseudo = _PSEUDO_UNITS * fmean(added * added for added in self.possible_residuals_of_pseudo_unit)
        return sum(change * change for change in left_out) + pseudo

    @property
    def degrees_of_freedom(self) -> int:
        """Degrees of freedom: the effective number of units, plus two pseudo-units, minus one.

        The effective number is Kish's, rounded down.
        """
        effective_units = 1 / sum(weight * weight for weight in self.weights.values())
        return math.floor(effective_units) + _PSEUDO_UNITS - 1


def compute_rate_with_residuals_of_sampling_units(
    shares_by_unit: Mapping[str, Share],
) -> _RateWithResidualsOfSamplingUnits | None:
    """Return a rate with the residual that each unit adds, or None if the denominator is zero.

    A unit is a task, or a group of near copies of a task.

    Args:
        shares_by_unit: mapping from each unit to the numerator and denominator that it adds to the rate.
    """
    parts = {unit: share for unit, share in shares_by_unit.items() if share.denominator}
    whole, units = sum(share.denominator for share in parts.values()), len(parts)
    if not units:
        return None
    value = sum(share.numerator for share in parts.values()) / whole
    centre = (value * units + _PSEUDO_UNITS / 2) / (units + _PSEUDO_UNITS)
    return _RateWithResidualsOfSamplingUnits(
        value=value,
        centre=centre,
        residual_by_unit={
            unit: (share.numerator - value * share.denominator) / whole for unit, share in parts.items()
        },
        possible_residuals_of_pseudo_unit=((1 - centre) / units, -centre / units),
        weights={unit: share.denominator / whole for unit, share in parts.items()},
    )


def compute_weighted_mean_of_rates(
    weighted_rates: Sequence[tuple[float, _RateWithResidualsOfSamplingUnits]],
) -> _RateWithResidualsOfSamplingUnits:
    """Return the weighted mean of rates of the same tasks, with the residual that each unit adds.

    A unit is a task, or a group of near copies of a task. A pseudo-unit is an imagined unit
    (`_RateWithResidualsOfSamplingUnits`). It is taken to be right in all rates or wrong in all rates.

    Args:
        weighted_rates: for each rate, its weight and the result of
            `compute_rate_with_residuals_of_sampling_units`; the weights sum to 1.
    """
    return _RateWithResidualsOfSamplingUnits(
        value=sum(weight * rate.value for weight, rate in weighted_rates),
        centre=sum(weight * rate.centre for weight, rate in weighted_rates),
        residual_by_unit=_sum_weighted_numbers_by_unit(
            [(weight, rate.residual_by_unit) for weight, rate in weighted_rates]
        ),
        possible_residuals_of_pseudo_unit=tuple(
            sum(weight * rate.possible_residuals_of_pseudo_unit[index] for weight, rate in weighted_rates)
            for index in (0, 1)
        ),
        weights=_sum_weighted_numbers_by_unit([(weight, rate.weights) for weight, rate in weighted_rates]),
    )


def compute_rate_difference_with_residuals(
    first: _RateWithResidualsOfSamplingUnits, second: _RateWithResidualsOfSamplingUnits
) -> _RateWithResidualsOfSamplingUnits:
    """Return the second rate minus the first, with the residual that each unit adds.

    A unit is a task, or a group of near copies of a task. A pseudo-unit is an imagined unit
    (`_RateWithResidualsOfSamplingUnits`). It may be right in both rates, only in the first, only in the
    second, or in neither. These four cases are equally likely.
    """
    return _RateWithResidualsOfSamplingUnits(
        value=second.value - first.value,
        centre=second.centre - first.centre,
        residual_by_unit=_sum_weighted_numbers_by_unit(
            [(1, second.residual_by_unit), (-1, first.residual_by_unit)]
        ),
        possible_residuals_of_pseudo_unit=tuple(
            b - a
            for a, b in product(
                first.possible_residuals_of_pseudo_unit, second.possible_residuals_of_pseudo_unit
            )
        ),
        weights=_sum_weighted_numbers_by_unit([(0.5, first.weights), (0.5, second.weights)]),
    )


def _sum_weighted_numbers_by_unit(
    weighted_numbers: Sequence[tuple[float, Mapping[str, float]]],
) -> dict[str, float]:
    total: dict[str, float] = {}
    for weight, numbers in weighted_numbers:
        for unit, number in numbers.items():
            total[unit] = total.get(unit, 0) + weight * number
    return total


LEVEL = 0.95
"""Confidence level of all intervals: the share of intervals that cover the true value."""


class Interval(NamedTuple):
    """Lower and upper bound of an interval: in percent for a rate, in percentage points for a difference."""

    low: float
    high: float


class TaskRateContribution(NamedTuple):
    """One task's contribution to a rate.

    Attributes:
        task: id of the task.
        name: name that near copies of the task share.
        share: numerator and denominator that the task adds to the rate.
    """

    task: str
    name: str
    share: Share


TaskRateContributions: TypeAlias = Sequence[TaskRateContribution]


@dataclass(frozen=True, slots=True)
class ConfidenceIntervals:
    """Confidence intervals of a rate or of a difference of rates, with the number of its tasks.

    Attributes:
        interval: 95 % interval with all tasks of one name as one unit.
        by_task: 95 % interval as if all tasks were independent.
        tasks: number of tasks.
        names: number of different names of these tasks.
        design_effect: observed variance with names as units, divided by the variance with independent tasks;
            None if the variance is zero.
    """

    interval: Interval
    by_task: Interval
    tasks: int
    names: int
    design_effect: float | None

    @property
    def effective_task_count(self) -> float | None:
        """Number of independent tasks that give as much information as these tasks; at most their number.

        It is None if `design_effect` is None or zero.
        """
        return self.tasks / max(1.0, self.design_effect) if self.design_effect else None


def sum_shares_by_task(contributions: TaskRateContributions) -> dict[str, Share]:
    """Return a mapping from each task to the numerator and denominator that it adds to a rate."""
    return _sum_shares_by_unit([(contribution.task, contribution.share) for contribution in contributions])


def sum_shares_by_task_name(contributions: TaskRateContributions) -> dict[str, Share]:
    """Return a mapping from each task name to the numerator and denominator that its tasks add to a rate."""
    return _sum_shares_by_unit([(contribution.name, contribution.share) for contribution in contributions])


def compute_mean_rate_over_task_names(contributions: TaskRateContributions) -> float | None:
    """Group tasks by name, and return the mean of the groups' rates, in percent.

    Return None if all denominators are zero.
    """
    rates = [
        Rate(*share).percent for share in sum_shares_by_task_name(contributions).values() if share.denominator
    ]
    return fmean(rate for rate in rates if rate is not None) if rates else None


def compute_rate_intervals(contributions: TaskRateContributions) -> ConfidenceIntervals | None:
    """Return the confidence intervals of a rate, or None if its denominator is zero.

    A single task can add more than 1 to the rate, for instance by several errors. Then the interval is
    computed for the rate divided by the largest contribution of a task, and multiplied by it again.
    """
    largest = _find_max_task_rate(contributions)
    if largest == 1:
        return _compute_confidence_intervals_of_rate(contributions)
    scaled = [
        contribution._replace(
            share=Share(contribution.share.numerator / largest, contribution.share.denominator)
        )
        for contribution in contributions
    ]
    certainty = _compute_confidence_intervals_of_rate(scaled)
    if certainty is None:
        return None
    return replace(
        certainty,
        interval=Interval(*(bound * largest for bound in certainty.interval)),
        by_task=Interval(*(bound * largest for bound in certainty.by_task)),
    )


def _find_max_task_rate(contributions: TaskRateContributions) -> float:
    """Return the largest rate of a single task, or 1 if that is larger."""
    return max(
        [1, *(share.numerator / share.denominator for _, _, share in contributions if share.denominator)]
    )


def _compute_confidence_intervals_of_rate(contributions: TaskRateContributions) -> ConfidenceIntervals | None:
    each_task, each_name = sum_shares_by_task(contributions), sum_shares_by_task_name(contributions)
    tasks = compute_rate_with_residuals_of_sampling_units(each_task)
    names = (
        tasks
        if len(each_name) == len(each_task)
        else compute_rate_with_residuals_of_sampling_units(each_name)
    )
    if tasks is None or names is None:
        return None
    yes_no = len(tasks.residual_by_unit) == len(contributions) and all(
        contribution.share in _YES_NO for contribution in contributions
    )
    return _make_confidence_intervals(
        _make_binomial_interval_inputs(tasks) if yes_no else _make_wilson_interval_inputs(tasks),
        _make_wilson_interval_inputs(names),
        _compute_wilson_interval,
    )


def compute_intervals_of_weighted_mean(
    parts: Sequence[tuple[float, TaskRateContributions]],
) -> ConfidenceIntervals | None:
    """Return the confidence intervals of a weighted mean of rates on the same tasks.

    The result is None if no task contributes to one of the rates.

    Args:
        parts: the weight of each rate, with the contributions of tasks to the rate; the weights sum to 1.
    """
    inputs = []
    for sum_shares in (sum_shares_by_task, sum_shares_by_task_name):
        weighted_rates = []
        for weight, contributions in parts:
            rate = compute_rate_with_residuals_of_sampling_units(sum_shares(contributions))
            if rate is None:
                return None
            weighted_rates.append((weight, rate))
        inputs.append(_make_wilson_interval_inputs(compute_weighted_mean_of_rates(weighted_rates)))
    by_task, by_name = inputs
    return _make_confidence_intervals(by_task, by_name, _compute_wilson_interval)


def compute_difference_intervals(
    first: TaskRateContributions, second: TaskRateContributions
) -> ConfidenceIntervals | None:
    """Return the confidence intervals of the difference of two rates on the same tasks.

    The intervals are in percentage points, around the second rate minus the first. Bounds are cut to possible
    differences. The result is None if a denominator is zero.
    """
    largest = max(_find_max_task_rate(first), _find_max_task_rate(second))
    inputs = []
    for sum_shares in (sum_shares_by_task, sum_shares_by_task_name):
        one = compute_rate_with_residuals_of_sampling_units(sum_shares(first))
        other = compute_rate_with_residuals_of_sampling_units(sum_shares(second))
        if one is None or other is None:
            return None
        difference = compute_rate_difference_with_residuals(one, other)
        inputs.append(_make_confidence_interval_inputs(difference))
    by_task, by_name = inputs
    return _make_confidence_intervals(by_task, by_name, partial(_compute_difference_interval, largest))


def compute_interval_of_cost_per_success(contributions: TaskRateContributions) -> Interval | None:
    """Return the confidence interval of the cost of a success.

    The cost of a success is the sum of all costs, divided by the number of successes. Its interval is
    symmetric on a log scale. All tasks with the same name are one sampling unit. The interval is None if
    there is no success, no cost, or only one name.

    Args:
        contributions: for each answer, its cost (numerator) and 1 for a success, else 0 (denominator).
    """
    units = sum_shares_by_task_name(contributions).values()
    spent, successes = sum(unit.numerator for unit in units), sum(unit.denominator for unit in units)
    if not spent or not successes or len(units) < 2:
        return None
    shifts = [unit.numerator / spent - unit.denominator / successes for unit in units]
    variance = len(units) / (len(units) - 1) * sum(shift * shift for shift in shifts)
    half = compute_student_quantile(LEVEL, len(units) - 1) * math.sqrt(variance)
    return Interval(spent / successes * math.exp(-half), spent / successes * math.exp(half))


_YES_NO = (Share(0, 1), Share(1, 1))
_NORMAL = NormalDist().inv_cdf((1 + LEVEL) / 2)


class _IntervalInputs(NamedTuple):
    """The numbers from which the confidence interval of an estimate is computed.

    Attributes:
        value: the estimate, as a fraction of 1.
        variance: variance of the estimate, with the pseudo-units of
            `_RateWithResidualsOfSamplingUnits`. For Wilson's interval it is 1 divided by the effective
            number of units (`_make_wilson_interval_inputs`).
        observed: variance of the estimate without pseudo-units.
        quantile: distance from the estimate to each bound, in standard errors.
        units: number of real units from which the variance is computed. Each unit is a task, or each unit is
            a name with all its tasks.
    """

    value: float
    variance: float
    observed: float
    quantile: float
    units: int


def _make_confidence_interval_inputs(rate: _RateWithResidualsOfSamplingUnits) -> _IntervalInputs:
    return _IntervalInputs(
        value=rate.value,
        variance=rate.variance,
        observed=rate.observed_variance,
        quantile=compute_student_quantile(LEVEL, rate.degrees_of_freedom),
        units=len(rate.residual_by_unit),
    )


def _make_wilson_interval_inputs(rate: _RateWithResidualsOfSamplingUnits) -> _IntervalInputs:
    """Return the inputs of Wilson's interval; their `variance` is 1 divided by the effective number of units.

    A unit is a task or a group of near copies. Independent yes-or-no answers with this effective number would
    give the estimate its variance: the variance of one answer, divided by the number.
    """
    inputs = _make_confidence_interval_inputs(rate)
    return inputs._replace(variance=inputs.variance / (rate.centre * (1 - rate.centre)))


def _make_binomial_interval_inputs(rate: _RateWithResidualsOfSamplingUnits) -> _IntervalInputs:
    """Return the inputs of Wilson's interval if all units are independent yes-or-no answers."""
    units = len(rate.residual_by_unit)
    return _IntervalInputs(
        value=rate.value,
        variance=1 / units,
        observed=rate.observed_variance,
        quantile=_NORMAL,
        units=units,
    )


def _sum_shares_by_unit(units_and_shares: Sequence[tuple[str, Share]]) -> dict[str, Share]:
    last = dict(units_and_shares)
    if len(last) == len(units_and_shares):
        return last
    numerators, denominators = dict.fromkeys(last, 0.0), dict.fromkeys(last, 0.0)
    for unit, (numerator, denominator) in units_and_shares:
        numerators[unit] += numerator
        denominators[unit] += denominator
    return {unit: Share(numerators[unit], denominators[unit]) for unit in last}


def _make_confidence_intervals(
    inputs_for_tasks: _IntervalInputs,
    inputs_for_task_names: _IntervalInputs,
    compute_bounds: Callable[[_IntervalInputs], Interval],
) -> ConfidenceIntervals:
    tasks, names = inputs_for_tasks, inputs_for_task_names
    interval = by_task = compute_bounds(tasks)
    design_effect: float | None = 1.0
    if names.units != tasks.units:  # some tasks are near copies
        interval = compute_bounds(names._replace(variance=max(names.variance, tasks.variance)))
        design_effect = names.observed / tasks.observed if tasks.observed else None
    return ConfidenceIntervals(
        interval=interval,
        by_task=by_task,
        tasks=tasks.units,
        names=names.units,
        design_effect=design_effect,
    )


def _compute_wilson_interval(inputs: _IntervalInputs) -> Interval:
    value, spread = inputs.value, inputs.quantile**2 * inputs.variance
    middle = (value + spread / 2) / (1 + spread)
    half = math.sqrt(spread * (value * (1 - value) + spread / 4)) / (1 + spread)
    return Interval(
        0.0 if value <= 0 else 100 * max(0.0, middle - half),
        100.0 if value >= 1 else 100 * min(1.0, middle + half),
    )


def _compute_difference_interval(max_difference: float, inputs: _IntervalInputs) -> Interval:
    half = inputs.quantile * math.sqrt(inputs.variance)
    return Interval(
        100 * max(-max_difference, inputs.value - half), 100 * min(max_difference, inputs.value + half)
    )
