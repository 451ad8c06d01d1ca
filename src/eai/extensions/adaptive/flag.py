"""Flags: reasons for caution with the answers to a task."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, TypeAlias

from eai.results.lines import SuiteKey

Flag: TypeAlias = Literal[
    "saturated", "unsolved", "unsolved: no plan", "unsolved: plan exists", "negative", "ambiguous names"
]
"""A reason for caution with the answers to a task.

- saturated: all models solve it, or all but one.
- unsolved: no model solves it, and it is unknown whether a solution exists.
- unsolved: no plan: the built-in planner proves that no plan exists.
- unsolved: plan exists: the gold answer or an answer made from the built-in planner's plan is right.
- negative: models that are better on other tasks are worse on this one.
- ambiguous names: its goals make the same demand on several objects that share a name in answers.
"""

FlagReader = Callable[[SuiteKey, str, bool], Iterator[Flag]]
"""Yields the flags of a task, given its suite, its id, and whether no model solves it."""
