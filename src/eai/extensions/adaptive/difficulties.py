"""The difficulties of tasks, a model's ability, and the most informative tasks to ask next.

The difficulties come from scores of nine of the paper's models by the rules ``strict``. They are estimated by
the Rasch model (`eai.extensions.adaptive.rasch`), in logits, and 0 is the mean ability of these models. Tasks
with equal names form a group. A model's ability differs between groups. The variance between groups is stored
with the difficulties. ``tools/short_tests.py`` computes difficulties for action sequencing and subgoal
decomposition, because these answers are right or wrong without a planner.

A task is most informative for a model that solves it with probability p = 1/2: its Fisher information is
p (1 - p). Near copies of a task have the same name (title). A model solves or fails them together, so further
copies are less informative. Therefore names that were asked least often come first, and among their tasks the
most informative task.
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
_MAX_STEPS = 100

_CONVERGENCE_LOGITS = 1e-9


def load_task_difficulties(domain: str, ability: Ability) -> Mapping[str, float]:
    """Return a mapping from task id to difficulty in logits, in the order of the data set.

    It is empty if no difficulties are published for the ability in the domain.
    """
    difficulties: Mapping[str, float] = (
        _load_difficulty_tables().get(f"{domain}/{ability.value}", {}).get("difficulties", {})
    )
    return difficulties


def load_ability_variance_between_task_groups(domain: str, ability: Ability) -> float:
    """Return the variance of a model's ability between groups of tasks, in squared logits; 0 if unknown.

    A group has all tasks with one name: near copies. The variance was estimated for one kind of questions
    (``ability``) in one domain.
    """
    return float(
        _load_difficulty_tables().get(f"{domain}/{ability.value}", {}).get("variance_between_names", 0.0)
    )


@cache
def _load_difficulty_tables() -> dict[str, Any]:
    text = (resources.files("eai.extensions.adaptive") / FILE).read_text(encoding="utf-8")
    by_suite: dict[str, Any] = json.loads(text)
    return by_suite


class _RaschAbilityEstimate(NamedTuple):
    """A model's ability, in logits.

    Attributes:
        value: the ability of highest posterior density, for a standard normal prior.
        error: the standard error of the ability by the Rasch model, if the difficulties of tasks are exact.
    """

    value: float
    error: float


def estimate_ability(
    scores: Mapping[str, float],
    difficulties: Mapping[str, float],
    name_by_task: Mapping[str, str] | None = None,
    variance: float = 0.0,
) -> _RaschAbilityEstimate:
    """Estimate the ability of a model.

    Args:
        scores: the scores, from 0 to 1, of the tasks that were asked.
        difficulties: difficulties of at least these tasks.
        name_by_task: name of each task. Near copies share a name, so their scores depend on each other.
            Therefore ``variance`` times a concentration is added to the square of the standard error. The
            concentration is 1 for a single name, and 1/n for n names with equal Fisher information
            (`_compute_information_concentration_on_names`).
        variance: variance of one model's ability between groups of tasks with one name, in squared logits
            (see `rasch.estimate_ability_variance_between_task_groups`); 0 if tasks are independent.
    """
    value = 0.0
    for _ in range(_MAX_STEPS):
        chances = [_compute_success_probability(value, difficulties[task]) for task in scores]
        information = 1 + sum(p * (1 - p) for p in chances)
        change = (sum(scores.values()) - sum(chances) - value) / information
        value += max(-1.0, min(1.0, change))
        if abs(change) < _CONVERGENCE_LOGITS:
            break
    between = variance * _compute_information_concentration_on_names(
        value, scores, difficulties, name_by_task or {}
    )
    return _RaschAbilityEstimate(value, math.sqrt(1 / information + between))


def _compute_information_concentration_on_names(
    ability: float,
    scores: Mapping[str, float],
    difficulties: Mapping[str, float],
    name_by_task: Mapping[str, str],
) -> float:
    """Return how concentrated the Fisher information is on few task names: the sum of their squared shares.

    The share of a task name is the part of the information that comes from the tasks with this name. The
    result, a Herfindahl index, is 1 for a single name, and 1/n for n names with equal shares.
    """
    informed: defaultdict[str, float] = defaultdict(float)
    for task in scores:
        p = _compute_success_probability(ability, difficulties[task])
        informed[name_by_task.get(task, task)] += p * (1 - p)
    whole = sum(informed.values())
    return sum((information / whole) ** 2 for information in informed.values()) if whole else 0.0


def choose_most_informative_tasks(
    max_task_count: int,
    score_by_asked_task: Mapping[str, float],
    difficulties: Mapping[str, float],
    name_by_task: Mapping[str, str],
) -> tuple[str, ...]:
    """Return the ids of the most informative tasks to ask next.

    Args:
        max_task_count: maximum number of tasks to return.
        score_by_asked_task: scores of the tasks that were already asked.
        difficulties: difficulties of all tasks that may be asked.
        name_by_task: name of each task. Near copies share a name.
    """
    ability = estimate_ability(score_by_asked_task, difficulties).value
    times = Counter(name_by_task[task] for task in score_by_asked_task)
    left = [task for task in difficulties if task not in score_by_asked_task]
    chosen: list[str] = []
    while left and len(chosen) < max_task_count:
        task = min(
            left, key=lambda each: (times[name_by_task[each]], abs(difficulties[each] - ability), each)
        )
        times[name_by_task[task]] += 1
        chosen.append(task)
        left.remove(task)
    return tuple(chosen)


def _compute_success_probability(ability: float, difficulty: float) -> float:
    return 1 / (1 + math.exp(difficulty - ability))
