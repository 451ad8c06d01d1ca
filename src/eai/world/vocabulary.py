"""The predicates of a domain, and the slots (numbers) by which states keep their facts.

A state keeps the facts of stored predicates. The facts of derived predicates are computed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType, UnionType
from typing import Protocol, get_args, runtime_checkable

from eai.base.errors import DomainError, did_you_mean
from eai.logic.formula import Atom, Constant, Term
from eai.logic.signature import describe_wrong_arity, join_with_or


@dataclass(frozen=True, slots=True)
class Predicate:
    """A stored predicate. Calling it with terms makes an atom.

    Attributes:
        name: the name.
        arity: the number of arguments.
        static: whether no operator changes the predicate.
        visible: whether prompts, goals and answers may mention the predicate; False if only the simulator
            needs it.
        single: whether the other arguments determine the last argument: in every reachable state, at most
            one object makes the predicate true as last argument.
    """

    name: str
    arity: int
    static: bool = False
    visible: bool = True
    single: bool = False

    def __call__(self, *terms: Term | str) -> Atom:
        """Return the atom of this predicate with these terms; a term that is a text names an object."""
        return make_atom(self.name, self.arity, terms)


@runtime_checkable
class DerivedPredicate(Protocol):
    """A predicate that is computed from stored predicates. The classes are in `eai.world.derived`."""

    @property
    def name(self) -> str:
        """The name of the predicate."""
        ...

    @property
    def arity(self) -> int:
        """The number of arguments."""
        ...

    @property
    def reads(self) -> tuple[str, ...]:
        """Names of the predicates that this predicate's function reads; empty if a formula defines it."""
        ...

    def __call__(self, *terms: Term | str) -> Atom:
        """Return the atom of this predicate with these terms."""
        ...


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """The predicates of a domain, and the slot in which a state keeps the facts of each stored predicate.

    Slots are numbered from 0 in each of three groups: predicates of arity 0 and 1, of arity 2, and of higher
    arity.

    Attributes:
        predicates: the stored predicates.
        derived: the derived predicates.
        parents: mapping from a kind of objects to the wider kind that contains it, as types in PDDL:
            ``{"cup": "container"}``.

    Raises:
        DomainError: two predicates have the same name, an arity is negative, a derived predicate reads an
            unknown predicate, or a kind contains itself.
    """

    predicates: tuple[Predicate, ...]
    derived: tuple[DerivedPredicate, ...] = ()
    parents: Mapping[str, str] = field(default_factory=dict, hash=False)
    unary_slots: Mapping[str, int] = field(init=False, compare=False)
    binary_slots: Mapping[str, int] = field(init=False, compare=False)
    tuple_slots: Mapping[str, int] = field(init=False, compare=False)
    derived_by_name: Mapping[str, DerivedPredicate] = field(init=False, compare=False)
    _stored: Mapping[str, Predicate] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        require_tuple("predicates", self.predicates, Predicate)
        require_tuple("derived predicates", self.derived, DerivedPredicate)
        names = [p.name for p in self.predicates] + [d.name for d in self.derived]
        for name in names:
            if names.count(name) > 1:
                raise DomainError(
                    f"predicate {name} is declared twice: give each predicate a name of its own"
                )
        for predicate in self.predicates:
            if predicate.arity < 0:
                raise DomainError(f"predicate {predicate.name}: arity {predicate.arity} is negative")
        for derived in self.derived:
            for read in derived.reads:
                if read not in names:
                    raise DomainError(
                        f"derived predicate {derived.name} reads {read}, which is not declared: declare it"
                    )
        for kind in self.parents:
            if kind in self.list_kind_with_ancestors(kind)[1:]:
                raise DomainError(f"parents: the kind {kind} contains itself: remove a parent from the cycle")
        for slots, arities in (("unary_slots", (0, 1)), ("binary_slots", (2,)), ("tuple_slots", (3,))):
            group = [p.name for p in self.predicates if min(p.arity, 3) in arities]
            object.__setattr__(self, slots, MappingProxyType({name: i for i, name in enumerate(group)}))
        object.__setattr__(self, "derived_by_name", MappingProxyType({d.name: d for d in self.derived}))
        object.__setattr__(self, "_stored", MappingProxyType({p.name: p for p in self.predicates}))

    def map_predicates_of_arity_to_state_slots(self, arity: int) -> Mapping[str, int]:
        """Return a mapping from stored predicates of an arity to their places (slots) in a state."""
        return self.unary_slots if arity < 2 else self.binary_slots if arity == 2 else self.tuple_slots

    def list_kind_with_ancestors(self, kind: str) -> tuple[str, ...]:
        """Return a kind of objects and all kinds that contain it, the nearest first."""
        kinds = [kind]
        while (parent := self.parents.get(kinds[-1])) is not None:
            kinds.append(parent)
            if parent in kinds[:-1]:
                break
        return tuple(kinds)

    def find_stored_predicate(self, name: str) -> Predicate | None:
        """Return the stored predicate with this name, or None if there is no such predicate."""
        return self._stored.get(name)

    def find_arity(self, name: str) -> int | None:
        """Return the arity of a stored or derived predicate, or None if the name is unknown."""
        predicate = self.find_stored_predicate(name) or self.derived_by_name.get(name)
        return None if predicate is None else predicate.arity

    def require_arity(self, name: str, number: int) -> None:
        """Check that a predicate exists and takes this number of arguments.

        Raises:
            DomainError: the predicate takes another number of arguments, or is not declared.
        """
        arity = self.find_arity(name)
        if arity is None:
            hint = did_you_mean(name, (*self._stored, *self.derived_by_name))
            raise DomainError(f"predicate {name} is not declared{hint}")
        if arity != number:
            raise DomainError(describe_wrong_arity(name, arity, "argument", number))


def require_tuple(location: str, values: object, kind: type | UnionType) -> None:
    """Check that a field of a declaration is a tuple, and that its values have a certain type.

    Args:
        location: name of the field, for the message.
        values: the value of the field.
        kind: the type, or a union of types.

    Raises:
        DomainError: the field is a single value, perhaps because of a forgotten comma, or a value has another
            type.
    """
    if isinstance(values, kind):
        raise DomainError(f"{location}: expected a tuple; write a tuple of one value with a comma, (x,)")
    expected = join_with_or([type_.__name__ for type_ in get_args(kind) or (kind,)])
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise DomainError(f"{location}: expected a tuple of {expected}, found {type(values).__name__}")
    value_by_type = {
        type(value): value for value in values
    }  # one value of each type is tested, as hundreds of values may have the same type
    for value in value_by_type.values():
        if not isinstance(value, kind):
            raise DomainError(f"{location}: expected {expected}, found {type(value).__name__}")


def make_parameter_names(arity: int) -> tuple[str, ...]:
    """Return names for a number of parameters: x, y and z; or x1, x2, ... for more than three."""
    return tuple("xyz"[:arity]) if arity <= len("xyz") else tuple([f"x{i}" for i in range(1, arity + 1)])


def make_atom(name: str, arity: int, terms: Sequence[Term | str]) -> Atom:
    """Return the atom of a predicate with these terms.

    Raises:
        DomainError: the number of terms differs from the arity.
    """
    if len(terms) != arity:
        raise DomainError(describe_wrong_arity(name, arity, "argument", len(terms)))
    return Atom(name, tuple([Constant(term) if isinstance(term, str) else term for term in terms]))
