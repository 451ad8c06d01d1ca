"""Short tests: forty tasks of a suite that stand for all of it, the same for everybody.

``tools/short_tests.py`` chooses and writes them, from answers of nine of the paper's models under ``strict``.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources

from eai.abilities.protocol import Ability

FILE = "short_tests.json"
SHORT = "short"
"""What the command line calls them."""


def short_test(domain: str, ability: Ability) -> tuple[str, ...]:
    """The ids of the tasks of a suite's short test, in the order of the data set; none if it has none."""
    return _short_tests().get(f"{domain}/{ability.value}", ())


@cache
def _short_tests() -> dict[str, tuple[str, ...]]:
    text = (resources.files("eai.studies.items") / FILE).read_text(encoding="utf-8")
    return {suite: tuple(tasks) for suite, tasks in json.loads(text).items()}
