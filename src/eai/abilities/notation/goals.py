"""How answers state goals: what is particular to a benchmark, and the form for all others.

A written goal is one as an answer states it, before anyone knows whether the names mean something.

Answers are asked for literals, but some nest conditions as JSON lists, with the words of BDDL:
``["forall", ["jar", "-", "jar"], ["not", ["open", "jar"]]]``. The parts of a connective may stand in a list
of their own, and a variable may be its category alone.
"""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.abilities.answer_schema import Schema, closed, either, listed, text
from eai.abilities.answer_text import AnswerForm, Pairs, Reading, holds_strings, read_json
from eai.abilities.explanation import Statement
from eai.abilities.verdict import Span, Unreadable
from eai.logic.choice import Choice, ground
from eai.logic.formula import Formula
from eai.logic.traversal import MAX_COUNT_DIGITS
from eai.tasks.goal_text import formula_text
from eai.tasks.task import GoalKind, Task
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


_SECTION_OF = {section: section for section in SECTIONS.values()}
_NO_WORD = re.compile(r"[\W_]+")


class Sections(NamedTuple):
    """The sections of goals in an object.

    Attributes:
        members: key and entries of each section, in order; a key of `SECTIONS` is spelt as there.
        repairs: ``section_name`` if a key was spelt otherwise.
    """

    members: tuple[tuple[str, object], ...]
    repairs: tuple[str, ...] = ()


def sections_form(
    read: Callable[[Sections], Sections | None], flaw: Callable[[object], str | None]
) -> AnswerForm[Sections]:
    """Return the form of an object that states goals in sections.

    Args:
        read: returns the sections if they are such goals, else None.
        flaw: returns why a value is no such object, or None.
    """

    def sections(value: object) -> Sections | None:
        if not isinstance(value, Pairs):
            return None
        members = [(_section_name(key), section) for key, section in value.members]
        is_respelt = any(name != key for (name, _), (key, _) in zip(members, value.members, strict=True))
        return read(Sections(tuple(members), ("section_name",) if is_respelt else ()))

    listed = ", ".join([f'"{key}"' for key in SECTIONS.values()])
    return AnswerForm(
        f"JSON object with {listed}",
        sections,
        is_part=holds_strings,
        is_line_of_answer=lambda line: _SECTION_LINE.match(line) is not None,
        flaw=flaw,
        repairs_of=lambda found: found.repairs,
        is_certain=lambda found: any(key in _SECTION_OF for key, _ in found.members),
    )


_SECTION_LINE = re.compile(r"""\W*["'](?:node|edge|action)[ _-]goals["']\s*:""", re.IGNORECASE)


def _section_name(key: str) -> str:
    """Return the name of a section as prompts spell it, or the key as it is."""
    return _SECTION_OF.get(_NO_WORD.sub(" ", key).strip().lower(), key)


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
        goals: the goals that are stated.
        ill_formed: the entries that are no goals.
        repairs: names of the repairs that reading them took.
        spans: what became of the parts of the text.
    """

    goals: tuple[WrittenGoal, ...]
    ill_formed: tuple[IllFormed, ...] = ()
    repairs: tuple[str, ...] = ()
    spans: tuple[Span, ...] = field(default=(), compare=False)

    @classmethod
    def of(
        cls, entries: Sequence[WrittenGoal | IllFormed], reading: Reading[Sections] | None = None
    ) -> WrittenGoals:
        """Return the goals among the entries of an answer, and the entries that are no goals."""
        goals = tuple([entry for entry in entries if isinstance(entry, WrittenGoal)])
        ill_formed = tuple([entry for entry in entries if not isinstance(entry, WrittenGoal)])
        if reading is None:
            return cls(goals, ill_formed)
        return cls(goals, ill_formed, reading.repairs, reading.spans)


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
            Alternatives(
                goal.kind.value,
                formula_text(goal.formula),
                ground(goal.formula, task.scene.names_of_category),
            )
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
        reading = read_json(text, _LISTS)
        if isinstance(reading, Unreadable):
            return reading
        entries = self._entries(reading.value)
        goals = [self._goal(kind, entry) or (kind, str(entry)) for kind, entry in entries]
        return WrittenGoals.of(goals, reading)

    def entries(self, text: str) -> list[tuple[GoalKind | None, object]] | Unreadable:
        """Return all entries of an answer with their kinds, states first, or why it cannot be read."""
        reading = read_json(text, _LISTS)
        if isinstance(reading, Unreadable):
            return reading
        order: list[GoalKind | None] = [*GoalKind, None]
        entries = [(kind, self._spelt(entry)) for kind, entry in self._entries(reading.value)]
        return sorted(entries, key=lambda entry: order.index(entry[0]))

    def _entries(self, sections: Sections) -> list[tuple[GoalKind | None, object]]:
        lists = [(self._kinds.get(key), part) for key, part in sections.members if isinstance(part, list)]
        return [(kind, entry) for kind, entries in lists for entry in entries]

    def conditions(self, text: str, meaning: Meaning) -> Conditions | Unreadable:
        """The goals of an answer as conditions on its task; they may be nested (`nested`)."""
        entries = self.entries(text)
        if isinstance(entries, Unreadable):
            return entries
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


def _lists(sections: Sections) -> Sections | None:
    """Return sections that are lists; beside one of `SECTIONS` another member may be a plain remark."""
    has_section = any(key in _SECTION_OF for key, _ in sections.members)
    plain = [key for key, part in sections.members if not isinstance(part, list | None)]
    are_remarks = has_section and all(key not in _SECTION_OF for key in plain)
    has_parts = any(isinstance(part, Pairs) for _, part in sections.members)
    return sections if not has_parts and (are_remarks or not plain) else None


_LISTS = sections_form(_lists, lambda value: None)


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
