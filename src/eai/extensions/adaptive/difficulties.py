"""The difficulties of tasks, a model's ability, and the tasks that would tell most about it.

The difficulties are known from nine of the paper's models under ``strict``, by the Rasch model
(`eai.extensions.adaptive.rasch`): in logits from the mean ability of these models, with the variance of a
model's ability between names. ``tools/short_tests.py`` computes them for action sequencing and subgoal
decomposition, whose answers are right or wrong without a planner. A task tells most of a model whose chance
to solve it is even: its Fisher information is p (1 - p). Near copies of a task say less than that, for a
model fails or solves them together. So the most informative comes next of the tasks whose name was asked
least often.
"""

from __future__ import annotations

import json
import math
from collections import Counter, defaultdict
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any, NamedTuple

from eai.abilities.protocol import Ability

FILE = "item_difficulties.json"
_STEPS = 100

_SMALL = 1e-9


def item_difficulties(domain: str, ability: Ability) -> Mapping[str, float]:
    """The difficulty of each task of a suite, in the order of the data set; none if they are not known."""
    found: Mapping[str, float] = _tables().get(f"{domain}/{ability.value}", {}).get("difficulties", {})
    return found


def variance_between_names(domain: str, ability: Ability) -> float:
    """How much a model's ability varies from name to name of a suite, in squared logits; 0 if unknown."""
    return float(_tables().get(f"{domain}/{ability.value}", {}).get("variance_between_names", 0.0))


@cache
def _tables() -> dict[str, Any]:
    text = (resources.files("eai.extensions.adaptive") / FILE).read_text(encoding="utf-8")
    by_suite: dict[str, Any] = json.loads(text)
    return by_suite


class _Ability(NamedTuple):
    """A model's ability, in logits.

    Attributes:
        value: the ability of highest posterior density; before anything is known it is standard normal.
        error: its standard error by the model, as if difficulties were known.
    """

    value: float
    error: float


def ability_of(
    scores: Mapping[str, float],
    difficulties: Mapping[str, float],
    names: Mapping[str, str] | None = None,
    variance: float = 0.0,
) -> _Ability:
    """The ability of a model.

    Args:
        scores: what it was asked, each with its score from 0 to 1.
        difficulties: at least those of these tasks.
        names: what near copies share, by task: they tell less together than each alone. They raise the error,
            by the design effect: each name adds the square of its share of the information, times the
            variance between names.
        variance: how much the ability of one model varies from name to name, in squared logits
            (`eai.extensions.adaptive.rasch.variance_between`); 0 if tasks are independent.
    """
    value = 0.0
    for _ in range(_STEPS):
        chances = [_chance(value, difficulties[task]) for task in scores]
        information = 1 + sum(p * (1 - p) for p in chances)
        change = (sum(scores.values()) - sum(chances) - value) / information
        value += max(-1.0, min(1.0, change))
        if abs(change) < _SMALL:
            break
    between = variance * _concentration(value, scores, difficulties, names or {})
    return _Ability(value, math.sqrt(1 / information + between))


def _concentration(
    ability: float, scores: Mapping[str, float], difficulties: Mapping[str, float], names: Mapping[str, str]
) -> float:
    """How unevenly the information is from names: 1 where all is from one, 1/n where it is from n alike."""
    informed: defaultdict[str, float] = defaultdict(float)
    for task in scores:
        p = _chance(ability, difficulties[task])
        informed[names.get(task, task)] += p * (1 - p)
    whole = sum(informed.values())
    return sum((each / whole) ** 2 for each in informed.values()) if whole else 0.0


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
