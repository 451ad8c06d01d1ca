"""Rank correlation and logistic regression, with intervals that know which observations are near copies.

Intervals are a jackknife over clusters, with Student's quantile for as many degrees of freedom as there are
clusters but one. That of the regression leaves each out in turn, to first order (CR3 of Bell and McCaffrey,
2002): the usual sandwich is too narrow where clusters are few or of unequal size (``bench/coverage.py``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from eai.results.certainty import LEVEL, two_sided_quantile
from eai.results.table import Estimate

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_STEPS = 40
_SMALL = 1e-9
_LARGEST = 12.0
"""Log odds above this per unit are those of a column that tells success for sure: there is no maximum."""

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


def fit_logit(
    columns: NDArray[np.float64], success: NDArray[np.float64], clusters: Sequence[str]
) -> list[Estimate]:
    """The effects of columns on success; of nothing if there is no maximum, or fewer than two clusters.

    Args:
        columns: one row an observation, one column a cofactor; a constant is one of them if there is to be
            one.
        success: 0 or 1 for each observation.
        clusters: what near copies share, for each observation.
    """
    import numpy as np

    estimate = _maximum(columns, success)
    names = sorted(set(clusters))
    if estimate is None or len(names) < 2:
        return [Estimate(None)] * columns.shape[1]
    fitted = 1 / (1 + np.exp(-columns @ estimate))
    weights = fitted * (1 - fitted)
    information = columns.T @ (columns * weights[:, None])
    cluster_of, changes = np.array(clusters), []
    for name in names:
        rows = cluster_of == name
        part = columns[rows]
        left = information - part.T @ (part * weights[rows][:, None])
        changes.append(-np.linalg.pinv(left) @ (part.T @ (success[rows] - fitted[rows])))
    spread = np.array(changes)
    variance = (len(names) - 1) / len(names) * (spread**2).sum(axis=0)
    half = two_sided_quantile(LEVEL, len(names) - 1) * np.sqrt(variance)
    return [
        Estimate(float(value), float(value - wide), float(value + wide))
        for value, wide in zip(estimate, half, strict=True)
    ]


def _maximum(columns: NDArray[np.float64], success: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The coefficients of highest likelihood; None if Newton's method finds none."""
    import numpy as np

    estimate = np.zeros(columns.shape[1])
    for _ in range(_STEPS):
        fitted = 1 / (1 + np.exp(-np.clip(columns @ estimate, -30, 30)))
        information = columns.T @ (columns * (fitted * (1 - fitted))[:, None])
        try:
            change = np.linalg.solve(information, columns.T @ (success - fitted))
        except np.linalg.LinAlgError:
            return None
        estimate = estimate + change
        if not np.isfinite(estimate).all() or np.abs(estimate).max() > _LARGEST:
            return None
        if np.abs(change).max() < _SMALL:
            return estimate
    return None
