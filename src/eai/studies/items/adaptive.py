"""A test that chooses its tasks as it goes: the most informative next, until an ability is known well enough.

The difficulties of tasks are known from nine of the paper's models under ``strict``, by the Rasch model
(`eai.studies.items.rasch`): in logits from the mean ability of these models, with the variance of a model's
ability between names, for action sequencing and subgoal decomposition, whose answers are right or wrong
without a planner; ``tools/short_tests.py`` writes them. A task tells most of a model whose chance to solve it
is even: its Fisher information is p (1 - p). Near copies of a task say less than that, for a model fails or
solves them together, so that of the tasks whose name was asked least often the most informative comes next.
"""

from __future__ import annotations

import json
import math
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TypedDict

from eai.abilities.protocol import Ability

FILE = "item_difficulties.json"


_STEPS = 100

_SMALL = 1e-9


def item_difficulties(domain: str, ability: Ability) -> Mapping[str, float]:
    """The difficulty of each task of a suite, in the order of the data set; none if they are not known."""
    found = _known().get(f"{domain}/{ability.value}")
    return found["difficulties"] if found else {}


def variance_between_names(domain: str, ability: Ability) -> float:
    """How much a model's ability varies from name to name of a suite, in squared logits; 0 if unknown."""
    found = _known().get(f"{domain}/{ability.value}")
    return found["variance_between_names"] if found else 0.0


class _Suite(TypedDict):
    variance_between_names: float
    difficulties: dict[str, float]


@cache
def _known() -> dict[str, _Suite]:
    found: dict[str, _Suite] = json.loads(
        (resources.files("eai.studies.items") / FILE).read_text(encoding="utf-8")
    )
    return found


@dataclass(frozen=True, slots=True)
class Estimated:
    """What is known of a model's ability, in logits.

    Attributes:
        value: the ability of highest posterior density; before anything is known it is standard normal.
        error: its standard error by the model, as if difficulties were known.
    """

    value: float
    error: float


@dataclass(frozen=True, slots=True)
class NearCopies:
    """Which tasks are near copies of each other, and what these have in common for a model.

    Attributes:
        names: what near copies share, for each task.
        variance: how much the ability of one model varies from name to name, in squared logits
            (`eai.studies.items.rasch.variance_between`); 0 if tasks are independent.
    """

    names: Mapping[str, str]
    variance: float


INDEPENDENT = NearCopies({}, 0.0)


def ability_of(
    scores: Mapping[str, float], difficulties: Mapping[str, float], copies: NearCopies = INDEPENDENT
) -> Estimated:
    """The ability of a model.

    Args:
        scores: what it was asked, each with its score from 0 to 1.
        difficulties: at least those of these tasks.
        copies: tasks that tell less together than each alone. They raise the error, by the design effect:
            each name adds the square of its share of the information, times the variance between names.
    """
    value = 0.0
    for _ in range(_STEPS):
        chances = [_chance(value, difficulties[task]) for task in scores]
        information = 1 + sum(p * (1 - p) for p in chances)
        change = (sum(scores.values()) - sum(chances) - value) / information
        value += max(-1.0, min(1.0, change))
        if abs(change) < _SMALL:
            break
    return Estimated(value, math.sqrt(1 / information + _between(value, scores, difficulties, copies)))


def _between(
    ability: float, scores: Mapping[str, float], difficulties: Mapping[str, float], copies: NearCopies
) -> float:
    """The variance of the ability from which names were asked, and how much each told."""
    told: defaultdict[str, float] = defaultdict(float)
    for task in scores:
        p = _chance(ability, difficulties[task])
        told[copies.names.get(task, task)] += p * (1 - p)
    whole = sum(told.values())
    return copies.variance * sum((each / whole) ** 2 for each in told.values()) if whole else 0.0


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
