"""How difficult the tasks of a suite were for nine of the paper's models, under ``strict``.

By the Rasch model (`eai.analysis.rasch`), in logits from the mean ability of these models. Known of action
sequencing and subgoal decomposition, whose answers are right or wrong without a planner;
``tools/short_tests.py`` writes them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources

from eai.abilities.protocol import Ability

FILE = "item_difficulties.json"


def item_difficulties(domain: str, ability: Ability) -> Mapping[str, float]:
    """The difficulty of each task of a suite, in the order of the data set; none if they are not known."""
    return _difficulties().get(f"{domain}/{ability.value}", {})


@cache
def _difficulties() -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = json.loads(
        (resources.files("eai.benchmarks") / FILE).read_text(encoding="utf-8")
    )
    return found
