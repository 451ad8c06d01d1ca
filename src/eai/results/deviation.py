"""The variance of rates, of their means and differences, from what each unit adds to them.

A rate is a ratio of sums over units. To first order its variance is the sum of the squares of what the units
add: the linearisation of cluster samples, and the limit of a bootstrap over units. That is too small where
units are few: a large one draws the rate to itself, and where all agree there is no variance at all. So a
unit counts by how far the rate is from what it would be without it (the jackknife), and two units of mean
size are thought to be there besides, each all right or all wrong with even chance. They move no rate, but are
part of its variance, as the two successes and two failures of Agresti and Coull (1998) are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from statistics import fmean

from eai.abilities.share import Share

_BESIDES = 2


@dataclass(frozen=True, slots=True)
class Deviations:
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


def of_rate(sums: Mapping[str, Share]) -> Deviations | None:
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
    return Deviations(
        value,
        centre,
        {unit: (share.numerator - value * share.denominator) / whole for unit, share in parts.items()},
        ((1 - centre) / units, -centre / units),
        {unit: share.denominator / whole for unit, share in parts.items()},
    )


def mean(parts: Sequence[tuple[float, Deviations]]) -> Deviations:
    """The deviations of a mean of rates of the same units; a unit besides is right in all of them or in none.

    Args:
        parts: weight and rate; the weights add up to 1.
    """
    return Deviations(
        sum(weight * each.value for weight, each in parts),
        sum(weight * each.centre for weight, each in parts),
        _weighted([(weight, each.of_units) for weight, each in parts]),
        tuple(sum(weight * each.of_besides[case] for weight, each in parts) for case in (0, 1)),
        _weighted([(weight, each.weights) for weight, each in parts]),
    )


def difference(first: Deviations, second: Deviations) -> Deviations:
    """The deviations of second minus first; of a unit besides, each is right or wrong by itself."""
    return Deviations(
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
