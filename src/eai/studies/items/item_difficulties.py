"""How difficult the tasks of a suite were for nine of the paper's models, under ``strict``.

By the Rasch model (`eai.studies.items.rasch`), in logits from the mean ability of these models, with the
variance of a model's ability between names. Known of action sequencing and subgoal decomposition, whose
answers are right or wrong without a planner; ``tools/short_tests.py`` writes them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import TypedDict

from eai.abilities.protocol import Ability

FILE = "item_difficulties.json"


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
