"""Rates: the only place where anything is divided."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from eai.abilities.verdict import Shares
from eai.base.json_value import Json
from eai.tasks.share import Share


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
    sums: dict[str, tuple[Exact, Exact]] = {}
    for contribution in contributions:
        add_up(sums, contribution)
    return rates_of(sums)


Exact: TypeAlias = "int | Fraction"
"""A sum that does not depend on the order of what is added up."""


def add_up(
    sums: dict[str, tuple[Exact, Exact]], more: Mapping[str, tuple[float | Exact, float | Exact]]
) -> None:
    """Add what an answer contributes, or sums over other answers, to the sums of each metric."""
    for name, (numerator, denominator) in more.items():
        if numerator or denominator or name not in sums:
            known = sums.get(name, (0, 0))
            sums[name] = known[0] + _exact(numerator), known[1] + _exact(denominator)


def rates_of(sums: Mapping[str, tuple[Exact, Exact]]) -> dict[str, Rate]:
    """The rates, in the order of the sums."""
    return {name: Rate(_plain(more), _plain(of)) for name, (more, of) in sums.items()}


def _exact(number: float | Exact) -> Exact:
    if isinstance(number, float):
        return int(number) if number.is_integer() else Fraction(number)
    return number


def rate_of(shares: Iterable[Share]) -> Rate:
    """The rate that shares of one metric add up to."""
    numerator = denominator = 0.0
    for more, of in shares:
        numerator += more
        denominator += of
    return Rate(_plain(numerator), _plain(denominator))


def _plain(number: float | Exact) -> float:
    """The same number, as an integer where it is one."""
    return int(number) if number == int(number) else float(number)
