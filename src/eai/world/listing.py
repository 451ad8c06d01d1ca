"""Listings: which facts about some objects hold, said with chosen predicates, stored or derived."""

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
from eai.world.derived import find_stored_predicates
from eai.world.frame import UNBOUND, Extension, Frame, Truth
from eai.world.relation import bits, mask_of
from eai.world.state import Fact, State
from eai.world.vocabulary import Vocabulary

_Objects: TypeAlias = Sequence[int]
_Tuples: TypeAlias = Callable[[_Objects], Iterable[tuple[int, ...]]]
_Holding: TypeAlias = Callable[[State, _Objects, int], Iterator[tuple[int, ...]]]
"""The tuples of objects, out of some, that make a predicate true, in the order of these.

The mask is of those of which at least one is in each tuple; `_ANY` does not ask for one."""

_ANY = -1


@dataclass(frozen=True, slots=True)
class FactListing:
    """The facts of one predicate.

    Attributes:
        predicate: its name.
        sources: the stored predicates that decide it: where these are as they were, so is the listing.
        repeated: whether facts in which an object stands twice are listed, too.
    """

    predicate: str
    sources: tuple[str, ...]
    repeated: bool
    _holding: _Holding

    @property
    def is_stored(self) -> bool:
        """Whether the predicate is stored and not derived."""
        return self.sources == (self.predicate,)

    def lists(self, fact: Fact) -> bool:
        """Whether a fact of this predicate is listed where it holds."""
        return self.repeated or len({*fact.arguments}) == len(fact.arguments)

    def facts(self, state: State, objects: Sequence[int], about: Iterable[int] | None = None) -> list[Fact]:
        """The facts about these objects, by their order: first arguments first.

        Args:
            state: in which they hold.
            objects: the objects.
            about: some of them; only facts with at least one of these are listed. None for all facts.
        """
        chosen = _ANY if about is None else mask_of(about)
        return [Fact(self.predicate, arguments) for arguments in self._holding(state, objects, chosen)]


def make_listing(vocabulary: Vocabulary, predicate: str, *, repeated: bool = False) -> FactListing:
    """The listing of a predicate.

    Args:
        vocabulary: that declares it.
        predicate: its name.
        repeated: whether facts in which an object stands twice are listed, too.

    Raises:
        DomainError: it is not declared.
    """
    sources = tuple(find_stored_predicates((predicate,), vocabulary))
    return FactListing(predicate, sources, repeated, _holding(vocabulary, predicate, repeated))


def _holding(vocabulary: Vocabulary, predicate: str, repeated: bool) -> _Holding:
    if vocabulary.find_stored(predicate) is not None and vocabulary.arity(predicate) == 2:
        return partial(_related, predicate, repeated)
    if predicate in vocabulary.tuple_slots:
        return partial(_among, predicate, repeated)
    declared = vocabulary.find_stored(predicate) or vocabulary.derived_by_name.get(predicate)
    if declared is None:
        raise DomainError(f"predicate {predicate} is not declared")
    variables = tuple(Variable(f"x{i}") for i in range(declared.arity))
    frame = Frame(variables)
    conditions = ConditionCompiler(vocabulary, frame)
    if declared.arity == 2:
        values = conditions.extension(declared(*variables), frame.scope["x1"], frame.scope)
        return partial(_paired, values, frame, repeated)
    tuples = partial(product, repeat=declared.arity) if repeated else partial(permutations, r=declared.arity)
    return partial(_true, conditions.truth(declared(*variables)), frame, tuples)


def _related(
    predicate: str, repeated: bool, state: State, objects: _Objects, chosen: int
) -> Iterator[tuple[int, ...]]:
    """Pairs of a stored relation."""
    relation, among = state.relation(predicate), mask_of(objects)
    sources = relation.sources
    if chosen != _ANY:
        sources &= reduce(or_, map(relation.column, bits(chosen & among)), chosen)
    for x in objects:
        if sources >> x & 1:
            wanted = among if chosen >> x & 1 else among & chosen
            yield from _pairs(x, relation.row(x) & wanted, objects, repeated)


def _among(
    predicate: str, repeated: bool, state: State, objects: _Objects, chosen: int
) -> Iterator[tuple[int, ...]]:
    """Tuples of a stored predicate of three or more arguments."""
    order = {index: place for place, index in enumerate(objects)}
    members = [m for m in state.tuple_set(predicate).members if _has_one(m, chosen)]
    found = [m for m in members if order.keys() >= {*m} and (repeated or len({*m}) == len(m))]
    yield from sorted(found, key=lambda member: [order[index] for index in member])


def _paired(
    values: Extension, frame: Frame, repeated: bool, state: State, objects: _Objects, chosen: int
) -> Iterator[tuple[int, ...]]:
    """Pairs of a derived relation."""
    among = mask_of(objects)
    for x in objects:
        wanted = among if chosen >> x & 1 else among & chosen
        row = values(state, frame.bind(state.scene, (x, UNBOUND)), wanted) if wanted else 0
        yield from _pairs(x, row, objects, repeated)


def _pairs(x: int, row: int, objects: _Objects, repeated: bool) -> Iterator[tuple[int, ...]]:
    return ((x, y) for y in objects if row >> y & 1 and (repeated or y != x)) if row else iter(())


def _true(
    truth: Truth, frame: Frame, tuples: _Tuples, state: State, objects: _Objects, chosen: int
) -> Iterator[tuple[int, ...]]:
    """Tuples of any length, one by one."""
    for arguments in tuples(objects):
        if _has_one(arguments, chosen) and truth(state, frame.bind(state.scene, arguments)):
            yield arguments


def _has_one(arguments: tuple[int, ...], chosen: int) -> bool:
    return chosen == _ANY or any(chosen >> index & 1 for index in arguments)
