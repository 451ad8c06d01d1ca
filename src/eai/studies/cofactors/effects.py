"""Compute rank correlations and logistic regressions, with intervals for observations in clusters.

A cluster holds similar observations. Intervals are from a jackknife, which leaves out one cluster after the
other, with Student's quantile for (number of clusters - 1) degrees of freedom. The regression approximates
the jackknife to first order (CR3 of Bell and McCaffrey, 2002). The usual sandwich interval is too narrow for
few clusters or unequal clusters (``bench/coverage.py``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from eai.results.certainty import LEVEL, compute_student_quantile
from eai.results.table import Estimate

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_MAX_NEWTON_STEPS = 40
_TOLERANCE = 1e-9
_MAX_LOG_ODDS = 12.0
"""Maximum coefficient in log odds per unit.

A larger coefficient means that the column separates success from failure, so the likelihood has no
maximum."""

_MIN_CLUSTERS = 4
"""Minimum number of clusters (groups of dependent observations) for the interval of a correlation."""


def compute_rank_correlation(
    first: Sequence[float], second: Sequence[float], clusters: Sequence[str]
) -> Estimate:
    """Return Spearman's rank correlation of two series; without a value if one series is constant.

    The interval is from a jackknife on Fisher's transform of the correlation, which leaves out one cluster
    after the other. Student's quantile has (number of clusters - 1) degrees of freedom. Ranks are computed
    once, among all observations.

    Args:
        first: one number per observation.
        second: another number per observation.
        clusters: the name of each observation's cluster. Observations of a cluster depend on each other.
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
    whole = _compute_pearson_correlation(of_clusters.sum(axis=0, keepdims=True))[0]
    value = float(whole)
    if len(names) < _MIN_CLUSTERS or abs(value) >= 1:
        return Estimate(value)
    without = np.arctanh(
        np.clip(_compute_pearson_correlation(of_clusters.sum(axis=0) - of_clusters), -0.999999, 0.999999)
    )
    without = without[np.isfinite(without)]
    variance = (len(without) - 1) / len(without) * ((without - without.mean()) ** 2).sum()
    half = compute_student_quantile(LEVEL, len(names) - 1) * math.sqrt(variance)
    middle = math.atanh(value)
    return Estimate(value, math.tanh(middle - half), math.tanh(middle + half))


def _compute_pearson_correlation(sums_n_x_y_xx_yy_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the correlation for each row of sums (n, x, y, xx, yy, xy); NaN if x or y is constant."""
    import numpy as np

    n, x, y, xx, yy, xy = sums_n_x_y_xx_yy_xy.T
    with np.errstate(divide="ignore", invalid="ignore"):
        correlations: NDArray[np.float64] = (n * xy - x * y) / np.sqrt((n * xx - x * x) * (n * yy - y * y))
    return correlations


def fit_logistic_regression(
    columns: NDArray[np.float64], success: NDArray[np.float64], clusters: Sequence[str]
) -> list[Estimate]:
    """Return the effect of each column on success in a logistic regression, in log odds per unit.

    The effects have no value if the likelihood has no maximum, or if there are fewer than two clusters.

    Args:
        columns: one row per observation, one column per explanatory variable. A constant must be a column of
            its own.
        success: 0 or 1 for each observation.
        clusters: the name of each observation's cluster. Observations of a cluster depend on each other.
    """
    import numpy as np

    estimate = _maximize_likelihood(columns, success)
    names = sorted(set(clusters))
    if estimate is None or len(names) < 2:
        return [Estimate(None)] * columns.shape[1]
    fitted = 1 / (1 + np.exp(-columns @ estimate))
    weights = fitted * (1 - fitted)
    information = columns.T @ (columns * weights[:, None])
    cluster_of, changes = np.array(clusters), []
    for name in names:
        rows = cluster_of == name
        of_cluster = columns[rows]
        left = information - of_cluster.T @ (of_cluster * weights[rows][:, None])
        changes.append(-np.linalg.pinv(left) @ (of_cluster.T @ (success[rows] - fitted[rows])))
    spread = np.array(changes)
    variance = (len(names) - 1) / len(names) * (spread**2).sum(axis=0)
    half = compute_student_quantile(LEVEL, len(names) - 1) * np.sqrt(variance)
    return [
        Estimate(float(value), float(value - wide), float(value + wide))
        for value, wide in zip(estimate, half, strict=True)
    ]


def _maximize_likelihood(
    columns: NDArray[np.float64], success: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Return the regression coefficients of highest likelihood; None if Newton's method does not converge."""
    import numpy as np

    estimate = np.zeros(columns.shape[1])
    for _ in range(_MAX_NEWTON_STEPS):
        fitted = 1 / (1 + np.exp(-np.clip(columns @ estimate, -30, 30)))
        information = columns.T @ (columns * (fitted * (1 - fitted))[:, None])
        try:
            change = np.linalg.solve(information, columns.T @ (success - fitted))
        except np.linalg.LinAlgError:
            return None
        estimate = estimate + change
        if not np.isfinite(estimate).all() or np.abs(estimate).max() > _MAX_LOG_ODDS:
            return None
        if np.abs(change).max() < _TOLERANCE:
            return estimate
    return None
