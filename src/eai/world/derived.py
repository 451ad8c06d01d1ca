"""Derived predicates: computed from the stored ones of a state.

Most are given by a formula; the few that need arithmetic or a walk along a chain, by a pure function that
names what it reads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import predicates_of
from eai.world.state import State
from eai.world.vocabulary import DerivedPredicate, Vocabulary, make_atom

LookupFunction: TypeAlias = Callable[[State, tuple[int, ...]], int]
"""Gives the mask of the objects that make a predicate true as last argument, from the other arguments."""

TestFunction: TypeAlias = Callable[[State, tuple[int, ...]], bool]
"""Whether a predicate holds of objects in a state."""


@dataclass(frozen=True, slots=True)
class Defined:
    """A derived predicate given by a formula over its parameters.

    ``values``, where there is one, is a faster way to the same: a pure function from all arguments but the
    last to the mask of the objects that make the predicate true as last argument.
    """

    name: str
    parameters: tuple[f.Variable, ...]
    definition: f.Formula
    values: LookupFunction | None = None

    @property
    def arity(self) -> int:
        """The number of parameters."""
        return len(self.parameters)

    @property
    def reads(self) -> tuple[str, ...]:
        """Nothing beyond what its formula says."""
        return ()

    def __call__(self, *terms: f.Term | str) -> f.Atom:
        """The atom of this predicate with these terms."""
        return make_atom(self.name, self.arity, terms)


@dataclass(frozen=True, slots=True)
class Computed:
    """A derived predicate given by a pure test of a state and object indices.

    ``meaning``, where there is one, says the same as a formula, for syntaxes that have no functions.
    """

    name: str
    arity: int
    test: TestFunction
    reads: tuple[str, ...]
    meaning: Defined | None = None

    def __call__(self, *terms: f.Term | str) -> f.Atom:
        """The atom of this predicate with these terms."""
        return make_atom(self.name, self.arity, terms)


@dataclass(frozen=True, slots=True)
class Lookup:
    """A derived predicate whose last argument is looked up: a pure function from the others to a mask.

    ``values(state, arguments)`` is the mask of all objects that make the predicate true as last argument.
    ``meaning``, where there is one, says the same as a formula, for syntaxes that have no functions;
    ``single`` says that the mask never has more than one object; ``open_in_meaning``, what the formula leaves
    open, in words. ``inverse``, where there is one, of two arguments, is the mask of all objects that make
    the predicate true as first argument, from the last.
    """

    name: str
    arity: int
    values: LookupFunction
    reads: tuple[str, ...]
    meaning: Defined | None = None
    single: bool = False
    open_in_meaning: str = ""
    inverse: LookupFunction | None = None

    def __call__(self, *terms: f.Term | str) -> f.Atom:
        """The atom of this predicate with these terms."""
        return make_atom(self.name, self.arity, terms)


def is_a(term: f.Term, *categories: str) -> f.Formula:
    """The object belongs to one of the categories."""
    member = f.Variable("member")
    memberships = tuple(f.Exists(f.Variable(member.name, c), f.Equals(member, term)) for c in categories)
    return memberships[0] if len(memberships) == 1 else f.Or(memberships)


def to_evaluated_form(derived: DerivedPredicate) -> DerivedPredicate:
    """The form in which a derived predicate is evaluated: that with a function where it has one."""
    if isinstance(derived, Defined) and derived.values is not None:
        return Lookup(derived.name, derived.arity, derived.values, ())
    return derived


def find_definition(derived: DerivedPredicate) -> Defined | None:
    """The definition by a formula that says the same as a derived predicate, if there is one."""
    match derived:
        case Defined():
            return derived
        case Computed() | Lookup():
            return derived.meaning
        case _:
            return None


def find_stored_predicates(predicates: Iterable[str], vocabulary: Vocabulary) -> list[str]:
    """The stored predicates that predicates come down to, each once."""
    reached = list(dict.fromkeys(predicates))
    for name in reached:  # which grows
        derived = vocabulary.derived_by_name.get(name)
        if derived is not None:
            read = predicates_of(derived.definition) if isinstance(derived, Defined) else derived.reads
            reached += [each for each in dict.fromkeys(read) if each not in reached]
    return [name for name in reached if name not in vocabulary.derived_by_name]
