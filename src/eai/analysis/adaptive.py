"""A test that chooses its tasks as it goes: the most informative next, until an ability is known well enough.

The difficulties of tasks are known from models that were asked before (`eai.analysis.rasch`). A task tells
most of a model whose chance to solve it is even: its Fisher information is p (1 - p). Near copies of a task
say less than that, for a model fails or solves them together, so that of the tasks whose name was asked
least often the most informative comes next.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

_STEPS = 100
_SMALL = 1e-9


@dataclass(frozen=True, slots=True)
class Estimated:
    """What is known of a model's ability, in logits.

    Attributes:
        value: the ability of highest posterior density; before anything is known it is standard normal.
        error: its standard error by the model: as if tasks were independent and their difficulties known.
    """

    value: float
    error: float


def ability_of(scores: Mapping[str, float], difficulties: Mapping[str, float]) -> Estimated:
    """The ability of a model.

    Args:
        scores: what it was asked, each with its score from 0 to 1.
        difficulties: at least those of these tasks.
    """
    value = 0.0
    for _ in range(_STEPS):
        chances = [_chance(value, difficulties[task]) for task in scores]
        information = 1 + sum(p * (1 - p) for p in chances)
        change = (sum(scores.values()) - sum(chances) - value) / information
        value += max(-1.0, min(1.0, change))
        if abs(change) < _SMALL:
            break
    return Estimated(value, 1 / math.sqrt(information))


def next_tasks(
    number: int, asked: Mapping[str, float], difficulties: Mapping[str, float], names: Mapping[str, str]
) -> tuple[str, ...]:
    """The tasks to be asked next; fewer if there are no more.

    Args:
        number: how many.
        asked: what was asked already, with scores.
        difficulties: of all tasks that may be asked.
        names: what near copies of them share.
    """
    ability = ability_of(asked, difficulties).value
    times = Counter(names[task] for task in asked)
    left = [task for task in difficulties if task not in asked]
    chosen: list[str] = []
    while left and len(chosen) < number:
        task = min(left, key=lambda each: (times[names[each]], abs(difficulties[each] - ability), each))
        times[names[task]] += 1
        chosen.append(task)
        left.remove(task)
    return tuple(chosen)


def _chance(ability: float, difficulty: float) -> float:
    return 1 / (1 + math.exp(difficulty - ability))
