"""Derived predicates that are defined by each other: the least relations that meet the definitions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache, partial

import eai.logic.formula as f
from eai.base.errors import DomainError
from eai.logic.traversal import children, predicates_of
from eai.world.derived import Computed, Defined, Lookup
from eai.world.listing import FactListing, make_listing
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import DerivedPredicate, Predicate, Vocabulary

_KEPT = 1024
"""For how many states the relations are remembered."""


def define_recursively(
    circle: Sequence[Defined], vocabulary: Callable[[], Vocabulary]
) -> Sequence[DerivedPredicate]:
    """Predicates that are defined by each other, or one that is defined by itself.

    Args:
        circle: their definitions.
        vocabulary: gives the vocabulary that has them; it is asked when a state is read for the first time.

    Raises:
        DomainError: one of them depends on its own negation, so that there are no least relations.
    """
    names = {each.name for each in circle}
    for each in circle:
        if not _is_positive(each.definition, names):
            raise DomainError(f"the derived predicate {each.name} depends on its own negation")
    return _Recursion(circle, vocabulary).predicates


class _Recursion:
    """Predicates that are defined by each other, with the relations that were found in states.

    Attributes:
        predicates: the derived predicates, in order.
    """

    def __init__(self, circle: Sequence[Defined], vocabulary: Callable[[], Vocabulary]) -> None:
        self._circle = circle
        self._names = {each.name for each in circle}
        self._whole = vocabulary
        self._scene = lru_cache(_KEPT)(self._extended)
        self._least = lru_cache(_KEPT)(self._found)
        self.predicates: list[DerivedPredicate] = [self._predicate(each) for each in circle]

    def _predicate(self, defined: Defined) -> DerivedPredicate:
        reads = predicates_of(defined.definition)
        if defined.arity in (1, 2):
            return Lookup(defined.name, defined.arity, partial(self._mask, defined.name), reads, defined)
        return Computed(defined.name, defined.arity, partial(self._has, defined.name), reads, defined)

    def _mask(self, name: str, state: State, arguments: tuple[int, ...]) -> int:
        least = self._least(state)
        return least.relation(name).row(arguments[0]) if arguments else least.mask(name)

    def _has(self, name: str, state: State, arguments: tuple[int, ...]) -> bool:
        return self._least(state).has(name, *arguments)

    @cached_property
    def _own(self) -> Vocabulary:
        """The circle as if it were stored."""
        return Vocabulary(tuple([Predicate(each.name, each.arity) for each in self._circle]))

    @cached_property
    def _vocabulary(self) -> Vocabulary:
        """The vocabulary in which the circle is stored, and what follows from that at once is derived."""
        whole = self._whole()
        others = [each for each in whole.derived if each.name not in self._names]
        next_ones = [Defined(f"{each.name} ", each.parameters, each.definition) for each in self._circle]
        return Vocabulary((*whole.predicates, *self._own.predicates), (*others, *next_ones))

    @cached_property
    def _listings(self) -> Sequence[tuple[str, FactListing]]:
        names = [each.name for each in self._circle]
        return [(name, make_listing(self._vocabulary, f"{name} ", repeated=True)) for name in names]

    def _extended(self, scene: Scene) -> tuple[Scene, Scene]:
        """The scene in the whole vocabulary, and for the circle alone."""
        whole, own = [Scene(each, scene.objects, scene.agent) for each in (self._vocabulary, self._own)]
        return whole, own

    def _found(self, state: State) -> State:
        """The state in which the least relations are stored: all that follows is added until nothing does."""
        scene, alone = self._scene(state.scene)
        everything = range(len(scene.objects))
        facts: list[Fact] = []
        while True:
            own = alone.state(facts)
            known = State(
                scene, state.unary + own.unary, state.binary + own.binary, state.tuples + own.tuples
            )
            found = [
                Fact(name, each.arguments)
                for name, listed in self._listings
                for each in listed.facts(known, everything)
            ]
            if len(found) == len(facts):
                return known
            facts = found


def _is_positive(formula: f.Formula, names: set[str], truth: bool = True) -> bool:
    """Whether a formula names predicates only where their truth helps it to its own."""
    match formula:
        case f.Atom(predicate):
            return truth or predicate not in names
        case f.Not(operand):
            return _is_positive(operand, names, not truth)
        case f.Implies(premise, conclusion):
            return _is_positive(premise, names, not truth) and _is_positive(conclusion, names, truth)
        case f.And() | f.Or() | f.ForAll() | f.Exists():
            return all(_is_positive(part, names, truth) for part in children(formula))
        case _:
            return names.isdisjoint(predicates_of(formula))
