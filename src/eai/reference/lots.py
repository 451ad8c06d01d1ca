"""The lots that the reference draws between alternatives, which its published runs left to chance.

It calls Python's ``random.choice``: once for every subgoal that is kept, alternatives or not, then once for
every ``or`` that is left. These are the draws that follow ``random.seed(0)`` before each answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import TypeVar

SEED = 0

_T = TypeVar("_T")


class Lots:
    """The lots for one answer; a verdict must take them in the reference's order.

    Draws among one are made up for when there is a choice, which most answers never leave.
    """

    __slots__ = ("_random", "_without_choice")

    def __init__(self) -> None:
        self._random: Random | None = None
        self._without_choice = 0

    def choice(self, options: Sequence[_T]) -> _T:
        """The option that the lot falls on."""
        if len(options) == 1:
            self._without_choice += 1
            return options[0]
        if self._random is None:
            self._random = Random(SEED)  # noqa: S311 - the same generator as the reference's
        for _ in range(self._without_choice):
            self._random.choice((None,))
        self._without_choice = 0
        return self._random.choice(options)
