"""Student's t distribution, for intervals whose variance is itself estimated."""

from __future__ import annotations

import math
from functools import lru_cache

_WIDEST = 1e4
_HALVINGS = 60


@lru_cache(maxsize=1024)
def two_sided_quantile(level: float, freedom: int) -> float:
    """How many standard errors to either side hold this share of the distribution.

    Args:
        level: the share, up to 0.999.
        freedom: degrees of freedom, at least 1.
    """
    low, high = 0.0, _WIDEST
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if _share_within(middle, freedom) < level:
            low = middle
        else:
            high = middle
    return high


def _share_within(width: float, freedom: int) -> float:
    """The share between ``-width`` and ``width``, a finite series (Abramowitz and Stegun, 26.7.3-4)."""
    angle = math.atan(width / math.sqrt(freedom))
    cosine, odd = math.cos(angle), freedom % 2
    term = cosine if odd else 1.0
    series = term if freedom > 1 else 0.0
    for power in range(2 + odd, freedom, 2):
        term *= cosine**2 * (power - 1) / power
        series += term
    value = math.sin(angle) * series
    return 2 / math.pi * (angle + value) if odd else value
