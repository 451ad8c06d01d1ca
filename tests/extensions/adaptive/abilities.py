"""The ability of a made-up model, as the analysis of items has it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from eai.extensions.adaptive.study import SuiteScores, estimate_model_ability_above_mean
from eai.results.table import Estimate
from studies.effects import MODELS, Answer


def ability(run: Sequence[Answer]) -> Estimate:
    """Return the ability of the second-best model, as the analysis of items estimates it."""
    tasks = {each.task: each.name for each in run}
    matrix = np.zeros((MODELS, len(tasks)))
    places = {task: place for place, task in enumerate(tasks)}
    for each in run:
        matrix[each.model, places[each.task]] = each.success
    scores = SuiteScores(tuple(map(str, range(MODELS))), tuple(tasks), tuple(tasks.values()), matrix)
    return estimate_model_ability_above_mean(scores, MODELS - 2)
