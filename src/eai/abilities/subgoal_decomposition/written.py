"""Subgoals as a model writes them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class WrittenSubgoals:
    """The subgoals of an answer in order, each a formula as text, and the names of the repairs made."""

    subgoals: tuple[str, ...]
    repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why no subgoals can be read from an answer."""

    reason: str
