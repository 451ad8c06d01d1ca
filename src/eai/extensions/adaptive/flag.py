"""Reasons for caution with the answers to a task."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, TypeAlias

from eai.results.lines import SuiteKey

Flag: TypeAlias = Literal[
    "saturated", "unsolved", "unsolved: no plan", "unsolved: plan exists", "negative", "ambiguous names"
]
"""A reason for caution with the answers to a task.

- saturated: all models solve it, or all but one.
- unsolved: no model solves it, and nobody knows whether it can be solved.
- unsolved: no plan: the built-in planner finds that nothing can solve it.
- unsolved: plan exists: an answer made of the built-in planner's plan is right.
- negative: models that are better elsewhere are worse here.
- ambiguous names: its goals ask for the same of several objects that answers call by one name.
"""

TellsFlags = Callable[[SuiteKey, str, bool], Iterator[Flag]]
"""Finds the flags of a task, given its suite, its id, and whether no model solves it."""
