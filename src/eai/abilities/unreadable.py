"""Answers that nothing can be read from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why nothing can be read from an answer, and at which of its steps, if it is at one."""

    reason: str
    step: int | None = None
