"""The Rasch model: abilities of models and difficulties of tasks, estimated from their scores.

A model of ability t solves a task of difficulty b with probability 1 / (1 + exp(b - t)). Estimates have the
highest posterior density. Abilities have a standard normal prior. Difficulties have a normal prior with
standard deviation 2, so a task that every model solves, or no model, also gets a difficulty. A score between
0 and 1 counts as a fractional success. With few models, a second parameter for each task (its discrimination)
does not improve predictions. The item-rest correlation measures the agreement of a task with all other tasks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

DIFFICULTY_SPREAD = 2.0
"""Standard deviation of the prior distribution of task difficulties, in logits."""

_MAX_STEPS = 200
_CONVERGENCE_LOGITS = 1e-10

_DIGITS = 9
"""Number of decimals of sums of scores. Without rounding, equal sums may differ in their last bits."""


@dataclass(frozen=True, slots=True)
class RaschModel:
    """A fitted Rasch model.

    Attributes:
        abilities: ability of each model, in logits.
        difficulties: difficulty of each task, in logits.
        difficulty_errors: standard errors of the difficulties, in logits. They assume that models are
            independent.
    """

    abilities: Matrix
    difficulties: Matrix
    difficulty_errors: Matrix

    def predict_success(self) -> Matrix:
        """Return the probability that each model (row) solves each task (column)."""
        return compute_success_probability(self.abilities[:, None], self.difficulties[None, :])


def compute_success_probability(ability: Matrix, difficulty: Matrix) -> Matrix:
    """Return the probability that a model solves a task, given the ability and the difficulty."""
    import numpy as np

    return 1 / (1 + np.exp(difficulty - ability))


def fit_rasch(scores: Matrix) -> RaschModel:
    """Fit the Rasch model by Newton's method, which changes abilities and difficulties in turn.

    Args:
        scores: a row for each model and a column for each task; scores from 0 to 1, NaN for missing answers.
    """
    import numpy as np

    is_known = ~np.isnan(scores)
    given = np.where(is_known, scores, 0.0)
    abilities, difficulties = np.zeros(scores.shape[0]), np.zeros(scores.shape[1])
    prior = 1 / DIFFICULTY_SPREAD**2
    for _ in range(_MAX_STEPS):
        before = abilities, difficulties
        p = compute_success_probability(abilities[:, None], difficulties[None, :]) * is_known
        slope = ((given - p).sum(axis=1) - abilities) / (_compute_fisher_information(p).sum(axis=1) + 1)
        abilities = abilities + slope
        p = compute_success_probability(abilities[:, None], difficulties[None, :]) * is_known
        slope = ((p - given).sum(axis=0) - prior * difficulties) / (
            _compute_fisher_information(p).sum(axis=0) + prior
        )
        difficulties = difficulties + slope
        largest_change = max(np.abs(abilities - before[0]).max(), np.abs(difficulties - before[1]).max())
        if largest_change < _CONVERGENCE_LOGITS:
            break
    p = compute_success_probability(abilities[:, None], difficulties[None, :]) * is_known
    return RaschModel(
        abilities, difficulties, 1 / np.sqrt(_compute_fisher_information(p).sum(axis=0) + prior)
    )


def _compute_fisher_information(success_probability: Matrix) -> Matrix:
    return success_probability * (1 - success_probability)


def compute_item_rest_correlations(scores: Matrix) -> Matrix:
    """Return for each task the correlation of its score with the sum of the scores of all other tasks.

    The correlation is computed over models. It is NaN if all models have the same score, or the same sum.

    Args:
        scores: a row for each model and a column for each task, without NaN.
    """
    import numpy as np

    rest = scores.sum(axis=1, keepdims=True) - scores
    with np.errstate(divide="ignore", invalid="ignore"):
        centred = (scores - scores.mean(axis=0)).round(_DIGITS)
        others = (rest - rest.mean(axis=0)).round(_DIGITS)
        correlations: Matrix = (centred * others).sum(axis=0) / np.sqrt(
            (centred**2).sum(axis=0) * (others**2).sum(axis=0)
        )
    return correlations


def estimate_reliability(scores: Matrix) -> float | None:
    """Return Cronbach's alpha, the reliability of a test.

    Return None if there is one task, or if all models have the same total score.
    """
    number, totals = scores.shape[1], scores.sum(axis=1).round(_DIGITS)
    if number < 2 or totals.min() == totals.max():
        return None
    parts = float(scores.var(axis=0, ddof=1).sum())
    return float(number / (number - 1) * (1 - parts / totals.var(ddof=1)))


def estimate_ability_variance_between_task_groups(
    scores: Matrix, fitted: RaschModel, task_names: Sequence[str]
) -> float:
    """Return the variance of a model's ability between groups of tasks with equal names, in squared logits.

    Near copies of a task share a name. Variation by chance is not part of the result.

    If a group is unexpectedly difficult for a model, its scores in two tasks of the group both fall below the
    expected scores. To first order, the mean product of the two deviations is ``V * I1 * I2``, where ``V`` is
    the variance, and ``I1`` and ``I2`` are the tasks' Fisher information. The result is the sum of the
    products of deviations over all pairs in groups, divided by the sum of ``I1 * I2`` (method of moments). It
    is 0 if no two tasks share a name, or if such tasks do not deviate together.

    Args:
        scores: the scores that the Rasch model was fitted to.
        fitted: the fitted Rasch model.
        task_names: name of each task. Near copies share a name.
    """
    import numpy as np

    known = ~np.isnan(scores)
    chances = fitted.predict_success()
    deviations = np.where(known, scores - chances, 0.0)
    information = np.where(known, _compute_fisher_information(chances), 0.0)
    shared = possible = 0.0
    for name in dict.fromkeys(task_names):
        of_name = [place for place, each in enumerate(task_names) if each == name]
        d, i = deviations[:, of_name], information[:, of_name]
        shared += float((d.sum(axis=1) ** 2 - (d**2).sum(axis=1)).sum())
        possible += float((i.sum(axis=1) ** 2 - (i**2).sum(axis=1)).sum())
    return max(0.0, shared / possible) if possible else 0.0
