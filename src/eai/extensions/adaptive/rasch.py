"""The Rasch model: how able models are and how difficult tasks are, from who solves what.

A model of ability t solves a task of difficulty b with the chance 1 / (1 + exp(b - t)). Abilities and
difficulties are those of highest posterior density, where abilities have a standard normal prior and
difficulties one of standard deviation 2, so that tasks that all models solve, or none, have a difficulty too.
Scores between 0 and 1 count as that many successes. With few models a second parameter a task, its
discrimination, predicts no better; how a task agrees with the others is its item-rest correlation.
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
"""The standard deviation of difficulties, before anything is known."""

_STEPS = 200
_SMALL = 1e-10


@dataclass(frozen=True, slots=True)
class Rasch:
    """A fitted model.

    Attributes:
        abilities: of each model.
        difficulties: of each task.
        difficulty_errors: their standard errors, as if models were independent.
    """

    abilities: Matrix
    difficulties: Matrix
    difficulty_errors: Matrix

    def chances(self) -> Matrix:
        """The chance of each model (row) in each task (column)."""
        return chance(self.abilities[:, None], self.difficulties[None, :])


def chance(ability: Matrix, difficulty: Matrix) -> Matrix:
    """The chance of success."""
    import numpy as np

    return 1 / (1 + np.exp(difficulty - ability))


def fit_rasch(scores: Matrix) -> Rasch:
    """Fit the model by Newton's method, abilities and difficulties in turn.

    Args:
        scores: a row a model, a column a task, from 0 to 1; not a number where there is no answer.
    """
    import numpy as np

    known = ~np.isnan(scores)
    given = np.where(known, scores, 0.0)
    abilities, difficulties = np.zeros(scores.shape[0]), np.zeros(scores.shape[1])
    prior = 1 / DIFFICULTY_SPREAD**2
    for _ in range(_STEPS):
        before = abilities, difficulties
        p = chance(abilities[:, None], difficulties[None, :]) * known
        slope = ((given - p).sum(axis=1) - abilities) / (_information(p).sum(axis=1) + 1)
        abilities = abilities + slope
        p = chance(abilities[:, None], difficulties[None, :]) * known
        slope = ((p - given).sum(axis=0) - prior * difficulties) / (_information(p).sum(axis=0) + prior)
        difficulties = difficulties + slope
        moved = max(np.abs(abilities - before[0]).max(), np.abs(difficulties - before[1]).max())
        if moved < _SMALL:
            break
    p = chance(abilities[:, None], difficulties[None, :]) * known
    return Rasch(abilities, difficulties, 1 / np.sqrt(_information(p).sum(axis=0) + prior))


def _information(p: Matrix) -> Matrix:
    return p * (1 - p)


def item_rest(scores: Matrix) -> Matrix:
    """Of each task the correlation over models of its score with that in all others; not a number if none.

    Args:
        scores: without gaps.
    """
    import numpy as np

    rest = scores.sum(axis=1, keepdims=True) - scores
    with np.errstate(divide="ignore", invalid="ignore"):
        centred = scores - scores.mean(axis=0)
        others = rest - rest.mean(axis=0)
        found: Matrix = (centred * others).sum(axis=0) / np.sqrt(
            (centred**2).sum(axis=0) * (others**2).sum(axis=0)
        )
    return found


def reliability(scores: Matrix) -> float | None:
    """Cronbach's alpha of tasks over models; None where nothing varies."""
    number = scores.shape[1]
    whole = float(scores.sum(axis=1).var(ddof=1))
    if number < 2 or not whole:
        return None
    parts = float(scores.var(axis=0, ddof=1).sum())
    return float(number / (number - 1) * (1 - parts / whole))


def variance_between(scores: Matrix, fitted: Rasch, names: Sequence[str]) -> float:
    """How much a model's ability varies from name to name, in squared logits, beyond what chance does.

    By moments: two tasks of a name that a model finds more difficult than it should deviate together, to
    first order by the product of their information and of what they share. 0 where no name has two tasks, or
    where tasks of a name agree no more than others.

    Args:
        scores: those that the Rasch model was fitted to.
        fitted: that Rasch model.
        names: of each task, what it shares with its near copies.
    """
    import numpy as np

    known = ~np.isnan(scores)
    chances = fitted.chances()
    deviations = np.where(known, scores - chances, 0.0)
    information = np.where(known, _information(chances), 0.0)
    shared = possible = 0.0
    for name in set(names):
        of_name = [place for place, each in enumerate(names) if each == name]
        d, i = deviations[:, of_name], information[:, of_name]
        shared += float((d.sum(axis=1) ** 2 - (d**2).sum(axis=1)).sum())
        possible += float((i.sum(axis=1) ** 2 - (i**2).sum(axis=1)).sum())
    return max(0.0, shared / possible) if possible else 0.0
