"""Randomisation tests of paired runs: what if a coin decided, unit by unit, which run gave which answers?

Under the hypothesis that the runs are alike their difference varies like that, whatever the tasks are like.
Units are names or tasks; with tasks as units, and a yes or no from each, the test is McNemar's.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Sequence
from itertools import compress

from eai.abilities.share import Share

SEED = 20240901
REPETITIONS = 5000


def sign_flip_p(differences: Sequence[int]) -> float:
    """The exact two-sided p value of a sum of differences, each of which could as well have the other sign.

    Args:
        differences: for each unit, how many more tasks the second run gets right than the first.
    """
    ways = Counter({0: 1})
    sizes = Counter(abs(difference) for difference in differences if difference)
    for size, units in sizes.items():
        before, ways = ways, Counter()
        for total, count in before.items():
            for up in range(units + 1):
                ways[total + size * (2 * up - units)] += count * math.comb(units, up)
    observed = abs(sum(differences))
    return sum(count for total, count in ways.items() if abs(total) >= observed) / sum(ways.values())


def exchange_p(first: Sequence[Share], second: Sequence[Share]) -> float | None:
    """The two-sided p value of a difference of two rates by random exchanges; None if a rate is of nothing.

    Exchanges are drawn with a fixed seed. The runs as they are count as one, so that no value is zero.

    Args:
        first: what each unit adds to the first rate.
        second: what the same units add to the second.
    """
    sums = (_sum(first), _sum(second))
    if not sums[0].denominator or not sums[1].denominator:
        return None
    observed = _distance(*sums)
    gains = [b.numerator - a.numerator for a, b in zip(first, second, strict=True)]
    growths = [b.denominator - a.denominator for a, b in zip(first, second, strict=True)]
    generator = random.Random(SEED)  # noqa: S311 - statistics, not secrets
    extreme = 1
    for _ in range(REPETITIONS):
        heads = generator.choices((0, 1), k=len(gains))
        gain, growth = sum(compress(gains, heads)), sum(compress(growths, heads))
        one = Share(sums[0].numerator + gain, sums[0].denominator + growth)
        other = Share(sums[1].numerator - gain, sums[1].denominator - growth)
        extreme += _distance(one, other) >= observed - _ROUNDING
    return extreme / (REPETITIONS + 1)


_ROUNDING = 1e-12


def _sum(shares: Sequence[Share]) -> Share:
    return Share(sum(share.numerator for share in shares), sum(share.denominator for share in shares))


def _distance(one: Share, other: Share) -> float:
    """How far two rates are apart; one of nothing is as far as can be from the other."""
    if not one.denominator or not other.denominator:
        return math.inf
    return abs(other.numerator / other.denominator - one.numerator / one.denominator)
