"""The vocabulary of subgoals about one scene, and its meaning in the words of the domain."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import eai.logic.formula as f
from eai.errors import InputError
from eai.logic.rewriting import Leaf, rewrite
from eai.logic.signature import Signature
from eai.logic.traversal import walk
from eai.planning.subgoal import GroundAtom
from eai.world.derived import is_a
from eai.world.execution import Action
from eai.world.state import Scene

_UNSPEAKABLE = re.compile(r"\W")
_NUMBERED = re.compile(r"(.+)\.([0-9]+)")


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
        unobserved: predicates of which the domain knows nothing: what is said with them is passed over.
    """

    scene: Scene
    signature: Signature
    objects: Mapping[str, int]
    predicates: Mapping[str, str] = field(default_factory=dict)
    actions: Mapping[str, str] = field(default_factory=dict)
    categories: Mapping[str, str] = field(default_factory=dict)
    unobserved: Collection[str] = frozenset()

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

    def is_unobserved(self, formula: f.Formula) -> bool:
        """Whether a formula says anything of which the domain knows nothing."""
        return any(isinstance(part, f.Atom) and part.predicate in self.unobserved for part in walk(formula))

    def meaning(self, formula: f.Formula) -> f.Formula:
        """A formula of subgoals in the words of the domain, with the names that objects have in the scene.

        Raises:
            InputError: it has a temporal operator other than ``then``.
        """
        return rewrite(formula, lambda leaf, bound: self._meaning(leaf))

    def worded(self, formula: f.Formula) -> f.Formula:
        """A formula of the domain in the words of subgoals: what `meaning` makes it of.

        Raises:
            InputError: it has a temporal operator other than ``then``.
        """
        return rewrite(formula, lambda leaf, bound: self._worded(leaf))

    def _worded(self, leaf: Leaf) -> f.Formula:
        match leaf:
            case f.Equals(left, right):
                return f.Equals(self._word(left), self._word(right))
            case f.Atom(predicate, arguments):
                terms = tuple([self._word(term) for term in arguments])
                return f.Atom(self._predicate_words.get(predicate, predicate), terms)
            case f.Occurs(action, arguments):
                terms = tuple([self._word(term) for term in arguments])
                return f.Occurs(self._action_words.get(action, action), terms)

    def _word(self, term: f.Term) -> f.Term:
        """A term of the domain with the name that subgoals have for it."""
        index = self.scene.index.get(term.name) if isinstance(term, f.Constant) else None
        return term if index is None else f.Constant(self.name(index))

    def _meaning(self, leaf: Leaf) -> f.Formula:
        match leaf:
            case f.Equals(left, right):
                left, right = self._meant((left, right))
                return f.Equals(left, right)
            case f.Atom(predicate, arguments):
                terms = self._meant(arguments)
                if predicate in self.categories:
                    return is_a(terms[0], self.categories[predicate])
                return f.Atom(self.predicates.get(predicate, predicate), terms)
            case f.Occurs(action, arguments):
                return f.Occurs(self.actions.get(action, action), self._meant(arguments))

    def _meant(self, terms: Iterable[f.Term]) -> tuple[f.Term, ...]:
        """Terms with objects by their names in the scene."""
        things, index = self.scene.objects, self.objects
        return tuple(
            [
                f.Constant(things[index[term.name]].name)
                if isinstance(term, f.Constant) and term.name in index
                else term
                for term in terms
            ]
        )

    def _indices(self, terms: Iterable[f.Term]) -> tuple[int, ...] | None:
        index = self.objects
        found = [index[t.name] for t in terms if isinstance(t, f.Constant) and t.name in index]
        return tuple(found) if len(found) == len(tuple(terms)) else None

    def _terms(self, arguments: Iterable[int]) -> tuple[f.Term, ...]:
        return tuple([f.Constant(self.name(i)) for i in arguments])


class ObjectsAndClasses:
    """The names of objects, and those of the classes of a scene: a class stands for any object of it."""

    __slots__ = ("_objects", "_scene")

    def __init__(self, objects: Mapping[str, int], scene: Scene) -> None:
        self._objects = objects
        self._scene = scene

    def __contains__(self, name: object) -> bool:
        return name in self._objects or (isinstance(name, str) and self._scene.category(name) != 0)


def spelt(names: Iterable[str]) -> dict[str, str]:
    """Names as formulas can have them -> the names themselves, in order.

    What cannot stand in a formula's names becomes an underscore; where that makes two names one, the later
    gets one more.
    """
    words: dict[str, str] = {}
    for name in names:
        match = _NUMBERED.fullmatch(name)
        stem, number = (match[1], f".{match[2]}") if match else (name, "")
        stem = _UNSPEAKABLE.sub("_", stem)
        stem = stem if stem[:1].isalpha() or stem[:1] == "_" else f"_{stem}"
        while f"{stem}{number}" in words:
            stem += "_"
        words[f"{stem}{number}"] = name
    return words
