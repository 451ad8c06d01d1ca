"""Explanations: what became of an answer step by step, in words, for people and for reports.

Near misses say, where a goal was not reached, what came of its objects instead. A `Statement` is an atom, an
action or a step as a value beside its text. They are made in `eai.abilities.reports`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

from eai.world.fault import FaultKind

_NOT = "not "


class Statement(NamedTuple):
    """An atom or an action: ``not open(jar_0)``, ``GRAB(soap.1002)``, ``TOUCH``.

    Attributes:
        name: of the predicate or action.
        arguments: of the objects; None where the text has no parentheses, as of actions that are goals.
        positive: whether it is asserted.
    """

    name: str
    arguments: tuple[str, ...] | None
    positive: bool = True

    @property
    def signed_name(self) -> str:
        """The name, after ``not`` where the statement is denied."""
        return self.name if self.positive else f"{_NOT}{self.name}"


def read_statement(text: str) -> Statement:
    """The atom in a text that has no value beside it, as where nothing is explained; else it is a name."""
    positive = not text.startswith(_NOT)
    name, opened, rest = (text if positive else text[len(_NOT) :]).partition("(")
    if not opened or not rest.endswith(")"):
        return Statement(text, None)
    return Statement(name, tuple([part for part in rest[:-1].split(", ") if part]), positive)


SLIP = FaultKind.SLIP.value
"""The outcome of a step that was possible and did not work."""

SLIPPED = "it was possible, but it did not work"
"""The reason of such a step."""


EXECUTED = "executed"
"""The outcome of a step that was carried out."""


@dataclass(frozen=True, slots=True)
class StepReport:
    """One step that was tried.

    Attributes:
        action: the ground action as text.
        outcome: `EXECUTED`, the kind of the fault, or ``slip``.
        reason: which check failed, in words, or that it slipped; empty if neither. Of an executed action that
            has several things to try, what it leaves undone.
        earlier: for a wrong order, after which earlier step what the action lacks held.
        added: facts that became true.
        removed: facts that became false.
        hidden_changes: how many more facts changed that can be seen, about what the task is not about.
        call: the action as a value.
    """

    action: str
    outcome: str
    reason: str = ""
    earlier: str = ""
    added: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    hidden_changes: int = 0
    call: Statement = field(compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class GoalReport:
    """A goal of the task as text, its kind, and whether it was reached.

    Attributes:
        why: of a goal over time that was not, which part of it was violated, and when.
        predicates: what it mentions, each once; of a goal of actions, these.
    """

    kind: str
    goal: str
    satisfied: bool
    why: str = ""
    predicates: tuple[str, ...] = field(default=(), compare=False)


@dataclass(frozen=True, slots=True)
class PartReport:
    """A part of the task's temporal goal; its parts are to be met one after the other.

    Attributes:
        part: the part as text.
        met_after: the number, in the list of all steps, of the one that led to the state in which it was
            first met after the part before it; 0 is the start, None that it was not met.
        missing: if it is the first that was not met, what of it never held, as texts: the whole part where
            its pieces held only apart from each other.
        met_at: of a part about an action that was met by one, the number of that step in the same list.
    """

    part: str
    met_after: int | None
    missing: tuple[str, ...] = ()
    met_at: int | None = None

    @property
    def when(self) -> str:
        """When it was met, in words; empty if it was not."""
        if self.met_at is not None:
            return f"at step {self.met_at}"
        if self.met_after is None:
            return ""
        return f"after step {self.met_after}" if self.met_after else "at the start"


@dataclass(frozen=True, slots=True)
class Explanation:
    """The explanation of what became of an answer.

    ``notes`` are sentences on the answer as a whole: why it could not be run, or how it was read. ``parts``
    are those of the task's temporal goal, if it has one. ``atoms`` are the stated and the wanted goals of an
    interpretation as values, by their texts; None of other answers.
    """

    notes: tuple[str, ...] = ()
    steps: tuple[StepReport, ...] = ()
    goals: tuple[GoalReport, ...] = ()
    parts: tuple[PartReport, ...] = ()
    atoms: Mapping[str, Statement] | None = field(default=None, compare=False)

    def statement(self, text: str) -> Statement:
        """A stated or wanted goal as a value; an entry that says nothing is a name."""
        return (self.atoms or {}).get(text, Statement(text, None))


def repair_notes(repairs: Iterable[str]) -> tuple[str, ...]:
    """A note on each repair that reading an answer took."""
    return tuple(f"read with repair: {repair}" for repair in repairs)


_NAME = re.compile(r"([^\s(),]+)\(")


def names_in(goal: str) -> tuple[str, ...]:
    """The names that a goal mentions, from its text; a goal of actions has no parentheses."""
    return tuple(dict.fromkeys(_NAME.findall(goal))) or tuple(goal.split(" or "))


_Fact: TypeAlias = tuple[str, ...]

SHOWN = 2
"""How many near misses of one goal are shown."""


def near_misses(explanation: Explanation) -> Mapping[str, tuple[str, ...]]:
    """The facts that an answer brought about instead of the goals that it misses: goal -> facts, as texts.

    A fact is a near miss if it became true and stayed so, and is another relation of the same objects in the
    same order, a state of the same object whose coming ended the one that is wanted, or the same relation of
    the first object to another one. What holds both ways between two objects says only that they are near
    each other, and is none.
    """
    missed = [goal.goal for goal in explanation.goals if not goal.satisfied]
    made, ended = _made_and_ended(explanation.steps if missed else ())
    found = {}
    for goal in missed:
        wanted = _parts(goal)
        if wanted is not None:
            near = sorted(
                (fact for fact in made if _is_near(wanted, fact, ended)),
                key=lambda fact: fact[1:] != wanted[1:],
            )
            if near:
                found[goal] = tuple(_text(fact) for fact in near[:SHOWN])
    return found


def _made_and_ended(steps: Iterable[StepReport]) -> tuple[list[_Fact], Mapping[_Fact, frozenset[_Fact]]]:
    """The facts that steps made true and left so, and for each that any made true those that it ended.

    A fact that holds both ways, and was left so, is none of the first.
    """
    made: dict[_Fact, None] = {}
    ended: dict[_Fact, frozenset[_Fact]] = {}
    for step in steps:
        removed = frozenset(filter(None, map(_parts, step.removed)))
        for fact in removed:
            made.pop(fact, None)
        for fact in filter(None, map(_parts, step.added)):
            made[fact] = None
            ended[fact] = ended.get(fact, frozenset()) | removed
    return [fact for fact in made if len(fact) != 3 or (fact[0], fact[2], fact[1]) not in made], ended


def _is_near(wanted: _Fact, fact: _Fact, ended: Mapping[_Fact, frozenset[_Fact]]) -> bool:
    same_objects = fact[1:] == wanted[1:] and fact[0] != wanted[0]
    if same_objects and len(wanted) == 2:
        return wanted in ended[fact]
    other_place = len(wanted) == len(fact) == 3 and fact[:2] == wanted[:2] and fact[2] != wanted[2]
    return same_objects or other_place


def _parts(text: str) -> tuple[str, ...] | None:
    """``INSIDE(soap.1002, cup.1003)`` as its words; None for a text of another form."""
    name, bracket, rest = text.partition("(")
    if not bracket or not rest.endswith(")") or not name.isidentifier() or "(" in rest:
        return None
    return (name, *(word.strip() for word in rest[:-1].split(",")))


def _text(fact: Iterable[str]) -> str:
    name, *arguments = fact
    return f"{name}({', '.join(arguments)})"
