"""Short tests: forty fixed tasks of a suite whose results are close to the results of the whole suite.

A suite has all tasks of a benchmark for one ability, such as planning.

``tools/short_tests.py`` chooses them by the scores of nine of the paper's models under the
scoring rules ``strict``.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources

from eai.abilities.protocol import Ability

FILE = "short_tests.json"


def short_test(domain: str, ability: Ability) -> tuple[str, ...]:
    """Return the task ids of a suite's short test in the order of the data set; empty without such a test."""
    return tuple(_load_task_ids_by_suite().get(f"{domain}/{ability.value}", ()))


@cache
def _load_task_ids_by_suite() -> dict[str, list[str]]:
    text = (resources.files("eai.extensions.adaptive") / FILE).read_text(encoding="utf-8")
    by_suite: dict[str, list[str]] = json.loads(text)
    return by_suite
