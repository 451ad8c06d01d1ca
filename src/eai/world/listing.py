"""List the facts of a stored or derived predicate that hold for given objects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial, reduce
from itertools import permutations, product
from operator import or_
from typing import TypeAlias

from eai.base.errors import DomainError
from eai.logic.formula import Variable
from eai.world.condition import ConditionCompiler
from eai.world.derived import find_stored_dependencies
from eai.world.frame import UNBOUND, ConditionTest, ObjectFilter, SlotAllocator
from eai.world.relation import ObjectMask, iterate_bits, make_mask
from eai.world.state import Fact, State
from eai.world.vocabulary import Vocabulary

_ObjectIndices: TypeAlias = Sequence[int]
_MakeTuples: TypeAlias = Callable[[_ObjectIndices], Iterable[tuple[int, ...]]]
_ArgumentTupleFinder: TypeAlias = Callable[[State, _ObjectIndices, ObjectMask], Iterator[tuple[int, ...]]]
"""Function that yields the tuples of objects for which a predicate holds, in the order of given objects.

Its last argument is a bit mask of objects: each tuple contains at least one of them. `_ANY` allows all
tuples.
"""

_ANY = -1


@dataclass(frozen=True, slots=True)
class FactLister:
    """Lists the facts of one predicate.

    Attributes:
        predicate: the name of the predicate.
        sources: the stored predicates that the predicate depends on. If they do not change, its facts do not
            change.
        allow_equal_arguments: whether to list facts that contain an object twice, such as ``near(a, a)``.
    """

    predicate: str
    sources: tuple[str, ...]
    allow_equal_arguments: bool
    _find_tuples: _ArgumentTupleFinder

    @property
    def is_predicate_stored(self) -> bool:
        """Whether the predicate is stored, not derived."""
        return self.sources == (self.predicate,)

    def is_listed_if_true(self, fact: Fact) -> bool:
        """Whether `list_facts` lists a fact if it holds.

        Without `allow_equal_arguments`, facts that contain an object twice are not listed.
        """
        return self.allow_equal_arguments or len({*fact.arguments}) == len(fact.arguments)

    def list_facts(
        self, state: State, objects: Sequence[int], about: Iterable[int] | None = None
    ) -> list[Fact]:
        """Return the facts about these objects, sorted by first argument, then by the next arguments.

        Args:
            state: the state in which the facts hold.
            objects: the objects, in the order by which facts are sorted.
            about: objects; each listed fact contains at least one. None for all facts.
        """
        chosen = _ANY if about is None else make_mask(about)
        return [Fact(self.predicate, arguments) for arguments in self._find_tuples(state, objects, chosen)]


def make_fact_lister(
    vocabulary: Vocabulary, predicate: str, *, allow_equal_arguments: bool = False
) -> FactLister:
    """Return the object that lists the facts of a predicate.

    Args:
        vocabulary: the vocabulary that declares the predicate.
        predicate: the name of the predicate.
        allow_equal_arguments: whether to list facts that contain an object twice, such as ``near(a, a)``.

    Raises:
        DomainError: the predicate is not declared.
    """
    sources = tuple(find_stored_dependencies((predicate,), vocabulary))
    return FactLister(
        predicate,
        sources,
        allow_equal_arguments,
        _choose_argument_tuple_finder(vocabulary, predicate, allow_equal_arguments),
    )


def _choose_argument_tuple_finder(
    vocabulary: Vocabulary, predicate: str, allow_equal_arguments: bool
) -> _ArgumentTupleFinder:
    if vocabulary.find_stored_predicate(predicate) is not None and vocabulary.find_arity(predicate) == 2:
        return partial(_list_pairs_of_stored_predicate, predicate, allow_equal_arguments)
    if predicate in vocabulary.tuple_slots:
        return partial(_list_tuples_of_stored_predicate, predicate, allow_equal_arguments)
    declared = vocabulary.find_stored_predicate(predicate) or vocabulary.derived_by_name.get(predicate)
    if declared is None:
        raise DomainError(
            f"predicate {predicate} is not declared: declare it in the vocabulary, or correct the name"
        )
    variables = tuple(Variable(f"x{i}") for i in range(declared.arity))
    frame = SlotAllocator(variables)
    conditions = ConditionCompiler(vocabulary, frame)
    if declared.arity == 2:
        values = conditions.compile_filter(declared(*variables), frame.scope["x1"], frame.scope)
        return partial(_list_pairs_of_derived_predicate, values, frame, allow_equal_arguments)
    tuples = (
        partial(product, repeat=declared.arity)
        if allow_equal_arguments
        else partial(permutations, r=declared.arity)
    )
    return partial(_find_tuples_by_testing_each, conditions.compile_test(declared(*variables)), frame, tuples)


def _list_pairs_of_stored_predicate(
    predicate: str,
    allow_equal_arguments: bool,
    state: State,
    objects: _ObjectIndices,
    must_include_one_of: ObjectMask,
) -> Iterator[tuple[int, ...]]:
    relation, among = state.relation(predicate), make_mask(objects)
    sources = relation.sources
    if must_include_one_of != _ANY:
        sources &= reduce(
            or_, map(relation.column, iterate_bits(must_include_one_of & among)), must_include_one_of
        )
    for x in objects:
        if sources >> x & 1:
            wanted = among if must_include_one_of >> x & 1 else among & must_include_one_of
            yield from _make_pairs_with_first_object(
                x, relation.row(x) & wanted, objects, allow_equal_arguments
            )


def _list_tuples_of_stored_predicate(
    predicate: str,
    allow_equal_arguments: bool,
    state: State,
    objects: _ObjectIndices,
    must_include_one_of: ObjectMask,
) -> Iterator[tuple[int, ...]]:
    order = {index: position for position, index in enumerate(objects)}
    members = [m for m in state.get_tuple_set(predicate).members if _includes_any(m, must_include_one_of)]
    listed = [m for m in members if order.keys() >= {*m} and (allow_equal_arguments or len({*m}) == len(m))]
    yield from sorted(listed, key=lambda member: [order[index] for index in member])


def _list_pairs_of_derived_predicate(
    find_second_arguments: ObjectFilter,
    argument_slots: SlotAllocator,
    allow_equal_arguments: bool,
    state: State,
    objects: _ObjectIndices,
    must_include_one_of: ObjectMask,
) -> Iterator[tuple[int, ...]]:
    among = make_mask(objects)
    for x in objects:
        wanted = among if must_include_one_of >> x & 1 else among & must_include_one_of
        row = (
            find_second_arguments(state, argument_slots.bind_arguments(state.scene, (x, UNBOUND)), wanted)
            if wanted
            else 0
        )
        yield from _make_pairs_with_first_object(x, row, objects, allow_equal_arguments)


def _make_pairs_with_first_object(
    first: int, second_objects: ObjectMask, objects: _ObjectIndices, allow_equal_arguments: bool
) -> Iterator[tuple[int, ...]]:
    if second_objects:
        return (
            (first, y) for y in objects if second_objects >> y & 1 and (allow_equal_arguments or y != first)
        )
    return iter(())


def _find_tuples_by_testing_each(
    test: ConditionTest,
    frame: SlotAllocator,
    make_tuples: _MakeTuples,
    state: State,
    objects: _ObjectIndices,
    must_include_one_of: ObjectMask,
) -> Iterator[tuple[int, ...]]:
    for arguments in make_tuples(objects):
        if _includes_any(arguments, must_include_one_of) and test(
            state, frame.bind_arguments(state.scene, arguments)
        ):
            yield arguments


def _includes_any(arguments: tuple[int, ...], must_include_one_of: ObjectMask) -> bool:
    return must_include_one_of == _ANY or any(must_include_one_of >> index & 1 for index in arguments)
