"""What a domain can say about its objects, and where states keep it: stored and derived predicates.

A stored predicate is part of every state. A derived predicate is computed from the stored ones, either by
a formula or, for the few that need arithmetic or a walk along a chain, by a pure function that names what it
reads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from eai.errors import DomainError
from eai.logic.formula import Atom, Equals, Exists, Formula, Or, Term, Variable

if TYPE_CHECKING:
    from eai.world.state import State


@dataclass(frozen=True, slots=True)
class Predicate:
    """A stored predicate of arity 0, 1 or 2. Calling it with terms makes an atom.

    ``static`` says that no operator changes it. ``visible`` is False for memory that the simulator needs but
    that no prompt, goal or answer may mention. ``single`` says that in every state that can be reached at
    most one object makes it true as last argument, whatever the others: so "the first" such object is it.
    """

    name: str
    arity: int
    static: bool = False
    visible: bool = True
    single: bool = False

    def __call__(self, *terms: Term) -> Atom:
        """The atom of this predicate with these terms."""
        return _atom(self.name, self.arity, terms)


@dataclass(frozen=True, slots=True)
class Defined:
    """A derived predicate given by a formula over its parameters.

    ``values``, where there is one, is a faster way to the same: a pure function from all arguments but the
    last to the mask of the objects that make the predicate true as last argument.
    """

    name: str
    parameters: tuple[Variable, ...]
    definition: Formula
    values: Callable[[State, tuple[int, ...]], int] | None = None

    @property
    def arity(self) -> int:
        """The number of parameters."""
        return len(self.parameters)

    def __call__(self, *terms: Term) -> Atom:
        """The atom of this predicate with these terms."""
        return _atom(self.name, self.arity, terms)


@dataclass(frozen=True, slots=True)
class Computed:
    """A derived predicate given by a pure test of a state and object indices.

    ``meaning``, where there is one, says the same as a formula, for syntaxes that have no functions.
    """

    name: str
    arity: int
    test: Callable[[State, tuple[int, ...]], bool]
    reads: tuple[str, ...]
    meaning: Defined | None = None

    def __call__(self, *terms: Term) -> Atom:
        """The atom of this predicate with these terms."""
        return _atom(self.name, self.arity, terms)


@dataclass(frozen=True, slots=True)
class Lookup:
    """A derived predicate whose last argument is looked up: a pure function from the others to a mask.

    ``values(state, arguments)`` is the mask of all objects that make the predicate true as last argument.
    ``meaning``, where there is one, says the same as a formula, for syntaxes that have no functions;
    ``single`` says that the mask never has more than one object; ``open_in_meaning``, what the formula leaves
    open, in words.
    """

    name: str
    arity: int
    values: Callable[[State, tuple[int, ...]], int]
    reads: tuple[str, ...]
    meaning: Defined | None = None
    single: bool = False
    open_in_meaning: str = ""

    def __call__(self, *terms: Term) -> Atom:
        """The atom of this predicate with these terms."""
        return _atom(self.name, self.arity, terms)


Derived: TypeAlias = Defined | Computed | Lookup


def is_a(term: Term, *categories: str) -> Formula:
    """The object belongs to one of the categories."""
    member = Variable("member")
    memberships = tuple(Exists(Variable(member.name, c), Equals(member, term)) for c in categories)
    return memberships[0] if len(memberships) == 1 else Or(memberships)


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """The predicates of a domain and the slot in which a state keeps each stored one.

    Predicates of arity 0 and 1 share one numbering, those of arity 2 have another. ``evaluated_as`` gives for
    each derived predicate the form in which it is evaluated: that with a function where it has one.

    Raises:
        DomainError: two predicates have one name, an arity is above 2, or a derived one reads the unknown.
    """

    predicates: tuple[Predicate, ...]
    derived: tuple[Derived, ...] = ()
    unary_slots: dict[str, int] = field(init=False, compare=False)
    binary_slots: dict[str, int] = field(init=False, compare=False)
    derived_by_name: dict[str, Derived] = field(init=False, compare=False)
    evaluated_as: dict[str, Derived] = field(init=False, compare=False, repr=False)
    _stored: dict[str, Predicate] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        names = [p.name for p in (*self.predicates, *self.derived)]
        for name in names:
            if names.count(name) > 1:
                raise DomainError(f"predicate {name} is declared twice")
        for predicate in self.predicates:
            if not 0 <= predicate.arity <= 2:
                raise DomainError(f"predicate {predicate.name}: arity {predicate.arity} is not 0, 1 or 2")
        for derived in self.derived:
            for read in () if isinstance(derived, Defined) else derived.reads:
                if read not in names:
                    raise DomainError(f"derived predicate {derived.name} reads {read}, which is not declared")
        small = [p.name for p in self.predicates if p.arity < 2]
        large = [p.name for p in self.predicates if p.arity == 2]
        object.__setattr__(self, "unary_slots", {name: i for i, name in enumerate(small)})
        object.__setattr__(self, "binary_slots", {name: i for i, name in enumerate(large)})
        object.__setattr__(self, "derived_by_name", {d.name: d for d in self.derived})
        object.__setattr__(self, "evaluated_as", {d.name: _evaluated(d) for d in self.derived})
        object.__setattr__(self, "_stored", {p.name: p for p in self.predicates})

    def stored(self, name: str) -> Predicate | None:
        """The stored predicate of this name, or None."""
        return self._stored.get(name)

    def arity(self, name: str) -> int | None:
        """The arity of a stored or derived predicate, or None if there is none of this name."""
        found = self.stored(name) or self.derived_by_name.get(name)
        return None if found is None else found.arity


def _evaluated(derived: Derived) -> Derived:
    if isinstance(derived, Defined) and derived.values is not None:
        return Lookup(derived.name, derived.arity, derived.values, ())
    return derived


def _atom(name: str, arity: int, terms: Sequence[Term]) -> Atom:
    if len(terms) != arity:
        raise DomainError(f"{name} takes {arity} arguments, not {len(terms)}")
    return Atom(name, tuple(terms))
