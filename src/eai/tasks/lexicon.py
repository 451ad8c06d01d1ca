"""The words of formulas about a scene: how texts name its objects, predicates and actions."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.logic.ltl import spell_names
from eai.logic.rewriting import rewrite
from eai.logic.signature import Signature
from eai.logic.traversal import object_names, predicates_of
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.derived import is_a
from eai.world.domain import Domain
from eai.world.state import Scene


@dataclass(frozen=True)
class FormulaLexicon:
    """The words of formulas about one scene, such as subgoals and goals in task files.

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

    def candidate_predicates(self, arity: int, first: str) -> Iterator[str]:
        """The predicates of the domain that subgoals can say of so many objects; one is tried first."""
        words = [w for w, n in self.signature.predicates.items() if n == arity and w not in self.unobserved]
        names = dict.fromkeys([self.predicates.get(w, w) for w in words if w not in self.categories])
        yield from (first,) if first in names else ()
        yield from (name for name in names if name != first)

    def to_literal(self, formula: f.Formula) -> GroundAtom | None:
        """The condition that an atom or a negated one means; None if the domain cannot say it of objects."""
        atom, truth = (formula.operand, False) if isinstance(formula, f.Not) else (formula, True)
        if not isinstance(atom, f.Atom) or atom.predicate in self.unobserved:
            return None
        arguments = self._indices(atom.arguments)
        if arguments is None or atom.predicate in self.categories:
            return None
        return GroundAtom(self.predicates.get(atom.predicate, atom.predicate), arguments, truth)

    def to_action(self, formula: f.Occurs) -> Action:
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
        names = object_names(formula) if self.unobserved_objects else ()
        return any(name in self.unobserved for name in predicates_of(formula)) or any(
            name in self.unobserved_objects for name in names
        )

    def to_domain_names(self, formula: f.Formula) -> f.Formula:
        """A formula of subgoals in the words of the domain, with the names that objects have in the scene.

        Raises:
            InputError: it has a temporal operator other than ``then``.
        """

        def meant(leaf: f.Leaf, bound: frozenset[str]) -> f.Formula:
            if isinstance(leaf, f.Atom) and leaf.predicate in self.categories:
                return is_a(self._to_scene_term(leaf.arguments[0]), self.categories[leaf.predicate])
            return _rename_leaf(leaf, self.predicates, self.actions, self._to_scene_term)

        return rewrite(formula, meant)

    def to_text_names(self, formula: f.Formula) -> f.Formula:
        """A formula of the domain in the words of subgoals: what `meaning` makes it of.

        Raises:
            InputError: it has a temporal operator other than ``then``.
        """

        def worded(leaf: f.Leaf, bound: frozenset[str]) -> f.Formula:
            return _rename_leaf(leaf, self._predicate_words, self._action_words, self._to_text_term)

        return rewrite(formula, worded)

    def _to_text_term(self, term: f.Term) -> f.Term:
        """A term of the domain with the name that subgoals have for it."""
        index = self.scene.index.get(term.name) if isinstance(term, f.Constant) else None
        return term if index is None else f.Constant(self.name(index))

    def _to_scene_term(self, term: f.Term) -> f.Term:
        """A term of subgoals with the name that its object has in the scene."""
        index = self.objects.get(term.name) if isinstance(term, f.Constant) else None
        return term if index is None else f.Constant(self.scene.objects[index].name)

    def _indices(self, terms: Iterable[f.Term]) -> tuple[int, ...] | None:
        index = self.objects
        found = [index[t.name] for t in terms if isinstance(t, f.Constant) and t.name in index]
        return tuple(found) if len(found) == len(tuple(terms)) else None

    def _terms(self, arguments: Iterable[int]) -> tuple[f.Term, ...]:
        return tuple([f.Constant(self.name(i)) for i in arguments])


def _rename_leaf(
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


def make_declared_lexicon(domain: Domain, scene: Scene) -> FormulaLexicon:
    """Return the lexicon with the names that a domain declares (`spelt`) and those of the scene's objects."""
    vocabulary = domain.vocabulary
    visible = [p.name for p in vocabulary.predicates if p.visible]
    predicates = spell_names([*visible, *(derived.name for derived in vocabulary.derived)])
    actions = spell_names([operator.name for operator in domain.operators])
    names = spell_names([thing.name for thing in scene.objects])
    objects = {word: scene.index[name] for word, name in names.items()}
    signature = Signature(
        {word: vocabulary.arity(name) for word, name in predicates.items()},
        {word: domain.arities[name] for word, name in actions.items()},
        objects_and_classes(objects, scene),
    )
    return FormulaLexicon(scene, signature, objects, predicates, actions)
