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
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import DerivedPredicate, Predicate, Vocabulary

_MAX_CACHED_STATES = 1024
"""Maximum number of states whose relations are cached. The same number limits the cached scenes."""


def define_recursively(
    circle: Sequence[DefinedPredicate], vocabulary: Callable[[], Vocabulary]
) -> Sequence[DerivedPredicate]:
    """Make derived predicates from mutually recursive definitions.

    Args:
        circle: the definitions; each may use the predicates that any of them defines.
        vocabulary: function that returns the vocabulary that contains these predicates. It is called when the
            predicates are first evaluated in a state.

    Raises:
        DomainError: a predicate depends on its own negation, so that no least relations exist.
    """
    names = {definition.name for definition in circle}
    for definition in circle:
        if not _is_monotone_in(definition.definition, names):
            raise DomainError(
                f"the derived predicate {definition.name} depends on its own negation: define it without"
            )
    return _RecursivePredicates(circle, vocabulary).predicates


class _RecursivePredicates:
    """Mutually recursive predicates, with a cache of the relations that were computed for each state."""

    def __init__(self, circle: Sequence[DefinedPredicate], vocabulary: Callable[[], Vocabulary]) -> None:
        self._circle = circle
        self._names = {definition.name for definition in circle}
        self._whole = vocabulary
        self._scene = lru_cache(_MAX_CACHED_STATES)(self._extend_scene)
        self._least = lru_cache(_MAX_CACHED_STATES)(self._find_least_fixpoint)
        self.predicates: list[DerivedPredicate] = [self._make_predicate(definition) for definition in circle]

    def _make_predicate(self, defined: DefinedPredicate) -> DerivedPredicate:
        reads = find_predicates(defined.definition)
        if defined.arity in (1, 2):
            return LookupPredicate(
                defined.name, defined.arity, partial(self._compute_mask, defined.name), reads, defined
            )
        return ComputedPredicate(
            defined.name, defined.arity, partial(self._is_true, defined.name), reads, defined
        )

    def _compute_mask(self, name: str, state: State, arguments: tuple[int, ...]) -> int:
        least = self._least(state)
        return least.relation(name).row(arguments[0]) if arguments else least.mask(name)

    def _is_true(self, name: str, state: State, arguments: tuple[int, ...]) -> bool:
        return self._least(state).has(name, *arguments)

    @cached_property
    def _circle_vocabulary(self) -> Vocabulary:
        return Vocabulary(
            tuple([Predicate(definition.name, definition.arity) for definition in self._circle])
        )

    @cached_property
    def _iteration_vocabulary(self) -> Vocabulary:
        """Vocabulary for one iteration of the fixpoint.

        The current relations of the recursive predicates are stored; their next relations are derived.
        """
        whole = self._whole()
        others = [item for item in whole.derived if item.name not in self._names]
        next_ones = [
            DefinedPredicate(f"{item.name} ", item.parameters, item.definition) for item in self._circle
        ]
        predicates = (*whole.predicates, *self._circle_vocabulary.predicates)
        return replace(whole, predicates=predicates, derived=(*others, *next_ones))

    @cached_property
    def _listings(self) -> Sequence[tuple[str, FactLister]]:
        names = [definition.name for definition in self._circle]
        return [
            (name, make_fact_lister(self._iteration_vocabulary, f"{name} ", repeated=True)) for name in names
        ]

    def _extend_scene(self, scene: Scene) -> tuple[Scene, Scene]:
        whole, circle = [
            Scene(vocabulary, scene.objects, scene.agent)
            for vocabulary in (self._iteration_vocabulary, self._circle_vocabulary)
        ]
        return whole, circle

    def _find_least_fixpoint(self, state: State) -> State:
        """Return the state with all facts of the recursive predicates added.

        Facts that follow from the definitions are added until no new fact follows.
        """
        scene, circle_scene = self._scene(state.scene)
        everything = range(len(scene.objects))
        facts: list[Fact] = []
        while True:
            circle = circle_scene.state(facts)
            extended = State(
                scene, state.unary + circle.unary, state.binary + circle.binary, state.tuples + circle.tuples
            )
            next_facts = [
                Fact(name, fact.arguments)
                for name, facts_of in self._listings
                for fact in facts_of.list_facts(extended, everything)
            ]
            if len(next_facts) == len(facts):
                return extended
            facts = next_facts


def _is_monotone_in(formula: f.Formula, names: set[str], truth: bool = True) -> bool:
    """Whether a formula stays true when a predicate among ``names`` becomes true of more objects."""
    match formula:
        case f.Atom(predicate):
            return truth or predicate not in names
        case f.Not(operand):
            return _is_monotone_in(operand, names, not truth)
        case f.Implies(premise, conclusion):
            return _is_monotone_in(premise, names, not truth) and _is_monotone_in(conclusion, names, truth)
        case f.And() | f.Or() | f.ForAll() | f.Exists():
            return all(_is_monotone_in(part, names, truth) for part in get_subformulas(formula))
        case _:
            return names.isdisjoint(find_predicates(formula))
