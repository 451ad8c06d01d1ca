"""Derived predicates: predicates that are computed from a state's stored predicates.

Most are defined by a formula. Predicates that need arithmetic, or a walk along a chain of objects, are pure
functions that list the predicates that they read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import find_predicates
from eai.world.relation import ObjectMask
from eai.world.state import State
from eai.world.vocabulary import DerivedPredicate, Vocabulary, make_atom

LookupFunction: TypeAlias = Callable[[State, tuple[int, ...]], ObjectMask]
"""Function of a state and all arguments of a predicate but the last.

It returns the bit mask of the objects that make the predicate true as last argument.
"""

TestFunction: TypeAlias = Callable[[State, tuple[int, ...]], bool]
"""Function that tests whether a predicate holds in a state for given objects."""


@dataclass(frozen=True, slots=True)
class DefinedPredicate:
    """A derived predicate that a formula over its parameters defines.

    Attributes:
        name: the name.
        parameters: the variables that stand for the arguments in the formula.
        definition: the formula.
        values: an optional faster equivalent of the formula: a pure function of a state and all arguments but
            the last. It returns the mask of the objects that make the predicate true as last argument.
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
        """Empty, because this predicate is defined by a formula, not by a function that reads predicates."""
        return ()

    def __call__(self, *terms: f.Term | str) -> f.Atom:
        """Return the atom of this predicate with these terms."""
        return make_atom(self.name, self.arity, terms)


@dataclass(frozen=True, slots=True)
class ComputedPredicate:
    """A derived predicate whose truth a pure function computes from a state and object indices.

    Attributes:
        name: the name.
        arity: the number of arguments.
        test: the function.
        reads: the predicates that the function reads.
        meaning: an optional equivalent definition by a formula, for PDDL and other uses that need a formula.
    """

    name: str
    arity: int
    test: TestFunction
    reads: tuple[str, ...]
    meaning: DefinedPredicate | None = None

    def __call__(self, *terms: f.Term | str) -> f.Atom:
        """Return the atom of this predicate with these terms."""
        return make_atom(self.name, self.arity, terms)


@dataclass(frozen=True, slots=True)
class LookupPredicate:
    """A derived predicate with a pure function that finds the last argument from the other arguments.

    Attributes:
        name: the name.
        arity: the number of arguments.
        values: ``values(state, arguments)`` is the mask of all objects that make the predicate true as last
            argument.
        reads: the predicates that the function reads.
        meaning: an optional definition by a formula, for PDDL and other uses that need a formula.
        single: whether the mask never has more than one object.
        open_in_meaning: description of a choice that ``meaning`` does not determine, such as ``which of
            several objects is the first``. Exported PDDL and printed rules contain it. Empty if there is no
            such choice.
        inverse: for two arguments, an optional function that returns the mask of all objects that make the
            predicate true as first argument, given the last.
    """

    name: str
    arity: int
    values: LookupFunction
    reads: tuple[str, ...]
    meaning: DefinedPredicate | None = None
    single: bool = False
    open_in_meaning: str = ""
    inverse: LookupFunction | None = None

    def __call__(self, *terms: f.Term | str) -> f.Atom:
        """Return the atom of this predicate with these terms."""
        return make_atom(self.name, self.arity, terms)


def is_a(term: f.Term, *categories: str) -> f.Formula:
    """Return a formula that holds if the object of a term belongs to one of the categories."""
    member = f.Variable("member")
    memberships = tuple(f.Exists(f.Variable(member.name, c), f.Equals(member, term)) for c in categories)
    return memberships[0] if len(memberships) == 1 else f.Or(memberships)


def replace_formula_by_faster_function(derived: DerivedPredicate) -> DerivedPredicate:
    """Return the form of a derived predicate that is evaluated fastest.

    A formula with an equivalent function (`DefinedPredicate.values`) is replaced by the function.
    """
    if isinstance(derived, DefinedPredicate) and derived.values is not None:
        return LookupPredicate(derived.name, derived.arity, derived.values, ())
    return derived


def find_definition(derived: DerivedPredicate) -> DefinedPredicate | None:
    """Return a definition of a predicate by a formula, or None if the predicate declares none."""
    match derived:
        case DefinedPredicate():
            return derived
        case ComputedPredicate() | LookupPredicate():
            return derived.meaning
        case _:
            return None


def find_stored_dependencies(predicates: Iterable[str], vocabulary: Vocabulary) -> list[str]:
    """Return the stored predicates on which given predicates depend, directly or not, each once."""
    reached = list(dict.fromkeys(predicates))
    for name in reached:  # the list grows during the loop, which then visits the appended predicates, too
        derived = vocabulary.derived_by_name.get(name)
        if derived is not None:
            read = (
                find_predicates(derived.definition)
                if isinstance(derived, DefinedPredicate)
                else derived.reads
            )
            reached += [other for other in dict.fromkeys(read) if other not in reached]
    return [name for name in reached if name not in vocabulary.derived_by_name]
