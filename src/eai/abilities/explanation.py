"""Explanations: why an answer has its verdict, step by step and in words, for people and for reports.

An `AtomOrAction` splits the text of an atom, an action or a step into its name and its arguments.
`map_missed_goals_to_similar_facts` finds the facts that an answer made true instead of a missed goal.
`eai.abilities.reports` makes explanations.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

from eai.world.fault import FaultKind

_NOT = "not "


class AtomOrAction(NamedTuple):
    """The name and the arguments of an atom or an action, such as ``not open(jar_0)`` or ``GRAB(soap.1002)``.

    Attributes:
        name: name of the predicate or action.
        arguments: names of the objects; None if the text has no parentheses, as in goals that are actions.
        positive: whether the atom is asserted; False if it is negated.
    """

    name: str
    arguments: tuple[str, ...] | None
    positive: bool = True

    @property
    def name_with_negation(self) -> str:
        """The name, with ``not`` before it if the statement is negated."""
        return self.name if self.positive else f"{_NOT}{self.name}"


def parse_statement(text: str) -> AtomOrAction:
    """Return the `AtomOrAction` in the text of an atom.

    A text of another form becomes a name without arguments.
    """
    positive = not text.startswith(_NOT)
    name, opened, rest = (text if positive else text[len(_NOT) :]).partition("(")
    if not opened or not rest.endswith(")"):
        return AtomOrAction(text, None)
    return AtomOrAction(name, tuple([part for part in rest[:-1].split(", ") if part]), positive)


SLIP = FaultKind.SLIP.value
"""Outcome of a step that was possible, but had no effect because it slipped."""

SLIPPED = "it was possible, but it did not work"
"""Reason, in words, why a step that slipped (failed by chance, although it was possible) had no effect."""


EXECUTED = "executed"
"""Outcome of a step that was executed."""


@dataclass(frozen=True, slots=True)
class StepReport:
    """The report on one step that was tried.

    Attributes:
        action: the action on its objects, as text.
        outcome: `EXECUTED`, ``slip`` (the step was possible, but had no effect), or the kind of the fault.
        reason: in words, why the step failed or slipped, or why some of its alternatives failed, although it
            was executed (`eai.world.operator.OperatorAlternative`); otherwise empty.
        earlier: for steps in the wrong order, the earlier step after which the missing condition held.
        added: facts that became true.
        removed: facts that became false.
        hidden_changes: number of changed facts that prompts may mention, but that are not in ``added`` or
            ``removed``. For example, facts about objects that do not matter to the task.
        call: the action as an `AtomOrAction`.
    """

    action: str
    outcome: str
    reason: str = ""
    earlier: str = ""
    added: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    hidden_changes: int = 0
    call: AtomOrAction = field(compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class GoalReport:
    """The report on one goal of the task.

    Attributes:
        kind: kind of the goal.
        goal: the goal as text.
        satisfied: whether the goal was reached.
        why: for a missed goal over time, the violated formula in it and when it was violated.
        predicates: names of the predicates in the goal, each once; names of actions, if the goal is about
            actions.
    """

    kind: str
    goal: str
    satisfied: bool
    why: str = ""
    predicates: tuple[str, ...] = field(default=(), compare=False)


@dataclass(frozen=True, slots=True)
class GoalPartReport:
    """The report on one part of the task's temporal goal. The parts must be met one after the other.

    Attributes:
        part: the part as text.
        met_after: number, among all steps, of the step after which the part was first met; 0 for the start,
            None if the part was not met. A part cannot be met before the previous part.
        missing: for the first unmet part, its formulas that never held. If each formula held at some time,
            but never all together, the only item is the complete part.
        met_at: for a part about an action, the number, among all steps, of the action that met the part;
            None for all other parts and for unmet parts.
    """

    part: str
    met_after: int | None
    missing: tuple[str, ...] = ()
    met_at: int | None = None

    @property
    def first_met_time_text(self) -> str:
        """The time at which this part of the goal was first met, in words; empty if it was not met."""
        if self.met_at is not None:
            return f"at step {self.met_at}"
        if self.met_after is None:
            return ""
        return f"after step {self.met_after}" if self.met_after else "at the start"


@dataclass(frozen=True, slots=True)
class VerdictExplanation:
    """The explanation of an answer's verdict.

    Attributes:
        notes: sentences on the complete answer: why it could not be executed, or how it was read.
        steps: reports on the steps.
        goals: reports on the goals.
        parts: reports on the parts of the task's temporal goal, if the task has such a goal.
        atoms: for goal interpretations, a mapping from the texts of stated goals and of the task's goals to
            `AtomOrAction` values; None for other answers.
    """

    notes: tuple[str, ...] = ()
    steps: tuple[StepReport, ...] = ()
    goals: tuple[GoalReport, ...] = ()
    parts: tuple[GoalPartReport, ...] = ()
    atoms: Mapping[str, AtomOrAction] | None = field(default=None, compare=False)

    def get_atom_or_action(self, text: str) -> AtomOrAction:
        """Return the `AtomOrAction` of a goal's text.

        A text that is not in `atoms` becomes a name without arguments.
        """
        return (self.atoms or {}).get(text, AtomOrAction(text, None))


def write_repair_notes(repairs: Iterable[str]) -> tuple[str, ...]:
    """Return a sentence on each repair that was needed to read the answer's text."""
    return tuple(f"read with repair: {repair}" for repair in repairs)


_NAME = re.compile(r"([^\s(),]+)\(")


def find_predicate_names(goal: str) -> tuple[str, ...]:
    """Return the names of the predicates or the actions in a goal's text, each once."""
    return tuple(dict.fromkeys(_NAME.findall(goal))) or tuple(goal.split(" or "))


_FactWords: TypeAlias = tuple[str, ...]

MAX_NEAR_MISSES = 2
"""Maximum number of near misses (facts that an answer reached instead) for one goal."""


def map_missed_goals_to_similar_facts(explanation: VerdictExplanation) -> Mapping[str, tuple[str, ...]]:
    """Return a mapping from missed goals to their near misses: facts that the answer reached instead.

    Goals and facts are texts. A near miss became true and stayed true. It is one of three kinds of facts:
    another relation of the same objects in the same order; a state that replaced the wanted state of the same
    object; or the wanted relation of the first object to another object. A relation that holds in both
    directions is not a near miss: it only means that two objects are close.
    """
    missed = [goal.goal for goal in explanation.goals if not goal.satisfied]
    made, replaced = _find_lasting_and_replaced_facts(explanation.steps if missed else ())
    near_misses = {}
    for goal in missed:
        wanted = _split_fact(goal)
        if wanted is not None:
            near = sorted(
                (fact for fact in made if _is_near_miss_of_wanted_fact(wanted, fact, replaced)),
                key=lambda fact: fact[1:] != wanted[1:],
            )
            if near:
                near_misses[goal] = tuple(_write_fact(fact) for fact in near[:MAX_NEAR_MISSES])
    return near_misses


def _find_lasting_and_replaced_facts(
    steps: Iterable[StepReport],
) -> tuple[list[_FactWords], Mapping[_FactWords, frozenset[_FactWords]]]:
    """Return the facts that became true and stayed true, and a mapping from facts to the facts they replaced.

    A fact replaces all facts that become false in the step that makes the fact true. The first result leaves
    out relations that hold in both directions at the end.
    """
    made: dict[_FactWords, None] = {}
    replaced: dict[_FactWords, frozenset[_FactWords]] = {}
    for step in steps:
        removed = frozenset(filter(None, map(_split_fact, step.removed)))
        for fact in removed:
            made.pop(fact, None)
        for fact in filter(None, map(_split_fact, step.added)):
            made[fact] = None
            replaced[fact] = replaced.get(fact, frozenset()) | removed
    return [fact for fact in made if len(fact) != 3 or (fact[0], fact[2], fact[1]) not in made], replaced


def _is_near_miss_of_wanted_fact(
    wanted: _FactWords, fact: _FactWords, facts_replaced_by: Mapping[_FactWords, frozenset[_FactWords]]
) -> bool:
    same_objects = fact[1:] == wanted[1:] and fact[0] != wanted[0]
    if same_objects and len(wanted) == 2:
        return wanted in facts_replaced_by[fact]
    other_place = len(wanted) == len(fact) == 3 and fact[:2] == wanted[:2] and fact[2] != wanted[2]
    return same_objects or other_place


def _split_fact(text: str) -> tuple[str, ...] | None:
    """Return the predicate and the objects of a fact such as ``INSIDE(soap.1002, cup.1003)``.

    Return None if the text has another form.
    """
    name, bracket, rest = text.partition("(")
    if not bracket or not rest.endswith(")") or not name.isidentifier() or "(" in rest:
        return None
    return (name, *(word.strip() for word in rest[:-1].split(",")))


def _write_fact(fact: Iterable[str]) -> str:
    name, *arguments = fact
    return f"{name}({', '.join(arguments)})"
