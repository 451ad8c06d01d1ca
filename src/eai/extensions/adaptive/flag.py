"""Flags of a task: reasons to use the answers to it with caution."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, TypeAlias

from eai.results.lines import SuiteKey

Flag: TypeAlias = Literal[
    "saturated", "unsolved", "unsolved: no plan", "unsolved: plan exists", "negative", "ambiguous names"
]
"""A reason to use the answers to a task with caution.

- saturated: all models solve the task, or all but one.
- unsolved: no model solves it, and it is unknown whether a solution exists.
- unsolved: no plan: the built-in planner proves that no plan exists.
- unsolved: plan exists: the gold answer or an answer made from the built-in planner's plan is right.
- negative: models that are better on other tasks are worse on this task.
- ambiguous names: the task's goals require the same of several objects that have one name in answers.
"""

FlagReader = Callable[[SuiteKey, str, bool], Iterator[Flag]]
"""Function that yields the flags of a task: reasons to use the answers to it with caution.

Its arguments are the task's benchmark and ability, the task id, and whether all models fail the task.
"""
