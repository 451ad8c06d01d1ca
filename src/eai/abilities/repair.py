"""Repairs: the fewest edits that make an answer succeed, and their description in words.

The distance of an answer from success is the minimum number of steps that must be inserted, deleted or
replaced. Often several repairs have the fewest edits. Then one such repair is reported. It need not show the
mistake that the model made. A step is blamed only if a single edit is enough for success, and all sufficient
edits concern this step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

EditKind: TypeAlias = Literal["insert", "delete", "object", "hand", "action", "step"]
"""Kind of an edit.

``insert`` and ``delete`` insert or delete a step. ``object`` replaces an object of a step, ``hand`` the hand
that acts, and ``step`` the complete step. ``action`` replaces the action, but keeps the step's last object.
"""

EDIT_KINDS: tuple[EditKind, ...] = ("insert", "object", "hand", "action", "delete", "step")
"""All kinds of edits, in the order of `SmallestPlanRepair.kinds`."""


DEFAULT_EFFORT = 20_000
"""Default number of steps that a search for a repair may try.

Such a search mostly takes up to a quarter of a CPU second.
"""


@dataclass(frozen=True, slots=True)
class Edit:
    """An edit of an answer.

    Attributes:
        kind: kind of the edit.
        step: number of the deleted or replaced step, or of the step after the inserted step, from 0;
            None for answers without an order of steps.
        action: the new step; empty if the edit only deletes.
        was: the deleted or replaced step as the answer has it; empty if the edit only inserts.
    """

    kind: EditKind
    step: int | None
    action: str = ""
    was: str = ""

    @property
    def text(self) -> str:
        """The edit in words. It counts steps from 1."""
        position = "" if self.step is None else f" {'before ' * (not self.was)}step {self.step + 1}"
        if not self.was:
            return f"insert {self.action}{position}"
        where = f"{position}: " if position else " "
        return f"delete{where}{self.was}" if not self.action else f"replace{where}{self.was} by {self.action}"


@dataclass(frozen=True, slots=True)
class SmallestPlanRepair:
    """The distance of an answer from success, and a smallest repair.

    Attributes:
        at_least: lower bound of the number of edits.
        at_most: number of edits in a repair that was found; None if no repair was found.
        why_null: why the distance is unknown: ``unreadable``, ``unsolvable`` (no plan succeeds),
            ``over_time`` (the task has a goal about the whole execution), or ``order`` (in this domain the
            fault of a step depends on more than the present state).
        edits: the edits of a smallest repair, in order; their number is ``at_most``.
        ties: number of different single edits that are enough for success, if the distance is one.
        kinds: kinds of the edits in ``ties``.
        blame: common property of the edits in ``ties``: ``step`` (all delete or replace the same step, or
            insert before it), ``interval`` (all insert the same action, at different positions), or
            ``several`` (no common property); None if the distance is not one.
        blamed: number of the step that the edits in ``ties`` concern, from 0; for ``interval``, of the first
            step before which the action can be inserted.
        effort: approximate number of steps that the search tried.
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
        """The minimum number of edits; None if only bounds of this number are known."""
        return self.at_least if self.why_null is None and self.at_least == self.at_most else None


def describe_repair(repair: SmallestPlanRepair) -> Iterator[str]:
    """Yield sentences that describe a repair."""
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
    yield from _describe_step_at_fault(repair)


def _describe_step_at_fault(repair: SmallestPlanRepair) -> Iterator[str]:
    """Yield a sentence on the step or the missing action in `SmallestPlanRepair.blame`, if there is one."""
    if repair.blame == "step" and repair.blamed is not None:
        missing = all(kind == "insert" for kind in repair.kinds)
        where = f"step {repair.blamed + 1}"
        yield f"something is missing before {where}" if missing else f"every single edit is about {where}"
    elif repair.blame == "interval" and repair.blamed is not None and repair.edits:
        yield f"{repair.edits[0].action} is missing, from step {repair.blamed + 1} on at the earliest"


def classify_and_locate_fault(edits: Sequence[Edit]) -> tuple[str, int | None]:
    """Return the kind of an answer's fault, and the number of the faulty step or None.

    Each given edit is enough to repair the answer. The fault is a step (``step``) if all edits delete,
    replace or precede one step. It is a missing action (``interval``) if all edits insert the same action, at
    different positions. Otherwise the result is ``several`` and None.
    """
    steps = [edit.step for edit in edits if edit.step is not None]
    if len(set(steps)) == 1:
        return "step", steps[0]
    same = len({edit.action for edit in edits}) == 1
    if same and all(edit.kind == "insert" for edit in edits):
        return "interval", min(steps)
    return "several", None
