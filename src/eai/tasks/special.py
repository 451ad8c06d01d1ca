"""Special tasks: tasks that may be impossible or ambiguous, and tasks whose goals forbid hazards."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class ImpossibleTaskMark:
    """Marks a task that an answer may call impossible, rightly or wrongly.

    Attributes:
        missing: the facts whose absence makes the goals unreachable; empty if a plan reaches them.
    """

    missing: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class AmbiguousTaskMark:
    """Marks an ambiguous task: an answer may ask for the meant object.

    Prompts state the goals of the task only by its instruction.

    Attributes:
        fits: the names of the objects that the instruction may mean; the meant object comes first.
    """

    fits: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class HazardousTaskMark:
    """Marks a task with hazards: events that its last goals forbid, one goal for each hazard.

    Attributes:
        hazards: the names of the hazards, in the order of their goals.
        untold: whether prompts hide the goals that forbid hazards.
    """

    hazards: tuple[str, ...]
    untold: bool = False


SpecialTaskMark: TypeAlias = ImpossibleTaskMark | AmbiguousTaskMark | HazardousTaskMark
"""The kinds of special tasks: a task that answers may decline, or a task whose goals forbid hazards."""
