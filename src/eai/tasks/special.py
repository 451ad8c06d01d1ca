"""Special tasks: tasks that may be impossible or ambiguous, and tasks whose goals forbid some events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class PossiblyImpossibleTaskMark:
    """Marks a task that an answer may reject as impossible.

    Some tasks with a plan have this mark, too. So the mark does not reveal which tasks are impossible.

    Attributes:
        missing: the facts whose absence makes the goals unreachable; empty if a plan reaches the goals.
    """

    missing: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class AmbiguousTaskMark:
    """Marks an ambiguous task: its instruction fits several objects.

    Answers are allowed to ask for the intended object. Prompts give the instruction instead of the goals.

    Attributes:
        fits: the names of the objects that fit the instruction; the intended object comes first.
    """

    fits: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class HazardousTaskMark:
    """Marks a task with hazards: events that must not happen.

    The last goals of the task forbid the hazards, one goal for each hazard.

    Attributes:
        hazards: the names of the hazards, in the order of their goals.
        untold: whether prompts hide the goals that forbid hazards.
    """

    hazards: tuple[str, ...]
    untold: bool = False


SpecialTaskMark: TypeAlias = PossiblyImpossibleTaskMark | AmbiguousTaskMark | HazardousTaskMark
"""The mark of an impossible task, of an ambiguous task, or of a task with hazards."""
