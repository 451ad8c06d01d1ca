"""Repairs: the fewest edits of an answer that make it succeed, told as text.

The distance of an answer from success is how many steps must be inserted, deleted or replaced at least. Often
several repairs have fewest edits; the one that is told is "a smallest edit", not the mistake. A single step
is named only where every single edit is about it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

EditKind: TypeAlias = Literal["insert", "delete", "object", "hand", "action", "step"]
"""The kind of an edit. A replaced step is told by what changes in it: an object, the hand, the action (of the
same last object), or all of it; so is a replaced part of an answer that has no steps."""

KINDS: tuple[EditKind, ...] = ("insert", "object", "hand", "action", "delete", "step")
"""All kinds, that which is told first of equally small edits first."""


EFFORT = 20_000
"""The steps that are tried for a repair, where nothing else is said: a quarter of a CPU second, mostly."""


@dataclass(frozen=True, slots=True)
class Edit:
    """An edit of an answer.

    Attributes:
        kind: its kind.
        step: the step that it deletes or replaces, or before which it inserts one, from 0; None of a part
            of an answer without an order.
        action: what is put there; empty if nothing is.
        was: what is deleted or replaced, as it was written; empty if nothing is.
    """

    kind: EditKind
    step: int | None
    action: str = ""
    was: str = ""

    @property
    def text(self) -> str:
        """The edit in words, with steps counted from 1."""
        place = "" if self.step is None else f" {'before ' * (not self.was)}step {self.step + 1}"
        if not self.was:
            return f"insert {self.action}{place}"
        where = f"{place}: " if place else " "
        return f"delete{where}{self.was}" if not self.action else f"replace{where}{self.was} by {self.action}"


@dataclass(frozen=True, slots=True)
class Repair:
    """How far an answer is from one that succeeds.

    Attributes:
        at_least: it takes so many edits.
        at_most: with so many it succeeds; None where no such edits are known.
        why_null: why nothing is known of it: ``unreadable``, ``unsolvable`` (no plan succeeds), ``over_time``
            (the task has a goal over time), ``order`` (in the domain a fault of a step depends on more than
            the state).
        edits: a smallest repair of those that were found, in order; with them ``at_most`` edits.
        ties: at distance one, how many single edits make it succeed.
        kinds: the kinds of these.
        blame: what they have in common: ``step`` (all delete, replace or insert before the same step),
            ``interval`` (all insert the same step, somewhere), ``several``; None at another distance.
        blamed: the step that all are about, from 0, or the first of the interval.
        effort: about how many steps were tried to find out.
    """

    at_least: int = 0
    at_most: int | None = None
    why_null: str | None = None
    edits: tuple[Edit, ...] = ()
    ties: int | None = None
    kinds: tuple[EditKind, ...] = ()
    blame: str | None = None
    blamed: int | None = None
    effort: int = 0

    @property
    def distance(self) -> int | None:
        """The number of edits, where it is known."""
        return self.at_least if self.why_null is None and self.at_least == self.at_most else None


def repair_lines(repair: Repair) -> Iterator[str]:
    """A repair in words, a sentence a line."""
    if repair.why_null is not None:
        yield f"smallest repair: not known ({repair.why_null.replace('_', ' ')})"
        return
    if repair.at_most is None:
        yield f"smallest repair: at least {repair.at_least} edits; none is known"
        return
    number = str(repair.at_most)
    if repair.distance is None:
        number = f"at least {repair.at_least}, at most {repair.at_most}"
    others = "" if not repair.ties or repair.ties == 1 else f" ({repair.ties - 1} other single edits do, too)"
    yield f"a smallest repair found, {number} edit{'s' * (number != '1')}{others}:"
    yield from (f"  {edit.text}" for edit in repair.edits)
    yield from _blame(repair)


def _blame(repair: Repair) -> Iterator[str]:
    """The sentence that names a step, where the rule names one."""
    if repair.blame == "step" and repair.blamed is not None:
        missing = all(kind == "insert" for kind in repair.kinds)
        where = f"step {repair.blamed + 1}"
        yield f"something is missing before {where}" if missing else f"every single edit is about {where}"
    elif repair.blame == "interval" and repair.blamed is not None and repair.edits:
        yield f"{repair.edits[0].action} is missing, from step {repair.blamed + 1} on at the earliest"


def blame_of(edits: Sequence[Edit]) -> tuple[str, int | None]:
    """The common part of all single edits that suffice, and the step or the first of the steps."""
    steps = [edit.step for edit in edits if edit.step is not None]
    if len(set(steps)) == 1:
        return "step", steps[0]
    same = len({edit.action for edit in edits}) == 1
    if same and all(edit.kind == "insert" for edit in edits):
        return "interval", min(steps)
    return "several", None
