"""The paper's average performance of a model in a domain."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import fmean

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.protocol import Ability

AVERAGE = "average_performance"
"""The name of the metric."""


def average_performance(values: Mapping[tuple[Ability, str], float | None]) -> float | None:
    """The mean over the four abilities in percent, or None unless all are known.

    An ability counts with its main metric, transition modeling with the mean of its two (checked against the
    paper's overview table, which does not say so).

    Args:
        values: (ability, metric) -> percent.
    """
    means = []
    for ability, declared in DECLARATIONS.items():
        metrics = declared.averaged
        known = [value for metric in metrics if (value := values.get((ability, metric))) is not None]
        if len(known) < len(metrics):
            return None
        means.append(fmean(known))
    return fmean(means)
