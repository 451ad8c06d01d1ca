"""The contribution of one answer to a metric: a numerator and a denominator, for `eai.results` to divide."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, TypeAlias

from eai.abilities.verdict import Confusion


class Share(NamedTuple):
    """The addition of one answer to both sides of a rate."""

    numerator: float
    denominator: float


Shares: TypeAlias = Mapping[str, Share]
"""The contributions of one answer, by the name of the metric."""

NOTHING = Share(0, 0)
"""The contribution of an answer to a rate that is not about it."""


NONE, ONE = Share(0.0, 1), Share(1.0, 1)
"""The contributions of nearly all answers to a share of all answers."""


def of_all(counted: bool | float | None) -> Share:
    """The contribution of one answer to a share of all answers."""
    if not counted:
        return NONE
    return ONE if counted == 1 else Share(float(counted), 1)


def confusion_shares(prefix: str, confusion: Confusion) -> dict[str, Share]:
    """The contributions of counts to precision, recall and F1, each a ratio of sums over answers.

    F1 is ``2 TP / (2 TP + FP + FN)``, which is the harmonic mean of the other two.
    """
    hit, extra, missed = confusion
    return {
        f"{prefix}.precision": Share(hit, hit + extra),
        f"{prefix}.recall": Share(hit, hit + missed),
        f"{prefix}.f1": Share(2 * hit, 2 * hit + extra + missed),
    }


def add(confusions: Iterable[Confusion]) -> Confusion:
    """The sum of confusion counts."""
    hits, extras, missed = 0, 0, 0
    for confusion in confusions:
        hits += confusion.true_positives
        extras += confusion.false_positives
        missed += confusion.false_negatives
    return Confusion(hits, extras, missed)
