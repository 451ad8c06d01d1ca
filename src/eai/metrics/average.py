"""The paper's average performance of a model in a domain."""

from __future__ import annotations

from collections.abc import Mapping

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.protocol import Ability

AVERAGE = "average_performance"
"""The name of the metric."""


def average_weights() -> dict[tuple[Ability, str], float]:
    """How much each metric counts in the average: a quarter an ability, halved where it has two metrics."""
    return {
        (ability, metric): 1 / (len(DECLARATIONS) * len(declared.averaged))
        for ability, declared in DECLARATIONS.items()
        for metric in declared.averaged
    }


def average_performance(values: Mapping[tuple[Ability, str], float | None]) -> float | None:
    """The mean over the four abilities in percent, or None unless all are known.

    ``(goal F1 + subgoal task success + action task success + (operator F1 + planner success) / 2) / 4``: the
    paper's section "Average Performance".

    Args:
        values: (ability, metric) -> percent.
    """
    total = 0.0
    for place, weight in average_weights().items():
        value = values.get(place)
        if value is None:
            return None
        total += weight * value
    return total
