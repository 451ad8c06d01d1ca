"""Mutually recursive derived predicates. Their facts are the least relations that satisfy all definitions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache, partial

import eai.logic.formula as f
from eai.base.errors import DomainError
from eai.logic.traversal import find_predicates, get_subformulas
from eai.world.derived import ComputedPredicate, DefinedPredicate, LookupPredicate
from eai.world.listing import FactLister, make_fact_lister
from eai.world.relation import ObjectMask
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import DerivedPredicate, Predicate, Vocabulary

_MAX_CACHED_STATES = 1024
"""Maximum number of states for which the facts of recursive predicates are cached."""


def make_recursive_predicates(
    definitions: Sequence[DefinedPredicate], get_vocabulary: Callable[[], Vocabulary]
) -> Sequence[DerivedPredicate]:
    """Make derived predicates from mutually recursive definitions.

    Args:
        definitions: the definitions; each may use the predicates that any of them defines.
        get_vocabulary: function that returns the vocabulary that contains these predicates. It is called when
            the predicates are first evaluated in a state.

    Raises:
        DomainError: a predicate depends on its own negation, so that no least relations exist.
    """
    names = {definition.name for definition in definitions}
    for definition in definitions:
        if not _is_monotone_in(definition.definition, names):
            raise DomainError(
                f"the derived predicate {definition.name} depends on its own negation: remove the negation"
            )
    return _RecursivePredicates(definitions, get_vocabulary).predicates


class _RecursivePredicates:
    """Mutually recursive predicates, with a cache of the relations that were computed for each state."""

    def __init__(
        self, definitions: Sequence[DefinedPredicate], get_vocabulary: Callable[[], Vocabulary]
    ) -> None:
        self._definitions = definitions
        self._names = {definition.name for definition in definitions}
        self._get_vocabulary = get_vocabulary
        self._scenes = lru_cache(_MAX_CACHED_STATES)(self._make_scenes_for_all_and_recursive_predicates)
        self._least = lru_cache(_MAX_CACHED_STATES)(self._find_least_fixpoint)
        self.predicates: list[DerivedPredicate] = [
            self._make_fixpoint_predicate(definition) for definition in definitions
        ]

    def _make_fixpoint_predicate(self, defined: DefinedPredicate) -> DerivedPredicate:
        reads = find_predicates(defined.definition)
        if defined.arity in (1, 2):
            return LookupPredicate(
                defined.name,
                defined.arity,
                partial(self._find_objects_completing_fact, defined.name),
                reads,
                defined,
            )
        return ComputedPredicate(
            defined.name, defined.arity, partial(self._is_true, defined.name), reads, defined
        )

    def _find_objects_completing_fact(
        self, predicate: str, state: State, first_arguments: tuple[int, ...]
    ) -> ObjectMask:
        least = self._least(state)
        return least.relation(predicate).row(first_arguments[0]) if first_arguments else least.mask(predicate)

    def _is_true(self, name: str, state: State, arguments: tuple[int, ...]) -> bool:
        return self._least(state).has(name, *arguments)

    @cached_property
    def _recursive_predicates_vocabulary(self) -> Vocabulary:
        return Vocabulary(
            tuple([Predicate(definition.name, definition.arity) for definition in self._definitions])
        )

    @cached_property
    def _fixpoint_iteration_vocabulary(self) -> Vocabulary:
        """Vocabulary in which each recursive predicate has its current and its next relation.

        The next relation follows from the current relations by the definitions. Current relations are stored
        predicates. Next relations are derived predicates.
        """
        whole = self._get_vocabulary()
        others = [item for item in whole.derived if item.name not in self._names]
        next_ones = [
            DefinedPredicate(f"{item.name} ", item.parameters, item.definition) for item in self._definitions
        ]
        predicates = (*whole.predicates, *self._recursive_predicates_vocabulary.predicates)
        return replace(whole, predicates=predicates, derived=(*others, *next_ones))

    @cached_property
    def _recursive_predicates_with_fact_listers(self) -> Sequence[tuple[str, FactLister]]:
        names = [definition.name for definition in self._definitions]
        return [
            (
                name,
                make_fact_lister(self._fixpoint_iteration_vocabulary, f"{name} ", allow_equal_arguments=True),
            )
            for name in names
        ]

    def _make_scenes_for_all_and_recursive_predicates(self, scene: Scene) -> tuple[Scene, Scene]:
        """Return two copies of a scene: one with all predicates, one with the recursive predicates only.

        In both, the recursive predicates are stored predicates, so that states can hold the facts that were
        derived so far.
        """
        all_predicates_scene, recursive_predicates_scene = [
            Scene(vocabulary, scene.objects, scene.agent)
            for vocabulary in (
                self._fixpoint_iteration_vocabulary,
                self._recursive_predicates_vocabulary,
            )
        ]
        return all_predicates_scene, recursive_predicates_scene

    def _find_least_fixpoint(self, state: State) -> State:
        """Return the state with all facts of the recursive predicates added.

        Facts that follow from the definitions are added until no new fact follows.
        """
        scene, recursive_predicates_scene = self._scenes(state.scene)
        everything = range(len(scene.objects))
        facts: list[Fact] = []
        while True:
            recursive_facts = recursive_predicates_scene.state(facts)
            extended = State(
                scene,
                state.unary + recursive_facts.unary,
                state.binary + recursive_facts.binary,
                state.tuples + recursive_facts.tuples,
            )
            next_facts = [
                Fact(name, fact.arguments)
                for name, facts_of in self._recursive_predicates_with_fact_listers
                for fact in facts_of.list_facts(extended, everything)
            ]
            if len(next_facts) == len(facts):
                return extended
            facts = next_facts


def _is_monotone_in(formula: f.Formula, predicates: set[str], truth: bool = True) -> bool:
    """Whether a formula with this truth value keeps it when more objects satisfy the predicates."""
    match formula:
        case f.Atom(predicate):
            return truth or predicate not in predicates
        case f.Not(operand):
            return _is_monotone_in(operand, predicates, not truth)
        case f.Implies(premise, conclusion):
            return _is_monotone_in(premise, predicates, not truth) and _is_monotone_in(
                conclusion, predicates, truth
            )
        case f.And() | f.Or() | f.ForAll() | f.Exists():
            return all(_is_monotone_in(part, predicates, truth) for part in get_subformulas(formula))
        case _:
            return predicates.isdisjoint(find_predicates(formula))
