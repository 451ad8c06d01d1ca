"""How answers state goals: what is particular to a benchmark, and the form for all others.

A written goal is one as an answer states it, before anyone knows whether the names mean something.

Answers are asked for literals, but some nest conditions as JSON lists, with the words of BDDL:
``["forall", ["jar", "-", "jar"], ["not", ["open", "jar"]]]``. The parts of a connective may stand in a list
of their own, and a variable may be its category alone.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.abilities.answer_schema import Schema, closed, either, listed, text
from eai.abilities.explanation import Statement
from eai.abilities.json_text import Pairs, find_json
from eai.abilities.reports import formula_text
from eai.abilities.task import GoalKind, Task
from eai.abilities.verdict import Unreadable
from eai.logic.choice import Choice, ground
from eai.logic.formula import Formula
from eai.logic.traversal import MAX_COUNT_DIGITS
from eai.world.domain import Domain

Literal: TypeAlias = Callable[[object, frozenset[str]], f.Formula | None]
"""The meaning of an entry without connectives below quantifiers of variables; None if it is no literal."""


def read_nested(entry: object, literal: Literal, variables: frozenset[str] = frozenset()) -> f.Formula | None:
    """The meaning of an entry; None if it, or a part of it, is no condition."""

    def read(part: object, *bound: f.Variable) -> f.Formula | None:
        return read_nested(part, literal, variables | {variable.name for variable in bound})

    match entry:
        case ["not", [*_] as operand]:
            negated = read(operand)
            return None if negated is None else f.Not(negated)
        case ["and" | "or" as word, [*_] as first, *others]:
            parts = [read(part) for part in parts_of((first, *others))]
            known = tuple([part for part in parts if part is not None])
            return None if len(known) < len(parts) else f.And(known) if word == "and" else f.Or(known)
        case ["imply", premise, conclusion]:
            one, other = read(premise), read(conclusion)
            return None if one is None or other is None else f.Implies(one, other)
        case ["forall" | "exists" | "forn" | "forpairs" | "fornpairs" as word, *head, body]:
            count = _count(head.pop(0)) if word in ("forn", "fornpairs") and head else None
            bound = [variable for each in head if (variable := _variable(each)) is not None]
            inner = read(body, *bound)
            return None if inner is None or len(bound) < len(head) else _quantified(word, count, bound, inner)
        case _:
            return literal(entry, variables)


def parts_of(parts: Sequence[object]) -> Sequence[object]:
    """The parts of a connective, which may stand in a list of their own."""
    match parts:
        case [[[*_], *_] as inner]:
            return inner
        case _:
            return parts


def _quantified(
    word: str, count: int | None, variables: Sequence[f.Variable], body: f.Formula
) -> f.Formula | None:
    match word, count, variables:
        case "forall", None, [variable]:
            return f.ForAll(variable, body)
        case "exists", None, [variable]:
            return f.Exists(variable, body)
        case "forn", int(number), [variable]:
            return f.Exactly(number, variable, body)
        case "forpairs", None, [first, second]:
            return f.ForPairs(first, second, body)
        case "fornpairs", int(number), [first, second]:
            return f.ForPairs(first, second, body, number)
        case _:
            return None


def _variable(part: object) -> f.Variable | None:
    match part:
        case str(category):
            return f.Variable(category, category)
        case [str(name), "-", str(category)]:
            return f.Variable(name, category)
        case _:
            return None


def _count(part: object) -> int | None:
    match part:
        case bool():
            return None
        case int(number) | [int(number)] if 0 <= number < 10**MAX_COUNT_DIGITS:
            return number
        case str(digits) | [str(digits)] if digits.isdecimal() and len(digits) <= MAX_COUNT_DIGITS:
            return int(digits)
        case _:
            return None


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

    @property
    def statement(self) -> Statement:
        """The same without the kind of goal; an action without objects has no place for any."""
        predicate, names, positive, is_action = self
        return Statement(predicate, None if is_action and not names else names, positive)


IllFormed: TypeAlias = tuple[GoalKind | None, str]
"""An entry that is no goal, as text, after the kind of its section, which is None if that has none."""


@dataclass(frozen=True, slots=True)
class WrittenGoals:
    """The goals of an answer, in order.

    Attributes:
        goals: what is stated.
        ill_formed: the entries that are no goals.
        repairs: the names of the repairs that were needed to read them.
    """

    goals: tuple[WrittenGoal, ...]
    ill_formed: tuple[IllFormed, ...] = ()
    repairs: tuple[str, ...] = ()

    @classmethod
    def of(cls, entries: Sequence[WrittenGoal | IllFormed], repairs: tuple[str, ...] = ()) -> WrittenGoals:
        """The goals among entries, and those that are none."""
        goals = tuple([each for each in entries if isinstance(each, WrittenGoal)])
        return cls(goals, tuple([each for each in entries if not isinstance(each, WrittenGoal)]), repairs)


Word: TypeAlias = tuple[str, int]
"""A predicate as answers spell it, and of how many objects it is said."""

Meaning: TypeAlias = Callable[[WrittenGoal, frozenset[str]], Formula | None]
"""The meaning of a goal below quantifiers that bind variables of these names; None if it is ill-formed."""


Conditions: TypeAlias = tuple[tuple[Formula, ...], tuple[str, ...]]
"""The goals of an answer as formulas, in order, and as texts the entries that are none."""


@dataclass(frozen=True, slots=True)
class Alternatives:
    """One goal of a task with all ways to meet it.

    Attributes:
        kind: the kind of goal, for explanations.
        text: the goal, for explanations; None for the option that an answer is compared with.
        options: conditions on the objects of the scene, by their names there.
    """

    kind: str
    text: str | None
    options: Choice


class GoalNotation(ABC):
    """How answers to goal interpretation state goals.

    Attributes:
        symmetric: the predicates, as spelt, that hold both ways.
        states_actions: whether answers may state actions as goals.
    """

    symmetric: ClassVar[frozenset[str]] = frozenset()
    states_actions = True

    @abstractmethod
    def read(self, text: str) -> WrittenGoals | Unreadable:
        """The goals of an answer, or why there are none."""

    def conditions(self, text: str, meaning: Meaning) -> Conditions | Unreadable:
        """The goals of an answer as conditions on its task, or why there are none."""
        read = self.read(text)
        if isinstance(read, Unreadable):
            return read
        meant = [(goal, meaning(goal, frozenset())) for goal in read.goals]
        unmeant = [str(goal) for goal, formula in meant if formula is None]
        formulas = tuple([formula for _, formula in meant if formula is not None])
        return formulas, (*unmeant, *[entry for _, entry in read.ill_formed])

    @abstractmethod
    def write(self, goals: Iterable[WrittenGoal]) -> tuple[str, ...]:
        """Each goal as a part of an answer."""

    @abstractmethod
    def join(self, parts: Iterable[str]) -> str:
        """The parts as one answer."""

    def words(self, domain: Domain) -> Mapping[Word, str]:
        """The predicates that goals may speak of: as spelt, and as the vocabulary names them.

        Of two spellings of a predicate the first is that of its goals.
        """
        vocabulary = domain.vocabulary
        stored = [each for each in vocabulary.predicates if each.visible and not each.static]
        words = {(each.name, each.arity): each.name for each in stored}
        return words | {(each.name, each.arity): each.name for each in vocabulary.derived}

    def names(self, task: Task) -> tuple[str, ...]:
        """The name of each object of the scene; several may share one."""
        return tuple([thing.name for thing in task.scene.objects])

    def schema(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """The form of an answer, for providers that can enforce one; None if it is not known.

        Args:
            domain: the predicates and the actions.
            words: what objects may be called; None if any text will do.
        """
        return None

    def alternatives(self, task: Task) -> tuple[Alternatives, ...]:
        """The goals that an answer is compared with: those of the task.

        Raises:
            InputError: a goal leaves no finite choice of conditions (see `choice.ground`).
        """
        return tuple(
            Alternatives(goal.kind.value, formula_text(goal.formula), ground(goal.formula, task.scene.named))
            for goal in task.goals
        )


class JsonGoals(GoalNotation):
    """An object of lists of ``["open", "jar"]``, ``["not", ["open", "jar"]]`` or names of actions.

    It is found anywhere in the text; an object around it does not matter. What stands in the section of
    actions is an action, and what stands in any other one is a literal.

    Args:
        sections: the sections that are written.
    """

    def __init__(self, sections: Iterable[GoalKind] = GoalKind) -> None:
        self._kinds = {SECTIONS[kind]: kind for kind in sections}
        self.states_actions = GoalKind.ACTION in self._kinds.values()

    def read(self, text: str) -> WrittenGoals | Unreadable:
        """The goals in an answer, or why there are none."""
        found = find_json(text, _sections)
        if found is None:
            return _NO_LISTS
        sections, repairs = found
        entries = [(self._kinds.get(key), entry) for key, entries in sections for entry in entries]
        read = [self._goal(kind, entry) or (kind, str(entry)) for kind, entry in entries]
        return WrittenGoals.of(read, repairs)

    def entries(self, text: str) -> list[tuple[GoalKind | None, object]] | None:
        """All entries of an answer with their kinds, states first; None if it cannot be read."""
        found = find_json(text, _sections)
        if found is None:
            return None
        order: list[GoalKind | None] = [*GoalKind, None]
        read = [(self._kinds.get(key), self._spelt(entry)) for key, entries in found[0] for entry in entries]
        return sorted(read, key=lambda entry: order.index(entry[0]))

    def conditions(self, text: str, meaning: Meaning) -> Conditions | Unreadable:
        """The goals of an answer as conditions on its task; they may be nested (`nested`)."""
        entries = self.entries(text)
        if entries is None:
            return _NO_LISTS
        read = [(entry, self._condition(kind, entry, meaning)) for kind, entry in entries]
        formulas = tuple([formula for _, formula in read if formula is not None])
        return formulas, tuple([str(entry) for entry, formula in read if formula is None])

    def write(self, goals: Iterable[WrittenGoal]) -> tuple[str, ...]:
        """Each goal as JSON."""
        return tuple(json.dumps(_entry(goal)) for goal in goals)

    def join(self, parts: Iterable[str]) -> str:
        """The goals in their sections: actions by themselves, literals by their number of objects."""
        sections: dict[str, list[object]] = {key: [] for key in self._kinds}
        for entry in map(json.loads, parts):
            sections[SECTIONS[_section(entry)]].append(entry)
        return json.dumps(sections)

    def schema(self, domain: Domain, words: Sequence[str] | None) -> Schema:
        """Literals as lists of words, and names of actions."""
        spelt = self.words(domain)

        def entry(kind: GoalKind) -> Schema:
            if kind is GoalKind.ACTION:
                return text(domain.arities)
            said = [word for word, arity in spelt if (arity < 2) == (kind is GoalKind.STATE)]
            literal = None if words is None else [*said, *words]
            part = text() if literal is None else text(["not", *literal])
            return listed(either([part, listed(text(literal))]))

        return closed({key: listed(entry(kind)) for key, kind in self._kinds.items()})

    def word(self, text: str) -> str:
        """A word of an answer as all spellings of it come out."""
        return text

    def _spelt(self, value: object) -> object:
        """A value with its words as all spellings of them come out; a variable may have a question mark."""
        if isinstance(value, list):
            return [self._spelt(part) for part in value]
        return self.word(value).lstrip("?") if isinstance(value, str) else value

    def _condition(self, kind: GoalKind | None, entry: object, meaning: Meaning) -> Formula | None:
        """The condition that an entry asks for, or None if it is no condition."""

        def literal(part: object, variables: frozenset[str]) -> Formula | None:
            goal = self._goal(kind, part)
            return None if goal is None else meaning(goal, variables)

        return literal(entry, frozenset()) if kind is GoalKind.ACTION else read_nested(entry, literal)

    def _goal(self, kind: GoalKind | None, entry: object) -> WrittenGoal | None:
        """The goal that an entry states, or None if it is ill-formed."""
        is_action = kind is GoalKind.ACTION
        if is_action and isinstance(entry, str):
            return WrittenGoal(self.word(entry), is_action=True)
        if not isinstance(entry, list) or not entry:
            return None
        positive = is_action or not isinstance(entry[0], str) or self.word(entry[0]) != "not"
        literal = entry if positive else entry[1] if len(entry) == 2 else None
        words = self._words(literal)
        return WrittenGoal(words[0], tuple(words[1:]), positive, is_action) if words else None

    def _words(self, entry: object) -> list[str]:
        """The words of a list; none if it is no list, or not one of words alone."""
        if not isinstance(entry, list):
            return []
        words = [self.word(part) for part in entry if isinstance(part, str)]
        return words if len(words) == len(entry) else []


_NO_LISTS = Unreadable("there is no JSON object of lists of conditions")


def _sections(value: object) -> list[tuple[str, list[object]]] | None:
    """The members of an object whose members are lists or null, or of the one member that is one."""
    if not isinstance(value, Pairs):
        return None
    if len(value.members) == 1 and isinstance(value.members[0][1], Pairs):
        return _sections(value.members[0][1])
    sections = [(key, section) for key, section in value.members if section is not None]
    lists = [(key, section) for key, section in sections if isinstance(section, list)]
    return lists if len(lists) == len(sections) else None


def _entry(goal: WrittenGoal) -> object:
    if goal.is_action and not goal.names:
        return goal.predicate
    literal = [goal.predicate, *goal.names]
    return literal if goal.positive else ["not", literal]


def _section(entry: object) -> GoalKind:
    if not isinstance(entry, list):
        return GoalKind.ACTION
    literal = entry[1] if entry[0] == "not" else entry
    return GoalKind.STATE if len(literal) < 3 else GoalKind.RELATION
