"""Rates: the only place where anything is divided."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from eai.abilities.verdict import Confusion, Json


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


Rates: TypeAlias = Mapping[str, Rate]
"""Rates by the name of their metric; of one answer, what it contributes to each."""

NOTHING = Rate(0, 0)
"""What an answer contributes to a rate that is not about it."""


def share(holds: bool | float | None) -> Rate:
    """What one answer contributes to a share of all answers."""
    return Rate(float(holds or 0), 1)


def total(contributions: Iterable[Rates]) -> dict[str, Rate]:
    """The rates that contributions add up to: sums over sums, in the order of first mention."""
    numerators: dict[str, float] = {}
    denominators: dict[str, float] = {}
    for contribution in contributions:
        for name, rate in contribution.items():
            numerators[name] = numerators.get(name, 0) + rate.numerator
            denominators[name] = denominators.get(name, 0) + rate.denominator
    return {name: Rate(_plain(numerators[name]), _plain(denominators[name])) for name in numerators}


def confusion_rates(prefix: str, confusion: Confusion) -> dict[str, Rate]:
    """Precision, recall and F1 of confusion counts, each as a ratio of sums over answers.

    F1 is ``2 TP / (2 TP + FP + FN)``, which is the harmonic mean of the other two.
    """
    hit, extra, missed = confusion
    return {
        f"{prefix}.precision": Rate(hit, hit + extra),
        f"{prefix}.recall": Rate(hit, hit + missed),
        f"{prefix}.f1": Rate(2 * hit, 2 * hit + extra + missed),
    }


def add(confusions: Iterable[Confusion]) -> Confusion:
    """The sum of confusion counts."""
    hits, extras, missed = 0, 0, 0
    for confusion in confusions:
        hits += confusion.true_positives
        extras += confusion.false_positives
        missed += confusion.false_negatives
    return Confusion(hits, extras, missed)


def _plain(number: float) -> float:
    """The same number, as an integer where it is one."""
    return int(number) if number == int(number) else number
