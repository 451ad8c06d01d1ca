"""Notations of subgoals: the form of subgoals in answers, and their meaning.

Benchmarks may replace the default.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

from eai.abilities.answer_schema import Schema, make_list_schema, make_object_schema, make_text_schema
from eai.abilities.answer_text import (
    AnswerFormat,
    JsonObject,
    consists_of_calls,
    contains_json_string,
    has_answer_line_under_key,
    read_json,
)
from eai.abilities.verdict import AnswerSpan, Unreadable
from eai.logic.formula import And, Atom, Constant, Formula
from eai.logic.ltl import map_formula_safe_names_to_original_names
from eai.logic.ltl_printer import format_ltl
from eai.planning.subgoal import GroundAtom
from eai.tasks.lexicon import FormulaNameLexicon, make_lexicon_of_declared_names
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import attempt_action
from eai.world.history import History
from eai.world.state import Fact, Scene, State, compare_states

_TOKEN = re.compile(r"[\w\-]+(?:\.\d+)?|[^\w\s]")
_NAME = re.compile(r"\w")
_WORD = re.compile(r"[\w.-]+")
_WORDS = frozenset({"and", "or", "not", "then", "until", "implies", "next", "eventually", "always"})
"""Words that are connectives or temporal operators in formulas."""

_OUTPUT = "output"
"""Key of an answer's JSON object under which the subgoals stand."""

_FORMULA_LINE = re.compile(
    rf"""\W*(?:{_OUTPUT}["']\s*:.*|(?:not\s+)?\w[\w.]*\([\w.,\s-]*\)(?:\s*(?:and|or)\b.*)?)\W*"""
)

_CALL_WITHOUT_BLANK = re.compile(r"\w\(")

_NO_FORMULA_NEIGHBOURS = frozenset({",", ".", ":", "="})
"""Characters that may stand next to the name of an object or variable, but never next to a formula.

The name of a predicate or action without arguments is read as a formula: ``ready`` means ``ready()``. But if
such a character is next to the name, the name means an object or variable.
"""


@dataclass(frozen=True, slots=True)
class WrittenSubgoals:
    """The subgoals of an answer.

    Attributes:
        subgoals: the formulas as texts, in order.
        repairs: names of the repairs that were needed to read the subgoals.
        spans: parts of the answer's text, and how each was treated.
    """

    subgoals: tuple[str, ...]
    repairs: tuple[str, ...] = ()
    spans: tuple[AnswerSpan, ...] = field(default=(), compare=False)


class SubgoalNotation:
    """Reads and writes subgoals, and knows the names that subgoals may contain.

    This default works for any declared domain. An answer is a JSON object whose key ``output`` has a list of
    formulas. Formulas use the names that the domain declares, and the names of objects in the scene or of the
    objects' classes. Characters that formulas do not allow in names become underscores.

    Args:
        domain: the domain.
    """

    def __init__(self, domain: Domain) -> None:
        self.domain = domain

    def get_domain_for_executing_subgoals(self) -> Domain:
        """Return the domain whose actions carry out the subgoals."""
        return self.domain

    def make_lexicon_of_names_in_subgoals(self, scene: Scene) -> FormulaNameLexicon:
        """Return the names that subgoals about a scene may contain."""
        return make_lexicon_of_declared_names(self.domain, scene)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """Return the subgoals in an answer, or the reason why the answer cannot be read."""
        return read_subgoals_from_json_output_list(text, self._arities)

    @cached_property
    def _arities(self) -> Mapping[str, int | None]:
        vocabulary, actions = self.domain.vocabulary, self.domain.operator_arities
        predicates = {p.name: p.arity for p in vocabulary.predicates}
        predicates |= {derived.name: derived.arity for derived in vocabulary.derived}
        return {
            word: arities[name]
            for arities in (predicates, actions)
            for word, name in map_formula_safe_names_to_original_names(arities).items()
        }

    def write(self, task: Task, plan: Iterable[Action]) -> tuple[str, ...]:
        """Return subgoals for the actions of a plan: the facts that each action makes true about its objects.

        If the notation cannot state these facts, the subgoal consists of the facts that the action makes
        false, or else of the action's name. If an action has no object except the agent, its subgoal is the
        action's name. An action gets no subgoal if it fails, or if the notation can express neither facts nor
        name.
        """
        lexicon = self.make_lexicon_of_names_in_subgoals(task.scene)
        subgoals: list[str] = []
        state = task.initial
        for action in plan:
            if action.operator not in self.domain.compiled_operators:
                continue
            after = attempt_action(self.domain, History(state), action)
            if isinstance(after, State):
                formula = self._write_subgoal_for_action(action, state, after, lexicon)
                subgoals += [] if formula is None else [format_ltl(formula)]
                state = after
        return tuple(subgoals)

    def _write_subgoal_for_action(
        self, action: Action, before: State, after: State, lexicon: FormulaNameLexicon
    ) -> Formula | None:
        """Return a subgoal for an action: facts that it changes, or the action itself.

        Return None if the notation can express neither.
        """
        about = {*action.arguments} - {before.scene.agent}
        named = lexicon.has_lexicon_name_for_action(action.operator)
        if about or not named:
            changes = compare_states(before, after)
            for facts, is_true_after in ((changes.added, True), (changes.removed, False)):
                # a relation that holds in both directions makes only one subgoal
                distinct: dict[tuple[str, frozenset[int]], Fact] = {}
                for fact in facts:
                    if not about or not about.isdisjoint(fact.arguments):
                        distinct.setdefault((fact.predicate, frozenset(fact.arguments)), fact)
                written = [
                    self._write_subgoal_for_changed_fact(fact, is_true_after, before, after, lexicon)
                    for fact in distinct.values()
                ]
                literals = tuple([literal for literal in written if literal is not None])
                if literals:
                    return literals[0] if len(literals) == 1 else And(literals)
        return lexicon.convert_action_to_formula(action) if named else None

    def _write_subgoal_for_changed_fact(
        self, fact: Fact, is_true_after: bool, before: State, after: State, lexicon: FormulaNameLexicon
    ) -> Formula | None:
        """Return the subgoal for a changed fact, or None if no predicate states it.

        The subgoal uses the fact's predicate, or else another predicate whose truth changes with the fact.
        """
        stored = self.domain.vocabulary.find_stored_predicate(fact.predicate)
        if stored is None or not stored.visible or len({*fact.arguments}) < len(fact.arguments):
            return None
        terms = tuple([Constant(before.scene.objects[i].name) for i in fact.arguments])
        for name in lexicon.find_predicates_of_arity(len(terms), put_first=fact.predicate):
            atom = Atom(name, terms)
            if (
                self.domain.holds(atom, after) is is_true_after
                and self.domain.holds(atom, before) is not is_true_after
            ):
                return lexicon.convert_literal_to_formula(GroundAtom(name, fact.arguments, is_true_after))
        return None

    def join(self, answer_parts: Iterable[str]) -> str:
        """Return the subgoals as one answer."""
        return json.dumps({"output": list(answer_parts)})

    def make_json_schema_of_answer(self) -> Schema:
        """Return the JSON schema of an answer, for providers that enforce schemas.

        The schema allows any text as a formula.
        """
        return make_object_schema({"output": make_list_schema(make_text_schema())})


def read_subgoals_from_json_output_list(
    text: str, arities: Mapping[str, int | None], keys_of_ignored_lists: Collection[str] = ()
) -> WrittenSubgoals | Unreadable:
    """Return the formulas in the list ``output`` of an answer's JSON object, or why they cannot be read.

    Empty texts in the list are ignored. Names without objects may lack their brackets. If brackets are added,
    the repair is named ``brackets``.

    Args:
        text: the answer.
        arities: mapping from the names of predicates and actions to their numbers of objects.
        keys_of_ignored_lists: other keys of the JSON object whose values may be lists.
    """
    names_without_arguments = frozenset([name for name, arity in arities.items() if arity == 0])
    form = _make_subgoal_list_answer_format(frozenset(arities), frozenset(keys_of_ignored_lists))
    reading = read_json(text, form)
    if isinstance(reading, Unreadable):
        return reading
    repairs = dict.fromkeys(reading.repairs)
    subgoals: list[str] = []
    for subgoal in filter(None, map(str.strip, reading.value)):
        spelt_out = (
            _add_missing_brackets(subgoal, names_without_arguments) if names_without_arguments else subgoal
        )
        repairs |= {} if spelt_out == subgoal else {"brackets": None}
        subgoals.append(spelt_out)
    return WrittenSubgoals(tuple(subgoals), tuple(repairs), reading.spans)


@lru_cache(16)
def _make_subgoal_list_answer_format(
    names: frozenset[str], keys_of_ignored_lists: frozenset[str]
) -> AnswerFormat[list[str]]:
    def find_flaw(value: object) -> str | None:
        if not isinstance(value, JsonObject):
            return None
        if value.repeated_key is not None:
            return f'the key "{value.repeated_key}" occurs twice'
        unknown = [
            key
            for key, part in value.members
            if isinstance(part, list | JsonObject) and key not in keys_of_ignored_lists
        ]
        unknown += [
            key
            for key, part in value.members
            if isinstance(part, str)
            and has_answer_line_under_key(
                key, part, lambda line: _is_formula_or_output_key_line(line) or consists_of_calls(line)
            )
        ]
        return next((f'the key "{key}" is not known' for key in unknown if key != _OUTPUT), None)

    def read_formula_texts(value: object) -> list[str] | None:
        if find_flaw(value) is not None or not isinstance(value, JsonObject):
            return None
        entries = dict(value.members).get(_OUTPUT)
        texts = [entry for entry in entries if isinstance(entry, str)] if isinstance(entries, list) else []
        return texts if isinstance(entries, list) and len(texts) == len(entries) else None

    wanted = f'JSON object with "{_OUTPUT}", a list of strings'
    return AnswerFormat(
        wanted,
        read_formula_texts,
        is_part=contains_json_string,
        is_answer_line=_is_formula_or_output_key_line,
        flaw=find_flaw,
        is_complete=bool,
        is_certain=lambda texts: not names.isdisjoint(_WORD.findall(" ".join(texts))),
    )


def _is_formula_or_output_key_line(line: str) -> bool:
    """Whether a line consists of formulas, or begins with the key of the subgoals."""
    return _FORMULA_LINE.fullmatch(line) is not None or (
        _CALL_WITHOUT_BLANK.search(line) is not None and consists_of_calls(line)
    )


def _add_missing_brackets(text: str, names_without_arguments: Collection[str]) -> str:
    """Return a text with brackets after names that take no objects.

    A text without a formula stays unchanged.
    """
    tokens = [match[0] for match in _TOKEN.finditer(text)]
    if "(" not in tokens and any(t not in _WORDS and t not in names_without_arguments for t in tokens):
        return text
    around = ["", "", *tokens, ""]
    for i, token in enumerate(tokens):
        before_bracket, before, after = around[i], around[i + 1], around[i + 3]
        is_argument = before == "(" and _NAME.match(before_bracket) and before_bracket not in _WORDS
        if (
            token in names_without_arguments
            and not is_argument
            and not {before, after} & _NO_FORMULA_NEIGHBOURS
        ):
            tokens[i] = token if after == "(" else f"{token}()"
    pieces = _TOKEN.split(text)
    return "".join([piece for pair in zip(pieces, [*tokens, ""], strict=True) for piece in pair])
