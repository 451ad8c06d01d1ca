"""The average performance of a model in a domain, as the paper has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from eai.abilities.declaration import the_four
from eai.abilities.protocol import FOUR, Ability

AVERAGE = "average_performance"
"""The name of the metric."""


Place: TypeAlias = tuple[Ability, str]
"""A metric of an ability."""


def average_weights(values: Mapping[Place, float | None] | None = None) -> dict[Place, float]:
    """How much each metric counts in the average: a quarter an ability, halved where it has two metrics.

    Args:
        values: what is known in percent; a metric that is declared to stand in the place of one of the
            paper's does so where it is known. Without values the metrics are the paper's.
    """
    known = values or {}
    weights: dict[Place, float] = {}
    for ability, declared in the_four().items():
        for metric in declared.averaged:
            place = ability, declared.instead.get(metric, metric)
            place = place if known.get(place) is not None else (ability, metric)
            weights[place] = 1 / (len(FOUR) * len(declared.averaged))
    return weights


def average_performance(values: Mapping[Place, float | None]) -> float | None:
    """The mean over the four abilities in percent, or None unless all are known.

    ``(goal F1 + subgoal task success + action task success + (operator F1 + planner success) / 2) / 4``: the
    paper's section "Average Performance". Where it is known which plans work, that rate stands in the place
    of planner success.

    Args:
        values: (ability, metric) -> percent.
    """
    total = 0.0
    for place, weight in average_weights(values).items():
        value = values.get(place)
        if value is None:
            return None
        total += weight * value
    return total
