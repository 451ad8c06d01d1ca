"""Notations of goals: how answers to goal interpretation state goals.

`JsonGoalNotation` is the default notation.

A `WrittenGoal` is a goal as an answer writes it, so it may contain unknown names.

Prompts ask for literals. Some answers nest conditions as JSON lists with the words of BDDL: ``["forall",
["jar", "-", "jar"], ["not", ["open", "jar"]]]``. The operands of a connective may stand in a list of their
own, and a variable may be given only by its category.
"""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.abilities.answer_schema import (
    Schema,
    make_list_schema,
    make_object_schema,
    make_text_schema,
    make_union_schema,
)
from eai.abilities.answer_text import (
    AnswerFormat,
    JsonObject,
    ParsedAnswer,
    consists_of_calls,
    contains_json_string,
    has_answer_line_under_key,
    list_nested_values,
    read_json,
)
from eai.abilities.explanation import AtomOrAction
from eai.abilities.verdict import AnswerSpan, Unreadable
from eai.logic.choice import AndOrTree, build_and_or_tree
from eai.logic.formula import Formula
from eai.logic.traversal import MAX_COUNT_DIGITS
from eai.tasks.goal_text import write_goal
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain

LiteralReader: TypeAlias = Callable[[object, frozenset[str]], f.Formula | None]
"""Function that returns the formula for an entry of an answer that has no connectives.

It takes the entry and the names of the variables that quantifiers around the entry bind. It returns None if
the entry is not a literal.
"""


def read_nested_formula(
    entry: object, literal: LiteralReader, variables: frozenset[str] = frozenset()
) -> f.Formula | None:
    """Return the formula for an entry of an answer, whose connectives and quantifiers may be nested lists.

    Return None if some part of the entry is neither such a list nor a literal.
    """

    def read_subformula(value: object, *bound_variables: f.Variable) -> f.Formula | None:
        return read_nested_formula(
            value, literal, variables | {variable.name for variable in bound_variables}
        )

    match entry:
        case ["not", [*_] as operand]:
            negated = read_subformula(operand)
            return None if negated is None else f.Not(negated)
        case ["and" | "or" as word, [*_] as first, *others]:
            parts = [read_subformula(part) for part in drop_list_around_operands((first, *others))]
            formulas = tuple([part for part in parts if part is not None])
            if len(formulas) < len(parts):
                return None
            if word == "and":
                return f.And(formulas)
            return f.Or(formulas)
        case ["imply", premise, conclusion]:
            one, other = read_subformula(premise), read_subformula(conclusion)
            return None if one is None or other is None else f.Implies(one, other)
        case ["forall" | "exists" | "forn" | "forpairs" | "fornpairs" as word, *head, body]:
            count = _read_quantifier_count(head.pop(0)) if word in ("forn", "fornpairs") and head else None
            bound = [
                variable
                for entry_variable in head
                if (variable := _read_variable(entry_variable)) is not None
            ]
            inner = read_subformula(body, *bound)
            if inner is None or len(bound) < len(head):
                return None
            return _make_quantified_formula(word, count, bound, inner)
        case _:
            return literal(entry, variables)


def drop_list_around_operands(operands: Sequence[object]) -> Sequence[object]:
    """Return the operands of a connective without the list around them, if an answer writes a list."""
    match operands:
        case [[[*_], *_] as inner]:
            return inner
        case _:
            return operands


def _make_quantified_formula(
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


def _read_variable(value: object) -> f.Variable | None:
    match value:
        case str(category):
            return f.Variable(category, category)
        case [str(name), "-", str(category)]:
            return f.Variable(name, category)
        case _:
            return None


def _read_quantifier_count(value: object) -> int | None:
    match value:
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
"""Mapping from each kind of goal to the key under which an answer lists its goals of this kind."""


_SECTION_OF = {section: section for section in SECTIONS.values()}
_NO_WORD = re.compile(r"[\W_]+")


class AnswerGoalSections(NamedTuple):
    """The sections of an answer's JSON object. Each section lists goals of one kind.

    Attributes:
        members: key and value of each member of the object, in order. A key that resembles a key in
            `SECTIONS` is replaced by this key. Members with unknown keys need not be lists of goals.
        repairs: ``section_name`` if a key was replaced.
    """

    members: tuple[tuple[str, object], ...]
    repairs: tuple[str, ...] = ()


def make_goal_sections_format(
    validate_sections: Callable[[AnswerGoalSections], AnswerGoalSections | None],
    describe_flaw: Callable[[object], str | None],
    is_name: Callable[[str], bool] = bool,
) -> AnswerFormat[AnswerGoalSections]:
    """Return the form of an answer that is a JSON object with a list of goals under each section key.

    Args:
        validate_sections: returns the given sections if goals can be read from them, else None.
        describe_flaw: returns in words why no goals can be read from a JSON value, or None.
        is_name: whether a text names a predicate or an action.
    """

    def read_sections(value: object) -> AnswerGoalSections | None:
        if not isinstance(value, JsonObject):
            return None
        members = [(_normalize_section_name(key), section) for key, section in value.members]
        if any(_is_unknown_section_with_goals(key, section) for key, section in members):
            return None
        is_respelt = any(name != key for (name, _), (key, _) in zip(members, value.members, strict=True))
        return validate_sections(AnswerGoalSections(tuple(members), ("section_name",) if is_respelt else ()))

    listed = ", ".join([f'"{key}"' for key in SECTIONS.values()])
    return AnswerFormat(
        f"JSON object with {listed}",
        read_sections,
        is_part=contains_json_string,
        is_answer_line=lambda line: _SECTION_LINE.match(line) is not None,
        flaw=describe_flaw,
        repairs_of=lambda sections_read: sections_read.repairs,
        is_certain=lambda sections_read: any(
            key in _SECTION_OF and any(map(is_name, _iterate_texts(part)))
            for key, part in sections_read.members
        ),
        is_complete=lambda sections_read: any(key in _SECTION_OF for key, _ in sections_read.members),
        are_halves=_have_no_section_in_common,
    )


_SECTION_LINE = re.compile(r"""\W*["'](?:node|edge|action)[ _-]goals["']\s*:""", re.IGNORECASE)


def _is_unknown_section_with_goals(key: str, section: object) -> bool:
    """Whether a text under an unknown key contains goals or a section's key.

    If it does, goals are missing from the sections that were read.
    """
    if not isinstance(section, str) or key in _SECTION_OF:
        return False
    return has_answer_line_under_key(
        key, section, lambda line: consists_of_calls(line) or _SECTION_LINE.match(line) is not None
    )


def _iterate_texts(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    for part in list_nested_values(value):
        yield from _iterate_texts(part)


def _have_no_section_in_common(sections: AnswerGoalSections, others: AnswerGoalSections) -> bool:
    one, other = [
        {key for key, part in each.members if isinstance(part, list)} for each in (sections, others)
    ]
    return bool(one and other) and one.isdisjoint(other)


def _normalize_section_name(section_name: str) -> str:
    """Return the key of a section of goals in the spelling of prompts; an unknown key stays unchanged."""
    return _SECTION_OF.get(_NO_WORD.sub(" ", section_name).strip().lower(), section_name)


class WrittenGoal(NamedTuple):
    """A literal or an action that an answer states as a goal.

    Attributes:
        predicate: name of the predicate or the action.
        names: names of the objects.
        positive: whether the literal must be true; False if it must be false.
        is_action: whether the goal is an action instead of a literal.
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
    def atom_or_action(self) -> AtomOrAction:
        """The goal as an `AtomOrAction`, which does not store whether the goal is an action or a literal.

        An action without objects becomes a name without parentheses.
        """
        predicate, names, positive, is_action = self
        return AtomOrAction(predicate, None if is_action and not names else names, positive)


IllFormed: TypeAlias = tuple[GoalKind | None, str]
"""An entry of an answer that is not a goal.

It is a pair: the kind of goals in its section of the answer (None if unknown), and the entry's text.
"""


@dataclass(frozen=True, slots=True)
class WrittenGoals:
    """The goals of an answer, in order.

    Attributes:
        goals: the stated goals.
        ill_formed: the entries of the answer that are not goals.
        repairs: names of the repairs that were needed to read the goals.
        spans: parts of the answer's text, and how each was treated.
    """

    goals: tuple[WrittenGoal, ...]
    ill_formed: tuple[IllFormed, ...] = ()
    repairs: tuple[str, ...] = ()
    spans: tuple[AnswerSpan, ...] = field(default=(), compare=False)

    @classmethod
    def from_entries(
        cls,
        entries: Sequence[WrittenGoal | IllFormed],
        answer: ParsedAnswer[AnswerGoalSections] | None = None,
    ) -> WrittenGoals:
        """Return the goals among the entries of an answer, and the entries that are not goals."""
        goals = tuple([entry for entry in entries if isinstance(entry, WrittenGoal)])
        ill_formed = tuple([entry for entry in entries if not isinstance(entry, WrittenGoal)])
        if answer is None:
            return cls(goals, ill_formed)
        return cls(goals, ill_formed, answer.repairs, answer.spans)


SpellingAndArity: TypeAlias = tuple[str, int]
"""A pair: a predicate as answers spell it, and its number of objects."""

GoalReader: TypeAlias = Callable[[WrittenGoal, frozenset[str]], Formula | None]
"""Function that returns the formula for a goal in an answer, or None if the goal is ill-formed.

It takes the goal and the names of the variables that quantifiers around the goal bind.
"""


StatedConditions: TypeAlias = tuple[tuple[Formula, ...], tuple[str, ...]]
"""A pair: the goals of an answer as formulas, in order, and the texts of the entries that are not goals."""


@dataclass(frozen=True, slots=True)
class GoalAlternatives:
    """One goal of a task with all ways to meet it.

    Attributes:
        kind: kind of the goal, for explanations.
        text: the goal as text, for explanations; None if explanations show the option that an answer meets
            best.
        options: alternative sets of conditions (options). Any of the sets meets the goal. Objects have their
            names in the scene.
    """

    kind: str
    text: str | None
    options: AndOrTree


class GoalNotation(ABC):
    """Reads and writes goals in the form that answers to goal interpretation use.

    Attributes:
        symmetric: predicates, as answers spell them, that hold in both directions.
        states_actions: whether answers may state actions as goals.
    """

    symmetric: ClassVar[frozenset[str]] = frozenset()
    states_actions = True

    @abstractmethod
    def read(self, text: str) -> WrittenGoals | Unreadable:
        """Return the goals of an answer, or the reason why the answer cannot be read."""

    def read_conditions(self, text: str, to_formula: GoalReader) -> StatedConditions | Unreadable:
        """Return the goals of an answer as formulas about the task, or why the answer cannot be read."""
        read = self.read(text)
        if isinstance(read, Unreadable):
            return read
        meant = [(goal, to_formula(goal, frozenset())) for goal in read.goals]
        unmeant = [str(goal) for goal, formula in meant if formula is None]
        formulas = tuple([formula for _, formula in meant if formula is not None])
        return formulas, (*unmeant, *[entry for _, entry in read.ill_formed])

    @abstractmethod
    def write(self, goals: Iterable[WrittenGoal]) -> tuple[str, ...]:
        """Return the text of each goal. `join` combines the texts to one answer."""

    @abstractmethod
    def join(self, answer_parts: Iterable[str]) -> str:
        """Return the texts of goals as one answer."""

    def map_spellings_to_predicate_names(self, domain: Domain) -> Mapping[SpellingAndArity, str]:
        """Return a mapping from the spelling of a predicate in answers to the predicate's name in the domain.

        If a predicate has several spellings, goals of tasks are written with the first of them.
        """
        vocabulary = domain.vocabulary
        stored = [
            predicate for predicate in vocabulary.predicates if predicate.visible and not predicate.static
        ]
        words = {(predicate.name, predicate.arity): predicate.name for predicate in stored}
        return words | {(predicate.name, predicate.arity): predicate.name for predicate in vocabulary.derived}

    def list_object_names(self, task: Task) -> tuple[str, ...]:
        """Return for each object in the scene the name that answers use. Several objects may share a name."""
        return tuple([scene_object.name for scene_object in task.scene.objects])

    def make_json_schema_of_answer(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """Return the JSON schema of an answer for providers that enforce schemas, or None for no schema.

        Args:
            domain: the domain of predicates and actions.
            words: words that may name objects; None if any text is allowed.
        """
        return None

    def list_alternatives_of_goals(self, task: Task) -> tuple[GoalAlternatives, ...]:
        """Return the goals of the task, each with all sets of conditions (options) that meet the goal.

        Raises:
            InputError: the sets of conditions cannot be listed (see `eai.logic.choice.build_and_or_tree`).
        """
        return tuple(
            GoalAlternatives(
                goal.kind.value,
                write_goal(goal.formula),
                build_and_or_tree(goal.formula, task.scene.names_of_category),
            )
            for goal in task.goals
        )


class JsonGoalNotation(GoalNotation):
    """A notation of goals as JSON: ``["open", "jar"]``, ``["not", ["open", "jar"]]``, or names of actions.

    The JSON object with the lists of goals may stand anywhere in the answer, also inside another object.
    Entries in the section for actions are actions. All other entries are literals.

    Args:
        sections: the kinds of goals that have their own section in the object.
        names: the names of predicates and actions; empty if any text may be such a name.
    """

    def __init__(self, sections: Iterable[GoalKind] = GoalKind, names: Collection[str] = ()) -> None:
        self._kinds = {SECTIONS[kind]: kind for kind in sections}
        self._form = make_goal_sections_format(
            _get_sections_if_all_are_lists,
            lambda value: None,
            lambda text: not names or self.normalize_word(text) in names,
        )
        self.states_actions = GoalKind.ACTION in self._kinds.values()

    def read(self, text: str) -> WrittenGoals | Unreadable:
        """Return the goals in an answer, or why the answer cannot be read."""
        reading = read_json(text, self._form)
        if isinstance(reading, Unreadable):
            return reading
        entries = self._list_goal_kinds_and_entries(reading.value)
        goals = [self._read_goal(kind, entry) or (kind, str(entry)) for kind, entry in entries]
        return WrittenGoals.from_entries(goals, reading)

    def read_entries(self, text: str) -> list[tuple[GoalKind | None, object]] | Unreadable:
        """Return a pair (kind of goal, entry) for each entry of an answer, or why the answer cannot be read.

        Pairs are sorted by kind: states, relations, actions. Entries in a section that this notation does not
        have come last, with the kind None.
        """
        reading = read_json(text, self._form)
        if isinstance(reading, Unreadable):
            return reading
        order: list[GoalKind | None] = [*GoalKind, None]
        entries = [
            (kind, self._normalize_words(entry))
            for kind, entry in self._list_goal_kinds_and_entries(reading.value)
        ]
        return sorted(entries, key=lambda entry: order.index(entry[0]))

    def _list_goal_kinds_and_entries(
        self, sections: AnswerGoalSections
    ) -> list[tuple[GoalKind | None, object]]:
        lists = [(self._kinds.get(key), part) for key, part in sections.members if isinstance(part, list)]
        return [(kind, entry) for kind, entries in lists for entry in entries]

    def read_conditions(self, text: str, to_formula: GoalReader) -> StatedConditions | Unreadable:
        """Return the goals of an answer as formulas about the task. Entries of the answer may be nested."""
        entries = self.read_entries(text)
        if isinstance(entries, Unreadable):
            return entries
        read = [(entry, self._read_condition(kind, entry, to_formula)) for kind, entry in entries]
        formulas = tuple([formula for _, formula in read if formula is not None])
        return formulas, tuple([str(entry) for entry, formula in read if formula is None])

    def write(self, goals: Iterable[WrittenGoal]) -> tuple[str, ...]:
        """Return the JSON text of each goal."""
        return tuple(json.dumps(_convert_goal_to_json_entry(goal)) for goal in goals)

    def join(self, answer_parts: Iterable[str]) -> str:
        """Return texts of goals as one answer, in sections.

        Literals are sorted by their number of objects.
        """
        sections: dict[str, list[object]] = {key: [] for key in self._kinds}
        for entry in map(json.loads, answer_parts):
            sections[SECTIONS[_get_goal_kind_of_entry(entry)]].append(entry)
        return json.dumps(sections)

    def make_json_schema_of_answer(self, domain: Domain, words: Sequence[str] | None) -> Schema:
        """Return the JSON schema of an answer: an object whose members (sections) are lists of goals.

        A literal is a list of words (the predicate and its objects), or ``not`` and such a list. An action is
        its name.
        """
        spelt = self.map_spellings_to_predicate_names(domain)

        def make_goal_schema(kind: GoalKind) -> Schema:
            if kind is GoalKind.ACTION:
                return make_text_schema(domain.operator_arities)
            said = [word for word, arity in spelt if (arity < 2) == (kind is GoalKind.STATE)]
            literal = None if words is None else [*said, *words]
            part = make_text_schema() if literal is None else make_text_schema(["not", *literal])
            return make_list_schema(make_union_schema([part, make_list_schema(make_text_schema(literal))]))

        return make_object_schema(
            {key: make_list_schema(make_goal_schema(kind)) for key, kind in self._kinds.items()}
        )

    def normalize_word(self, text: str) -> str:
        """Return a word of an answer in its normal spelling, by default unchanged."""
        return text

    def _normalize_words(self, value: object) -> object:
        """Return a JSON value with normal spelling of words, and no question marks before variables."""
        if isinstance(value, list):
            return [self._normalize_words(part) for part in value]
        return self.normalize_word(value).lstrip("?") if isinstance(value, str) else value

    def _read_condition(self, kind: GoalKind | None, entry: object, to_formula: GoalReader) -> Formula | None:
        def read_literal(value: object, variables: frozenset[str]) -> Formula | None:
            goal = self._read_goal(kind, value)
            return None if goal is None else to_formula(goal, variables)

        if kind is GoalKind.ACTION:
            return read_literal(entry, frozenset())
        return read_nested_formula(entry, read_literal)

    def _read_goal(self, kind: GoalKind | None, entry: object) -> WrittenGoal | None:
        is_action = kind is GoalKind.ACTION
        if is_action and isinstance(entry, str):
            return WrittenGoal(self.normalize_word(entry), is_action=True)
        if not isinstance(entry, list) or not entry:
            return None
        positive = is_action or not isinstance(entry[0], str) or self.normalize_word(entry[0]) != "not"
        literal = entry if positive else entry[1] if len(entry) == 2 else None
        words = self._read_predicate_and_names(literal)
        return WrittenGoal(words[0], tuple(words[1:]), positive, is_action) if words else None

    def _read_predicate_and_names(self, entry: object) -> list[str]:
        """Return the words of an entry that is a list of words; an empty list for other entries."""
        if not isinstance(entry, list):
            return []
        words = [self.normalize_word(part) for part in entry if isinstance(part, str)]
        return words if len(words) == len(entry) else []


def _get_sections_if_all_are_lists(sections: AnswerGoalSections) -> AnswerGoalSections | None:
    """Return the sections of an answer if each is a list or null, else None.

    If at least one key is a section of goals (a value of `SECTIONS`), a text or a number under an unknown key
    is allowed as a remark.
    """
    has_section = any(key in _SECTION_OF for key, _ in sections.members)
    plain = [key for key, part in sections.members if not isinstance(part, list | None)]
    are_remarks = has_section and all(key not in _SECTION_OF for key in plain)
    has_parts = any(isinstance(part, JsonObject) for _, part in sections.members)
    return sections if not has_parts and (are_remarks or not plain) else None


def _convert_goal_to_json_entry(goal: WrittenGoal) -> object:
    if goal.is_action and not goal.names:
        return goal.predicate
    literal = [goal.predicate, *goal.names]
    return literal if goal.positive else ["not", literal]


def _get_goal_kind_of_entry(entry: object) -> GoalKind:
    if not isinstance(entry, list):
        return GoalKind.ACTION
    literal = entry[1] if entry[0] == "not" else entry
    return GoalKind.STATE if len(literal) < 3 else GoalKind.RELATION
