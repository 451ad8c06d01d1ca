"""How far a run is, and who is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Count:
    """How far a run is.

    Attributes:
        answered: tasks that are answered, in every epoch, found answers included.
        failed: tasks that were given up because a request failed.
        total: tasks that are to be answered.
    """

    answered: int
    failed: int
    total: int


Watch: TypeAlias = Callable[[Count], None]
"""Is told how far a run is."""


def unwatched(count: Count) -> None:
    """Tells nobody."""
