"""Made-up answers of nine models to similar tasks, and the effects that analyses find in them."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from eai.results.table import Estimate
from eai.studies.cofactors.effects import compute_rank_correlation, fit_logistic_regression

MODELS = 9


class Answer(NamedTuple):
    """A made-up answer: its name, its task, who answered, the task's cofactor, whether it succeeds."""

    name: str
    task: str
    model: int
    cofactor: float
    success: bool


def answers(generator: random.Random, sizes: Sequence[int]) -> list[Answer]:
    """Return answers of models with different abilities, to tasks of names of the given sizes."""
    found = []
    for name, size in enumerate(sizes):
        hardness, shared = generator.gauss(0, 2), generator.gauss(0, 1)
        for task in range(size):
            cofactor = math.sqrt(0.7) * shared + math.sqrt(0.3) * generator.gauss(0, 1)
            for model in range(MODELS):
                score = (model - MODELS // 2) / 3 - cofactor + hardness
                success = generator.random() < 1 / (1 + math.exp(-score))
                found.append(Answer(str(name), f"{name}/{task}", model, cofactor, success))
    return found


def log_odds(run: Sequence[Answer]) -> Estimate:
    """Return the effect of the cofactor in the adjusted table."""
    columns = np.array([[e.cofactor, *(float(e.model == m) for m in range(MODELS))] for e in run])
    return fit_logistic_regression(columns, np.array([float(e.success) for e in run]), [e.name for e in run])[
        0
    ]


def correlation(run: Sequence[Answer]) -> Estimate:
    """Return the rank correlation of one model's success with the cofactor."""
    of_model = [each for each in run if each.model == MODELS // 2]
    names = [each.name for each in of_model]
    return compute_rank_correlation(
        [float(e.success) for e in of_model], [e.cofactor for e in of_model], names
    )
