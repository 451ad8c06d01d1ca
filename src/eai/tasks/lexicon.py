"""The names of objects, predicates and actions in formulas about a scene, such as subgoals and goals."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.logic.ltl import map_formula_safe_names_to_original_names
from eai.logic.rewriting import rewrite_leaves
from eai.logic.signature import FormulaSignature
from eai.logic.traversal import find_object_names, find_predicates
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.derived import is_a
from eai.world.domain import Domain
from eai.world.state import Scene


@dataclass(frozen=True)
class FormulaNameLexicon:
    """The names in formulas about one scene, such as subgoals and goals in task files.

    A text, such as an answer or a task file, may name a predicate, an action or an object differently than
    the domain.

    Attributes:
        scene: the scene.
        signature: the names that texts may use: predicates, actions, and objects or their classes.
        objects: mapping from names in texts to objects. An object with several names is written with the name
            that comes last in this mapping.
        predicates: mapping from a predicate's name in texts to its name in the domain, if the two differ.
        actions: mapping from an action's name in texts to its name in the domain, if the two differ.
        categories: for each predicate that states the kind of an object, the category that it states.
        unobserved: predicates that the domain does not know. Literals with these predicates count as true.
        unobserved_objects: names of objects whose states the domain does not know. Literals about these
            objects count as true.
    """

    scene: Scene
    signature: FormulaSignature
    objects: Mapping[str, int]
    predicates: Mapping[str, str] = field(default_factory=dict)
    actions: Mapping[str, str] = field(default_factory=dict)
    categories: Mapping[str, str] = field(default_factory=dict)
    unobserved: Collection[str] = frozenset()
    unobserved_objects: Collection[str] = frozenset()

    @cached_property
    def _object_names(self) -> Mapping[int, str]:
        return {index: name for name, index in self.objects.items()}

    @cached_property
    def _lexicon_name_by_predicate(self) -> Mapping[str, str]:
        return {
            name: word
            for word, name in self.predicates.items()
            if name not in self.signature.predicates or name in self.predicates
        }

    @cached_property
    def _lexicon_name_by_action(self) -> Mapping[str, str]:
        return {name: word for word, name in self.actions.items()}

    def get_object_name(self, index: int) -> str:
        """Return the name by which texts, such as answers and task files, refer to an object."""
        return self._object_names[index]

    def convert_literal_to_formula(self, literal: GroundAtom) -> f.Formula:
        """Return a literal without variables as a formula with the names that answers and task files use."""
        word = self._lexicon_name_by_predicate.get(literal.predicate, literal.predicate)
        atom = f.Atom(word, self._make_object_terms(literal.arguments))
        return atom if literal.truth else f.Not(atom)

    def convert_action_to_formula(self, action: Action) -> f.Occurs:
        """Return an action on given objects as a formula with the names that answers and task files use."""
        return f.Occurs(
            self._lexicon_name_by_action.get(action.operator, action.operator),
            self._make_object_terms(action.arguments),
        )

    def has_lexicon_name_for_action(self, operator: str) -> bool:
        """Whether formulas in answers and task files have a name for an action of the domain."""
        return self._lexicon_name_by_action.get(operator, operator) in self.signature.actions

    def find_predicates_of_arity(self, arity: int, put_first: str) -> Iterator[str]:
        """Yield the domain's predicates of a given arity that answers and task files can name.

        If the predicate `put_first` is among them, it comes first.
        """
        words = [w for w, n in self.signature.predicates.items() if n == arity and w not in self.unobserved]
        names = dict.fromkeys([self.predicates.get(w, w) for w in words if w not in self.categories])
        yield from (put_first,) if put_first in names else ()
        yield from (name for name in names if name != put_first)

    def to_literal(self, formula: f.Formula) -> GroundAtom | None:
        """Return the literal of the domain that an atom or a negated atom in an answer or a task file states.

        Return None if the domain cannot state this literal, for example if an argument is a variable or a
        class instead of an object.
        """
        atom, truth = (formula.operand, False) if isinstance(formula, f.Not) else (formula, True)
        if not isinstance(atom, f.Atom) or atom.predicate in self.unobserved:
            return None
        arguments = self._find_object_indices(atom.arguments)
        if arguments is None or atom.predicate in self.categories:
            return None
        return GroundAtom(self.predicates.get(atom.predicate, atom.predicate), arguments, truth)

    def to_action(self, formula: f.Occurs) -> Action:
        """Return the domain's action that an action in a formula stands for.

        Raises:
            InputError: an argument is not an object.
        """
        arguments = self._find_object_indices(formula.arguments)
        if arguments is None:
            raise InputError(
                f"action {formula.action}: expected the names of objects in the scene as arguments"
            )
        return Action(self.actions.get(formula.action, formula.action), arguments)

    def is_class_name(self, name: str) -> bool:
        """Whether a name is the name of a class. Such a name stands for any object of the class."""
        return name not in self.objects and name not in self.unobserved_objects

    def has_unknown_names(self, formula: f.Formula) -> bool:
        """Whether a formula has a predicate or an object that the domain does not know."""
        names = find_object_names(formula) if self.unobserved_objects else ()
        return any(name in self.unobserved for name in find_predicates(formula)) or any(
            name in self.unobserved_objects for name in names
        )

    def replace_lexicon_names_by_domain_names(self, formula: f.Formula) -> f.Formula:
        """Return a formula from an answer or a task file with the names that the domain and its scene use.

        Raises:
            InputError: the formula has a temporal operator other than ``then``.
        """

        def rename_leaf_for_domain(leaf: f.Leaf, bound: frozenset[str]) -> f.Formula:
            if isinstance(leaf, f.Atom) and leaf.predicate in self.categories:
                return is_a(self._rename_object_for_scene(leaf.arguments[0]), self.categories[leaf.predicate])
            return _rename_leaf(leaf, self.predicates, self.actions, self._rename_object_for_scene)

        return rewrite_leaves(formula, rename_leaf_for_domain)

    def replace_domain_names_by_lexicon_names(self, formula: f.Formula) -> f.Formula:
        """Return a formula of the domain with the names that answers and task files use.

        This is the inverse of `replace_lexicon_names_by_domain_names`.

        Raises:
            InputError: the formula has a temporal operator other than ``then``.
        """

        def replace_domain_by_lexicon_names_in_leaf(
            leaf: f.Leaf, bound_variables: frozenset[str]
        ) -> f.Formula:
            return _rename_leaf(
                leaf,
                self._lexicon_name_by_predicate,
                self._lexicon_name_by_action,
                self._replace_scene_object_by_lexicon_name,
            )

        return rewrite_leaves(formula, replace_domain_by_lexicon_names_in_leaf)

    def _replace_scene_object_by_lexicon_name(self, term: f.Term) -> f.Term:
        index = self.scene.index.get(term.name) if isinstance(term, f.Constant) else None
        return term if index is None else f.Constant(self.get_object_name(index))

    def _rename_object_for_scene(self, term: f.Term) -> f.Term:
        index = self.objects.get(term.name) if isinstance(term, f.Constant) else None
        return term if index is None else f.Constant(self.scene.objects[index].name)

    def _find_object_indices(self, terms: Iterable[f.Term]) -> tuple[int, ...] | None:
        index = self.objects
        indices = [index[t.name] for t in terms if isinstance(t, f.Constant) and t.name in index]
        return tuple(indices) if len(indices) == len(tuple(terms)) else None

    def _make_object_terms(self, object_indices: Iterable[int]) -> tuple[f.Term, ...]:
        return tuple([f.Constant(self.get_object_name(i)) for i in object_indices])


def _rename_leaf(
    leaf: f.Leaf,
    predicates: Mapping[str, str],
    actions: Mapping[str, str],
    rename_term: Callable[[f.Term], f.Term],
) -> f.Leaf:
    match leaf:
        case f.Atom(name, terms):
            return f.Atom(predicates.get(name, name), tuple([rename_term(term) for term in terms]))
        case f.Occurs(name, terms):
            return f.Occurs(actions.get(name, name), tuple([rename_term(term) for term in terms]))
        case f.Equals(left, right):
            return f.Equals(rename_term(left), rename_term(right))


def collect_names_of_objects_and_classes(objects: Iterable[str], scene: Scene) -> frozenset[str]:
    """Return the names of the objects of a scene, and of the objects' classes.

    A class's name stands for any object of the class.
    """
    return frozenset([*objects, *[thing.category for thing in scene.objects]])


def make_lexicon_of_declared_names(domain: Domain, scene: Scene) -> FormulaNameLexicon:
    """Return the lexicon for formulas with the declared names of a domain and of the objects of a scene.

    Characters that formulas do not allow in names are replaced.
    """
    vocabulary = domain.vocabulary
    visible = [p.name for p in vocabulary.predicates if p.visible]
    predicates = map_formula_safe_names_to_original_names(
        [*visible, *(derived.name for derived in vocabulary.derived)]
    )
    actions = map_formula_safe_names_to_original_names([operator.name for operator in domain.operators])
    names = map_formula_safe_names_to_original_names([thing.name for thing in scene.objects])
    objects = {word: scene.index[name] for word, name in names.items()}
    signature = FormulaSignature(
        {word: vocabulary.find_arity(name) for word, name in predicates.items()},
        {word: domain.operator_arities[name] for word, name in actions.items()},
        collect_names_of_objects_and_classes(objects, scene),
    )
    return FormulaNameLexicon(scene, signature, objects, predicates, actions)
