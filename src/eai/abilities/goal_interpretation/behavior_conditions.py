"""Conditions as a model writes them for BEHAVIOR: ``["open", "jar.n.01_1"]``, ``["not", [...]]``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from eai.abilities.task import GoalKind

STATES = frozenset({"cooked", "dusty", "frozen", "open", "sliced", "soaked", "stained", "toggled_on"})
RELATIONS = frozenset({"inside", "nextto", "onfloor", "ontop", "touching", "under"})
SYMMETRIC = frozenset({"nextto", "touching"})
"""Relations that hold both ways; only protocol `strict` knows."""

Value: TypeAlias = object
"""What stands in an answer's list: a JSON value, lists as tuples."""


@dataclass(frozen=True, slots=True)
class Written:
    """The conditions of an answer, in order, and the names of the repairs that were needed to read them."""

    conditions: tuple[Value, ...]
    repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why no conditions can be read from an answer; ``aborts`` if the reference's whole run ends there."""

    reason: str
    aborts: bool = False


@dataclass(frozen=True, slots=True)
class Seen:
    """What a condition says: the parts after ``not``, the first of which is its predicate."""

    parts: tuple[Value, ...]

    @property
    def predicate(self) -> Value:
        """What stands where the predicate belongs."""
        return self.parts[0]

    @property
    def arguments(self) -> tuple[Value, ...]:
        """The objects, if there is one or there are two."""
        return self.parts[1:] if self.is_well_formed else ()

    @property
    def is_well_formed(self) -> bool:
        """Whether there is one object, or there are two."""
        return len(self.parts) in (2, 3)

    @property
    def kind(self) -> GoalKind | None:
        """State or relation, by the predicate; None if there is no such predicate."""
        if self.predicate in STATES:
            return GoalKind.STATE
        return GoalKind.RELATION if self.predicate in RELATIONS else None


def see(condition: Value) -> Seen | None:
    """What a condition says, or None if it is nothing of the kind; a string is a list of letters here."""
    parts = _parts(condition)
    if parts[:1] == ("not",):
        parts = _parts(parts[1]) if len(parts) > 1 else ()
    return Seen(parts) if parts else None


def _parts(value: Value) -> tuple[Value, ...]:
    return tuple(value) if isinstance(value, tuple | str) else ()
