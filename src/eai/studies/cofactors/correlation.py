"""Rank correlation with an interval that knows which observations are near copies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from eai.results.certainty import LEVEL, two_sided_quantile
from eai.results.table import Estimate

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_FEWEST = 4
"""Clusters; an interval from fewer would say nothing."""


def rank_correlation(first: Sequence[float], second: Sequence[float], clusters: Sequence[str]) -> Estimate:
    """Spearman's correlation; of nothing where one of the two does not vary.

    The interval is a jackknife over clusters of Fisher's transform, in which ranks stay as they are among
    all, with Student's quantile for as many degrees of freedom as there are clusters but one.

    Args:
        first: one number an observation.
        second: another one.
        clusters: what near copies share.
    """
    import numpy as np
    from scipy.stats import rankdata

    x, y = rankdata(first), rankdata(second)
    if len(x) < 2 or x.std() == 0 or y.std() == 0:
        return Estimate(None)
    names = {name: number for number, name in enumerate(dict.fromkeys(clusters))}
    member = np.array([names[name] for name in clusters])
    values = np.column_stack([np.ones(len(x)), x, y, x * x, y * y, x * y])
    of_clusters = np.array([np.bincount(member, weights=column) for column in values.T]).T
    whole = _pearson(of_clusters.sum(axis=0, keepdims=True))[0]
    value = float(whole)
    if len(names) < _FEWEST or abs(value) >= 1:
        return Estimate(value)
    without = np.arctanh(np.clip(_pearson(of_clusters.sum(axis=0) - of_clusters), -0.999999, 0.999999))
    without = without[np.isfinite(without)]
    variance = (len(without) - 1) / len(without) * ((without - without.mean()) ** 2).sum()
    half = two_sided_quantile(LEVEL, len(names) - 1) * math.sqrt(variance)
    middle = math.atanh(value)
    return Estimate(value, math.tanh(middle - half), math.tanh(middle + half))


def _pearson(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """The correlations that rows of sums (1, x, y, xx, yy, xy) say; not a number where nothing varies."""
    import numpy as np

    n, x, y, xx, yy, xy = sums.T
    with np.errstate(divide="ignore", invalid="ignore"):
        found: NDArray[np.float64] = (n * xy - x * y) / np.sqrt((n * xx - x * x) * (n * yy - y * y))
    return found
