"""Logistic regression with standard errors that know which observations are near copies.

The estimate is maximum likelihood, by Newton's method. Its variance is the jackknife over clusters (each left
out in turn, to first order: CR3 of Bell and McCaffrey, 2002), with Student's quantile for as many degrees of
freedom as there are clusters but one: the usual sandwich is too narrow where clusters are few or of unequal
size (``bench/coverage.py``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from eai.results.certainty import LEVEL, two_sided_quantile

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_STEPS = 40
_SMALL = 1e-9
_LARGEST = 12.0
"""Log odds above this per unit are those of a column that tells success for sure: there is no maximum."""


@dataclass(frozen=True, slots=True)
class Effect:
    """How much one column changes the log odds of success by one unit of it.

    Attributes:
        value: log odds.
        low: the lower bound of the interval of 95 %.
        high: the upper one.
    """

    value: float
    low: float
    high: float


def fit_logit(
    columns: NDArray[np.float64], success: NDArray[np.float64], clusters: Sequence[str]
) -> list[Effect] | None:
    """The effects of columns on success; None if there is no maximum, or fewer than two clusters.

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
        return None
    fitted = 1 / (1 + np.exp(-columns @ estimate))
    weights = fitted * (1 - fitted)
    information = columns.T @ (columns * weights[:, None])
    place = {name: number for number, name in enumerate(names)}
    member = np.array([place[name] for name in clusters])
    changes = []
    for number in range(len(names)):
        rows = member == number
        part = columns[rows]
        left = information - part.T @ (part * weights[rows][:, None])
        changes.append(-np.linalg.pinv(left) @ (part.T @ (success[rows] - fitted[rows])))
    spread = np.array(changes)
    variance = (len(names) - 1) / len(names) * (spread**2).sum(axis=0)
    half = two_sided_quantile(LEVEL, len(names) - 1) * np.sqrt(variance)
    return [
        Effect(float(value), float(value - wide), float(value + wide))
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
