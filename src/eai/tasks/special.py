"""Special tasks: tasks that may be impossible or ambiguous, and tasks with hazards."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Impossible:
    """Marks a task that an answer may call impossible, rightly or not.

    Attributes:
        missing: the facts whose absence puts the goals out of reach; empty if there is a plan.
    """

    missing: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Ambiguous:
    """Marks an ambiguous task, about which an answer may ask a question.

    Prompts state its goals only by the instruction.

    Attributes:
        fits: the names of the objects that the instruction may mean; the meant object is first.
    """

    fits: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Hazards:
    """Marks a task with hazards: events that its last goals forbid, one goal for each hazard.

    Attributes:
        hazards: the names of the hazards.
        untold: whether prompts hide these goals.
    """

    hazards: tuple[str, ...]
    untold: bool = False


Special: TypeAlias = Impossible | Ambiguous | Hazards
"""How a task is special: it allows answers without a plan, or its goals forbid hazards."""
