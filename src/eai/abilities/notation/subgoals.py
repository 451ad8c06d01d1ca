"""How subgoals are read, written and meant: what a benchmark may say of itself, and a default."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import eai.logic.formula as f
from eai.abilities.answer_schema import Schema, closed, listed, text
from eai.abilities.answer_text import AnswerForm, Pairs, holds_strings, read_json
from eai.abilities.task import Task
from eai.abilities.verdict import Span, Unreadable
from eai.errors import InputError
from eai.logic.formula import And, Atom, Constant, Formula
from eai.logic.ltl import spelt
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rewrite
from eai.logic.signature import Signature
from eai.logic.traversal import objects, predicates_of
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.derived import is_a
from eai.world.domain import Domain
from eai.world.execution import attempt
from eai.world.history import Past
from eai.world.state import Fact, Scene, State, change


@dataclass(frozen=True)
class SubgoalLexicon:
    """The words of subgoals about one scene.

    Attributes:
        scene: the scene.
        signature: the names that are allowed: predicates, actions, and objects, perhaps also by class.
        objects: the objects by the names that they go by; of several names of one the last is written.
        predicates: for predicates that the domain calls otherwise, its name of them.
        actions: likewise.
        categories: for predicates that say what kind of thing an object is, the category.
        unobserved: predicates of which the domain knows nothing. Literals with them are taken to hold.
        unobserved_objects: names of objects whose states the domain does not know. Literals about them are
            taken to hold.
    """

    scene: Scene
    signature: Signature
    objects: Mapping[str, int]
    predicates: Mapping[str, str] = field(default_factory=dict)
    actions: Mapping[str, str] = field(default_factory=dict)
    categories: Mapping[str, str] = field(default_factory=dict)
    unobserved: Collection[str] = frozenset()
    unobserved_objects: Collection[str] = frozenset()

    @cached_property
    def _names(self) -> Mapping[int, str]:
        return {index: name for name, index in self.objects.items()}

    @cached_property
    def _predicate_words(self) -> Mapping[str, str]:
        return {name: word for word, name in self.predicates.items()}

    @cached_property
    def _action_words(self) -> Mapping[str, str]:
        return {name: word for word, name in self.actions.items()}

    def name(self, index: int) -> str:
        """The name of an object."""
        return self._names[index]

    def write_literal(self, literal: GroundAtom) -> f.Formula:
        """A literal as subgoals say it."""
        name = literal.predicate
        spoken = name in self.signature.predicates and name not in self.predicates
        word = name if spoken else self._predicate_words.get(name, name)
        atom = f.Atom(word, self._terms(literal.arguments))
        return atom if literal.truth else f.Not(atom)

    def write_action(self, action: Action) -> f.Occurs:
        """An action as subgoals say it."""
        return f.Occurs(
            self._action_words.get(action.operator, action.operator), self._terms(action.arguments)
        )

    def names_action(self, operator: str) -> bool:
        """Whether subgoals can name an action of the domain."""
        return self._action_words.get(operator, operator) in self.signature.actions

    def predicates_of(self, arity: int, first: str) -> Iterator[str]:
        """The predicates of the domain that subgoals can say of so many objects; one is tried first."""
        words = [w for w, n in self.signature.predicates.items() if n == arity and w not in self.unobserved]
        names = dict.fromkeys([self.predicates.get(w, w) for w in words if w not in self.categories])
        yield from (first,) if first in names else ()
        yield from (name for name in names if name != first)

    def literal(self, formula: f.Formula) -> GroundAtom | None:
        """The condition that an atom or a negated one means; None if the domain cannot say it of objects."""
        atom, truth = (formula.operand, False) if isinstance(formula, f.Not) else (formula, True)
        if not isinstance(atom, f.Atom) or atom.predicate in self.unobserved:
            return None
        arguments = self._indices(atom.arguments)
        if arguments is None or atom.predicate in self.categories:
            return None
        return GroundAtom(self.predicates.get(atom.predicate, atom.predicate), arguments, truth)

    def action(self, formula: f.Occurs) -> Action:
        """The action that a subgoal asks for.

        Raises:
            InputError: an argument is no object.
        """
        arguments = self._indices(formula.arguments)
        if arguments is None:
            raise InputError(f"{formula.action}: an argument is no object")
        return Action(self.actions.get(formula.action, formula.action), arguments)

    def is_class(self, name: str) -> bool:
        """Whether a name stands for any object of a class."""
        return name not in self.objects and name not in self.unobserved_objects

    def is_unobserved(self, formula: f.Formula) -> bool:
        """Whether a formula has a predicate or an object of which the domain knows nothing."""
        names = objects(formula) if self.unobserved_objects else ()
        return any(name in self.unobserved for name in predicates_of(formula)) or any(
            name in self.unobserved_objects for name in names
        )

    def meaning(self, formula: f.Formula) -> f.Formula:
        """A formula of subgoals in the words of the domain, with the names that objects have in the scene.

        Raises:
            InputError: it has a temporal operator other than ``then``.
        """

        def meant(leaf: f.Leaf, bound: frozenset[str]) -> f.Formula:
            if isinstance(leaf, f.Atom) and leaf.predicate in self.categories:
                return is_a(self._meant(leaf.arguments[0]), self.categories[leaf.predicate])
            return _renamed(leaf, self.predicates, self.actions, self._meant)

        return rewrite(formula, meant)

    def worded(self, formula: f.Formula) -> f.Formula:
        """A formula of the domain in the words of subgoals: what `meaning` makes it of.

        Raises:
            InputError: it has a temporal operator other than ``then``.
        """

        def worded(leaf: f.Leaf, bound: frozenset[str]) -> f.Formula:
            return _renamed(leaf, self._predicate_words, self._action_words, self._word)

        return rewrite(formula, worded)

    def _word(self, term: f.Term) -> f.Term:
        """A term of the domain with the name that subgoals have for it."""
        index = self.scene.index.get(term.name) if isinstance(term, f.Constant) else None
        return term if index is None else f.Constant(self.name(index))

    def _meant(self, term: f.Term) -> f.Term:
        """A term of subgoals with the name that its object has in the scene."""
        index = self.objects.get(term.name) if isinstance(term, f.Constant) else None
        return term if index is None else f.Constant(self.scene.objects[index].name)

    def _indices(self, terms: Iterable[f.Term]) -> tuple[int, ...] | None:
        index = self.objects
        found = [index[t.name] for t in terms if isinstance(t, f.Constant) and t.name in index]
        return tuple(found) if len(found) == len(tuple(terms)) else None

    def _terms(self, arguments: Iterable[int]) -> tuple[f.Term, ...]:
        return tuple([f.Constant(self.name(i)) for i in arguments])


def _renamed(
    leaf: f.Leaf,
    predicates: Mapping[str, str],
    actions: Mapping[str, str],
    change: Callable[[f.Term], f.Term],
) -> f.Leaf:
    """A leaf with another name of its predicate or action, where there is one, and with changed terms."""
    match leaf:
        case f.Atom(name, terms):
            return f.Atom(predicates.get(name, name), tuple([change(term) for term in terms]))
        case f.Occurs(name, terms):
            return f.Occurs(actions.get(name, name), tuple([change(term) for term in terms]))
        case f.Equals(left, right):
            return f.Equals(change(left), change(right))


def objects_and_classes(objects: Iterable[str], scene: Scene) -> frozenset[str]:
    """The names of objects, and those of the classes of a scene: a class stands for any object of it."""
    return frozenset([*objects, *[thing.category for thing in scene.objects]])


_TOKEN = re.compile(r"[\w\-]+(?:\.\d+)?|[^\w\s]")
_NAME = re.compile(r"\w")
_WORDS = frozenset({"and", "or", "not", "then", "until", "implies", "next", "eventually", "always"})
"""The marks between formulas and in front of them."""

_OUTPUT = "output"
"""The key of the subgoals in an answer."""

_FORMULA_LINE = re.compile(
    rf"""\W*(?:{_OUTPUT}["']\s*:.*|(?:not\s+)?[\w.]+\([\w.,\s-]*\)(?:\s*(?:and|or)\b.*)?)\W*"""
)

_NO_NEIGHBOURS = frozenset({",", ".", ":", "="})
"""The marks beside an object or a variable, and beside no formula."""


@dataclass(frozen=True, slots=True)
class WrittenSubgoals:
    """The subgoals of an answer.

    Attributes:
        subgoals: the formulas as texts, in order.
        repairs: names of the repairs that reading them took.
        spans: what became of the parts of the text.
    """

    subgoals: tuple[str, ...]
    repairs: tuple[str, ...] = ()
    spans: tuple[Span, ...] = field(default=(), compare=False)


class SubgoalNotation:
    """Reads subgoals from answers and writes them, and knows what is called what in them.

    This is the default, for any declared domain: an object with the key ``output``, a list of formulas, with
    the names that the domain declares (`spelt`) and those of the scene's objects or of their classes.

    Args:
        domain: the domain.
    """

    def __init__(self, domain: Domain) -> None:
        self.domain = domain

    def lexicon(self, scene: Scene) -> SubgoalLexicon:
        """The vocabulary of subgoals about a scene."""
        vocabulary = self.domain.vocabulary
        visible = [p.name for p in vocabulary.predicates if p.visible]
        predicates = spelt([*visible, *(derived.name for derived in vocabulary.derived)])
        actions = spelt([operator.name for operator in self.domain.operators])
        names = spelt([thing.name for thing in scene.objects])
        objects = {word: scene.index[name] for word, name in names.items()}
        signature = Signature(
            {word: vocabulary.arity(name) for word, name in predicates.items()},
            {word: self.domain.arities[name] for word, name in actions.items()},
            objects_and_classes(objects, scene),
        )
        return SubgoalLexicon(scene, signature, objects, predicates, actions)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """The subgoals in an answer, or why there are none."""
        alone = [p.name for p in self.domain.vocabulary.predicates if p.arity == 0]
        alone += [operator.name for operator in self.domain.operators if operator.arity == 0]
        return read_output(text, frozenset(spelt(alone)))

    def write(self, task: Task, plan: Iterable[Action]) -> tuple[str, ...]:
        """The subgoals that stand for a plan: for each action what it makes true about its objects.

        Where subgoals can say nothing of the kind it is what the action makes false about them, or else the
        action by its name, which also stands for one about nothing but the agent. An action that subgoals
        have no name for is then left out, and so is what cannot be carried out.
        """
        lexicon = self.lexicon(task.scene)
        subgoals: list[str] = []
        state = task.initial
        for action in plan:
            if action.operator not in self.domain.compiled:
                continue
            after = attempt(self.domain, Past(state), action)
            if isinstance(after, State):
                formula = self._standing_for(action, state, after, lexicon)
                subgoals += [] if formula is None else [print_ltl(formula)]
                state = after
        return tuple(subgoals)

    def _standing_for(
        self, action: Action, before: State, after: State, lexicon: SubgoalLexicon
    ) -> Formula | None:
        """The subgoal for an action that leads from a state to another, if there is one."""
        about = {*action.arguments} - {before.scene.agent}
        named = lexicon.names_action(action.operator)
        if about or not named:
            changes = change(before, after)
            for facts, truth in ((changes.added, True), (changes.removed, False)):
                own: dict[
                    tuple[str, frozenset[int]], Fact
                ] = {}  # of a fact and its mirror image one is enough
                for fact in facts:
                    if not about or not about.isdisjoint(fact.arguments):
                        own.setdefault((fact.predicate, frozenset(fact.arguments)), fact)
                written = [self._written(fact, truth, before, after, lexicon) for fact in own.values()]
                literals = tuple([literal for literal in written if literal is not None])
                if literals:
                    return literals[0] if len(literals) == 1 else And(literals)
        return lexicon.write_action(action) if named else None

    def _written(
        self, fact: Fact, truth: bool, before: State, after: State, lexicon: SubgoalLexicon
    ) -> Formula | None:
        """A change of a fact as subgoals say it: by its predicate, or by one that changes with it."""
        stored = self.domain.vocabulary.stored(fact.predicate)
        if stored is None or not stored.visible or len({*fact.arguments}) < len(fact.arguments):
            return None
        terms = tuple([Constant(before.scene.objects[i].name) for i in fact.arguments])
        for name in lexicon.predicates_of(len(terms), first=fact.predicate):
            atom = Atom(name, terms)
            if self.domain.holds(atom, after) is truth and self.domain.holds(atom, before) is not truth:
                return lexicon.write_literal(GroundAtom(name, fact.arguments, truth))
        return None

    def join(self, parts: Iterable[str]) -> str:
        """The subgoals as one answer."""
        return json.dumps({"output": list(parts)})

    def schema(self) -> Schema:
        """The form of an answer, for providers that can enforce one. A formula may be any text."""
        return closed({"output": listed(text())})


def read_output(
    text: str, without_arguments: Collection[str], others: Collection[str] = ()
) -> WrittenSubgoals | Unreadable:
    """Read the formulas in the list ``output`` of the object in an answer, or say why they cannot be read.

    Empty texts in the list are passed over. Names without objects need no brackets, alone or beside others;
    that is the repair ``brackets``.

    Args:
        text: the answer.
        without_arguments: the names that take no objects.
        others: other keys of the object that may hold lists.
    """
    reading = read_json(text, _output_form(frozenset(others)))
    if isinstance(reading, Unreadable):
        return reading
    repairs = dict.fromkeys(reading.repairs)
    subgoals: list[str] = []
    for subgoal in filter(None, map(str.strip, reading.value)):
        spelt_out = _with_brackets(subgoal, without_arguments) if without_arguments else subgoal
        repairs |= {} if spelt_out == subgoal else {"brackets": None}
        subgoals.append(spelt_out)
    return WrittenSubgoals(tuple(subgoals), tuple(repairs), reading.spans)


@lru_cache(16)
def _output_form(others: frozenset[str]) -> AnswerForm[list[str]]:
    def flaw(value: object) -> str | None:
        if not isinstance(value, Pairs):
            return None
        if value.repeated is not None:
            return f'the key "{value.repeated}" occurs twice'
        unknown = [key for key, part in value.members if isinstance(part, list | Pairs) and key not in others]
        return next((f'the key "{key}" is not known' for key in unknown if key != _OUTPUT), None)

    def output(value: object) -> list[str] | None:
        if flaw(value) is not None or not isinstance(value, Pairs):
            return None
        entries = dict(value.members).get(_OUTPUT)
        texts = [entry for entry in entries if isinstance(entry, str)] if isinstance(entries, list) else []
        return texts if isinstance(entries, list) and len(texts) == len(entries) else None

    wanted = f'JSON object with "{_OUTPUT}", a list of strings'
    return AnswerForm(wanted, output, is_part=holds_strings, is_line_of_answer=_is_formula, flaw=flaw)


def _is_formula(line: str) -> bool:
    """Whether a line outside the object is a formula or a key, and nothing else."""
    return _FORMULA_LINE.fullmatch(line) is not None


def _with_brackets(text: str, without_arguments: Collection[str]) -> str:
    """A text where names that take no objects have brackets; as it is where it has no formula at all."""
    tokens = [match[0] for match in _TOKEN.finditer(text)]
    if "(" not in tokens and any(t not in _WORDS and t not in without_arguments for t in tokens):
        return text
    around = ["", "", *tokens, ""]
    for i, token in enumerate(tokens):
        before_bracket, before, after = around[i], around[i + 1], around[i + 3]
        is_argument = before == "(" and _NAME.match(before_bracket) and before_bracket not in _WORDS
        if token in without_arguments and not is_argument and not {before, after} & _NO_NEIGHBOURS:
            tokens[i] = token if after == "(" else f"{token}()"
    pieces = _TOKEN.split(text)
    return "".join([piece for pair in zip(pieces, [*tokens, ""], strict=True) for piece in pair])
