"""Add up the contributions of answers to rates. All divisions of rates are in this module."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import fsum
from typing import TypeAlias

from eai.abilities.verdict import ShareByMetric
from eai.base.json_value import Json
from eai.tasks.share import Share


@dataclass(frozen=True, slots=True)
class Rate:
    """A rate in percent, with its numerator and denominator."""

    numerator: float
    denominator: float

    @property
    def share(self) -> float | None:
        """The rate as a fraction, or None if the denominator is zero."""
        return self.numerator / self.denominator if self.denominator else None

    @property
    def percent(self) -> float | None:
        """The rate in percent, or None if the denominator is zero."""
        return 100.0 * self.numerator / self.denominator if self.denominator else None

    def to_json(self) -> dict[str, Json]:
        """Return the rate as in ``summary.json``; the value is in percent."""
        return {"value": self.percent, "numerator": self.numerator, "denominator": self.denominator}


NOTHING = Rate(0, 0)
"""The rate 0 of 0, to which no answer contributes."""


def compute_rates(contributions: Iterable[ShareByMetric]) -> dict[str, Rate]:
    """Return a mapping from each metric to its rate: its sum of numerators over its sum of denominators.

    Metrics come in the order in which they first occur.
    """
    sums: dict[str, tuple[Exact, Exact]] = {}
    for contribution in contributions:
        add_numerators_and_denominators_to_sums(sums, contribution)
    return make_rates(sums)


Exact: TypeAlias = "int | Fraction"
"""A sum as an exact fraction: it does not depend on the order in which numbers are added."""


def add_numerators_and_denominators_to_sums(
    sums_by_metric: dict[str, tuple[Exact, Exact]],
    added_by_metric: Mapping[str, tuple[float | Exact, float | Exact]],
) -> None:
    """Add the contributions of an answer, or of a group of answers, to the running sums of metrics.

    Args:
        sums_by_metric: numerator and denominator of each metric so far.
        added_by_metric: numerator and denominator to add to each metric.
    """
    for name, (numerator, denominator) in added_by_metric.items():
        if numerator or denominator or name not in sums_by_metric:
            before = sums_by_metric.get(name, (0, 0))
            sums_by_metric[name] = (
                before[0] + _to_exact_number(numerator),
                before[1] + _to_exact_number(denominator),
            )


def make_rates(sums: Mapping[str, tuple[Exact, Exact]]) -> dict[str, Rate]:
    """Return the rate of each metric, given its exact numerator and denominator; the order stays."""
    return {
        name: Rate(_convert_to_int_if_whole(more), _convert_to_int_if_whole(of))
        for name, (more, of) in sums.items()
    }


def _to_exact_number(number: float | Exact) -> Exact:
    if isinstance(number, float):
        return int(number) if number.is_integer() else Fraction(number)
    return number


def compute_rate(shares: Iterable[Share]) -> Rate:
    """Return a rate, the sum of the numerators over the sum of the denominators, as `compute_rates` does."""
    all_shares = list(shares)
    return Rate(
        _convert_to_int_if_whole(fsum([share.numerator for share in all_shares])),
        _convert_to_int_if_whole(fsum([share.denominator for share in all_shares])),
    )


def _convert_to_int_if_whole(number: float | Exact) -> float:
    """Return the number, rounded to a float, as an integer if it is whole."""
    rounded = float(number)
    return int(rounded) if rounded.is_integer() else rounded
