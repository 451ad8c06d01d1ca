"""Goals as a model writes them in VirtualHome, before anyone knows whether the names mean something."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from eai.abilities.task import GoalKind

SECTIONS = {
    GoalKind.STATE: "node goals",
    GoalKind.RELATION: "edge goals",
    GoalKind.ACTION: "action goals",
}
"""The keys under which an answer lists its goals."""

FIELDS = {
    GoalKind.STATE: ("name", "state"),
    GoalKind.RELATION: ("from_name", "relation", "to_name"),
    GoalKind.ACTION: ("action",),
}
"""What an entry of each section must have; the description of an action says nothing that is scored."""


class StateGoal(NamedTuple):
    """An object shall be in a state."""

    name: str
    state: str


class RelationGoal(NamedTuple):
    """Two objects shall stand in a relation."""

    from_name: str
    relation: str
    to_name: str


@dataclass(frozen=True, slots=True)
class WrittenGoals:
    """The goals of an answer, in order.

    Attributes:
        states: predicted state goals.
        relations: predicted relation goals.
        actions: predicted action goals, in capitals.
        ill_formed: how many entries of each section lack one of its fields.
        repairs: the names of the repairs that were needed to read them.
    """

    states: tuple[StateGoal, ...]
    relations: tuple[RelationGoal, ...]
    actions: tuple[str, ...]
    ill_formed: Mapping[GoalKind, int]
    repairs: tuple[str, ...] = ()

    @property
    def number(self) -> int:
        """How many entries there are, ill-formed ones included."""
        return len(self.states) + len(self.relations) + len(self.actions) + sum(self.ill_formed.values())


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why no goals can be read from an answer; ``aborts`` if the reference's whole run ends there."""

    reason: str
    aborts: bool = False


Entry = Sequence[str]
"""The fields of one entry of a section."""


def written_goals(
    entries: Mapping[GoalKind, Sequence[Entry | None]], repairs: tuple[str, ...] = ()
) -> WrittenGoals:
    """Goals from the fields of their entries; None stands for an entry that is ill-formed."""
    states, relations, actions = ([e for e in entries[kind] if e is not None] for kind in GoalKind)
    return WrittenGoals(
        states=tuple([StateGoal(*fields) for fields in states]),
        relations=tuple([RelationGoal(*fields) for fields in relations]),
        actions=tuple([action.upper() for (action,) in actions]),
        ill_formed={kind: entries[kind].count(None) for kind in GoalKind},
        repairs=repairs,
    )
