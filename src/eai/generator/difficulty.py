"""How difficult a task is expected to be, from its known plan and its goals.

By a ridge regression of the difficulties that the public tasks of a household had in action sequencing for
nine of the paper's models (`eai.studies.items.adaptive`, logits from their mean ability), which
``tools/task_difficulty.py`` fits. It says little of a single task: each estimate has its error, the root
of the mean squared difference on titles that were left out.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources

from eai.abilities.task import Task

FILE = "difficulty.json"

FEATURES = ("log steps", "operators", "log goals")
"""What is known of any task with a plan: its steps, how many operators they are of, and its goals."""


def features_of(task: Task) -> Sequence[float]:
    """The features of a task with a plan, in order."""
    steps = [action.operator for action in task.script]
    return math.log(len(steps)), float(len(set(steps))), math.log(1 + len(task.goals))


@dataclass(frozen=True, slots=True)
class Expected:
    """An expected difficulty in logits, and its standard error."""

    value: float
    error: float


@dataclass(frozen=True, slots=True)
class DifficultyModel:
    """What difficulty is made of in one household.

    Attributes:
        intercept: the difficulty of a task whose features are all zero.
        weights: what one unit of each feature adds.
        error: of an estimate for a task of a title that had no part in the fit.
        r_squared: of the variance of public difficulties the part that such estimates explain.
        rank_correlation: of such estimates with difficulties, by Spearman.
    """

    intercept: float
    weights: Sequence[float]
    error: float
    r_squared: float
    rank_correlation: float

    def expected(self, task: Task) -> Expected | None:
        """The expected difficulty of a task; None if it has no plan."""
        if not task.script:
            return None
        terms = zip(self.weights, features_of(task), strict=True)
        value = self.intercept + sum([weight * feature for weight, feature in terms])
        return Expected(round(value, 2), self.error)


def difficulty_model(domain: str) -> DifficultyModel | None:
    """The model of a household; None of any other benchmark, whose tasks nobody has been asked."""
    return _models().get(domain)


@cache
def _models() -> Mapping[str, DifficultyModel]:
    text = (resources.files("eai.generator") / FILE).read_text(encoding="utf-8")
    return {name: DifficultyModel(**found) for name, found in json.loads(text).items()}
