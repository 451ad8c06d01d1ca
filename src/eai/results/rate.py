"""Rates: the only place where anything is divided."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from eai.abilities.verdict import Json, Share, Shares


@dataclass(frozen=True, slots=True)
class Rate:
    """A share in percent, with what it is made of."""

    numerator: float
    denominator: float

    @property
    def share(self) -> float | None:
        """The share as a fraction, or None if there is nothing to take a share of."""
        return self.numerator / self.denominator if self.denominator else None

    @property
    def percent(self) -> float | None:
        """The share in percent, or None if there is nothing to take a share of."""
        return 100.0 * self.numerator / self.denominator if self.denominator else None

    def to_json(self) -> dict[str, Json]:
        """The rate as ``summary.json`` has it; the value is in percent."""
        return {"value": self.percent, "numerator": self.numerator, "denominator": self.denominator}


NOTHING = Rate(0, 0)
"""A rate without any case."""


def total(contributions: Iterable[Shares]) -> dict[str, Rate]:
    """The rates that contributions add up to: sums over sums, in the order of first mention."""
    numerators: dict[str, float] = {}
    denominators: dict[str, float] = {}
    for contribution in contributions:
        for name, (numerator, denominator) in contribution.items():
            numerators[name] = numerators.get(name, 0) + numerator
            denominators[name] = denominators.get(name, 0) + denominator
    return {name: Rate(_plain(numerators[name]), _plain(denominators[name])) for name in numerators}


def rate_of(shares: Iterable[Share]) -> Rate:
    """The rate that shares of one metric add up to."""
    numerator = denominator = 0.0
    for more, of in shares:
        numerator += more
        denominator += of
    return Rate(_plain(numerator), _plain(denominator))


def _plain(number: float) -> float:
    """The same number, as an integer where it is one."""
    return int(number) if number == int(number) else number
