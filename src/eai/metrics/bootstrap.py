"""Bootstrap over tasks: how much a rate would vary with other tasks of the same kind.

A task is the unit that is drawn, with everything it contributes to every metric, so that steps and goals of
one task stay together. The draws are a function of the number of tasks and the seed alone: two runs on the
same tasks see the same draws, which is what makes their differences paired.

Thousands of sums of hundreds of small vectors are quick in plain Python when each vector is one large
integer: the numbers stand side by side in it, far enough apart that no sum spills over.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from eai.abilities.share import NOTHING, Shares

SEED = 20240901
REPETITIONS = 2000
LEVEL = 0.95

_UNIT = 2
"""Goals can be satisfied by halves: numbers are kept in halves."""
_BYTES = 8
"""How far apart the numbers stand."""

Replicates = Sequence["float | None"]
"""A metric in percent in each repetition; None where there was nothing to take a share of."""


class Interval(NamedTuple):
    """The bounds of an interval, in percent or, of a difference, in percentage points."""

    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Bootstrap:
    """How to draw.

    Attributes:
        seed: what the draws depend on, besides the number of tasks.
        repetitions: how many draws.
        level: how much of the distribution an interval covers.
    """

    seed: int = SEED
    repetitions: int = REPETITIONS
    level: float = LEVEL

    def replicates(self, contributions: Sequence[Shares], names: Sequence[str]) -> dict[str, Replicates]:
        """Each named metric in each repetition, in percent.

        Args:
            contributions: what each task contributes.
            names: metrics.
        """
        packed = [_pack(contribution, names) for contribution in contributions]
        draws = _draws(len(packed), self.seed, self.repetitions)
        rows = [_unpack(sum(map(packed.__getitem__, draw)), 2 * len(names)) for draw in draws]
        return {
            name: [100.0 * row[2 * i] / row[2 * i + 1] if row[2 * i + 1] else None for row in rows]
            for i, name in enumerate(names)
        }

    def intervals(
        self, contributions: Sequence[Shares], names: Sequence[str]
    ) -> Mapping[str, Interval | None]:
        """The percentile interval of each named metric; None for one that is not defined."""
        return {name: self.interval(values) for name, values in self.replicates(contributions, names).items()}

    def interval(self, replicates: Replicates) -> Interval | None:
        """The percentile interval of replicates; None if there are none."""
        values = sorted(value for value in replicates if value is not None)
        if not values:
            return None
        tail = (1 - self.level) / 2
        return Interval(_quantile(values, tail), _quantile(values, 1 - tail))


@lru_cache(maxsize=16)
def _draws(size: int, seed: int, repetitions: int) -> tuple[list[int], ...]:
    """Indices of tasks, drawn with replacement."""
    generator = random.Random(f"{seed}/{size}")  # noqa: S311 - statistics, not secrets
    return tuple(generator.choices(range(size), k=size) if size else [] for _ in range(repetitions))


def _pack(contribution: Shares, names: Sequence[str]) -> int:
    """Numerators and denominators as one integer."""
    packed = bytearray()
    for name in names:
        for number in contribution.get(name, NOTHING):
            packed += round(number * _UNIT).to_bytes(_BYTES, "little")
    return int.from_bytes(packed, "little")


def _unpack(packed: int, count: int) -> tuple[int, ...]:
    return struct.unpack(f"<{count}Q", packed.to_bytes(count * _BYTES, "little"))


def _quantile(ordered: Sequence[float], share: float) -> float:
    """The quantile of ordered values, interpolated between neighbours."""
    place = share * (len(ordered) - 1)
    below = int(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (ordered[above] - ordered[below]) * (place - below)
