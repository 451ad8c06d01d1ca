"""Rates: the only place where anything is divided."""

from __future__ import annotations

from dataclasses import dataclass

from eai.abilities.verdict import Json


@dataclass(frozen=True, slots=True)
class Rate:
    """A share in percent, with what it is made of."""

    numerator: float
    denominator: float

    @property
    def percent(self) -> float | None:
        """The share in percent, or None if there is nothing to take a share of."""
        return 100.0 * self.numerator / self.denominator if self.denominator else None

    def to_json(self) -> dict[str, Json]:
        """The rate as ``summary.json`` has it; the value is in percent."""
        return {"value": self.percent, "numerator": self.numerator, "denominator": self.denominator}
