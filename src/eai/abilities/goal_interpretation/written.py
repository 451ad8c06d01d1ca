"""Goals as an answer states them, before anyone knows whether the names mean something."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from eai.abilities.task import GoalKind
from eai.logic.frozen import Frozen

SECTIONS = {
    GoalKind.STATE: "node goals",
    GoalKind.RELATION: "edge goals",
    GoalKind.ACTION: "action goals",
}
"""The keys under which an answer lists its goals."""


class WrittenGoal(NamedTuple):
    """A literal, or an action that is to be taken.

    Attributes:
        predicate: the predicate or the action.
        names: the objects.
        positive: whether it is to hold or not to hold.
        is_action: whether it is an action.
    """

    predicate: str
    names: tuple[str, ...] = ()
    positive: bool = True
    is_action: bool = False

    def __str__(self) -> str:
        predicate, names, positive, is_action = self
        text = predicate if is_action and not names else f"{predicate}({', '.join(names)})"
        return text if positive else f"not {text}"


class IllFormed(NamedTuple):
    """An entry that is no goal, as text; its kind is that of its section, None if that has none."""

    kind: GoalKind | None
    text: str


@dataclass(frozen=True, slots=True)
class WrittenGoals(Frozen):
    """The goals of an answer, in order.

    Attributes:
        goals: what is stated.
        ill_formed: the entries that are no goals.
        repairs: the names of the repairs that were needed to read them.
    """

    goals: tuple[WrittenGoal, ...]
    ill_formed: tuple[IllFormed, ...] = ()
    repairs: tuple[str, ...] = ()
