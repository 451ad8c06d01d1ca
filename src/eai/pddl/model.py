"""Domains, problems and operators of PDDL as values.

Conditions are formulas (`eai.logic.formula`). The variable ``?x`` is a `Variable` with the name ``x``, and
every other term is a `Constant`. Effects have their own types, since an effect is an instruction, not a
proposition. Names are in lower case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import find_free_variables
from eai.world.effect import Add as Add
from eai.world.effect import Delete as Delete

OBJECT = "object"
"""Name of the type at the root of every type hierarchy."""


@dataclass(frozen=True, slots=True)
class AndEffect:
    """An effect whose parts take place together; without parts it has no effect."""

    parts: tuple[PddlEffect, ...]


@dataclass(frozen=True, slots=True)
class ForAllEffect:
    """An effect that takes place for every object of the variable's type."""

    variable: f.Variable
    part: PddlEffect


@dataclass(frozen=True, slots=True)
class WhenEffect:
    """An effect that takes place if a condition holds in the state before the action."""

    condition: f.Formula
    part: PddlEffect


PddlEffect: TypeAlias = Add | Delete | AndEffect | ForAllEffect | WhenEffect
"""An effect of an action, whose parts take place at once.

An atom that is both added and deleted becomes true.
"""

NO_EFFECT = AndEffect(())


@dataclass(frozen=True, slots=True)
class TypedName:
    """A named type with its supertype, or a named object with its type."""

    name: str
    type: str = OBJECT


@dataclass(frozen=True, slots=True)
class PddlPredicate:
    """A declared predicate with its typed parameters."""

    name: str
    parameters: tuple[f.Variable, ...]


@dataclass(frozen=True, slots=True)
class PddlAction:
    """An operator of PDDL: its name, parameters, precondition and effect."""

    name: str
    parameters: tuple[f.Variable, ...]
    precondition: f.Formula
    effect: PddlEffect


@dataclass(frozen=True, slots=True)
class PddlAxiom:
    """A derived predicate: it holds for its parameters if its condition holds for these."""

    name: str
    parameters: tuple[f.Variable, ...]
    condition: f.Formula

    def map_parameters(self, objects: Sequence[str]) -> dict[str, str]:
        """Return a mapping from the name of each parameter to its object."""
        return {p.name: thing for p, thing in zip(self.parameters, objects, strict=True)}


@dataclass(frozen=True, slots=True)
class PddlDomain:
    """A planning domain. Declarations keep the order of the text.

    The names of derived predicates are declared among the predicates too.
    """

    name: str
    requirements: tuple[str, ...]
    types: tuple[TypedName, ...]
    constants: tuple[TypedName, ...]
    predicates: tuple[PddlPredicate, ...]
    actions: tuple[PddlAction, ...]
    axioms: tuple[PddlAxiom, ...] = ()


@dataclass(frozen=True, slots=True)
class PddlProblem:
    """A planning problem.

    Atoms outside ``initial`` are false; ``denied`` lists atoms that the text calls false.
    """

    name: str
    domain: str
    objects: tuple[TypedName, ...]
    initial: tuple[f.Atom, ...]
    denied: tuple[f.Atom, ...]
    goal: f.Formula


def get_variable_type(variable: f.Variable) -> str:
    """Return the type that a variable ranges over; the root type if it has no type."""
    return variable.category or OBJECT


_EITHER = "(either "


def write_either_type(types: Iterable[str]) -> str:
    """Return the PDDL text of a type with several alternatives."""
    return f"{_EITHER}{' '.join(types)})"


def list_alternatives_of_either_type(type_text: str) -> tuple[str, ...]:
    """Return the alternatives of a type ``(either ...)``, or the type itself."""
    return tuple(type_text[len(_EITHER) : -1].split()) if type_text.startswith(_EITHER) else (type_text,)


class _ObjectsByType(dict[str, tuple[str, ...]]):
    """Mapping from each declared type, and from each ``either`` of types, to its objects."""

    def __missing__(self, name: str) -> tuple[str, ...]:
        kinds = [
            self[alternative] for alternative in list_alternatives_of_either_type(name) if alternative in self
        ]
        return tuple(dict.fromkeys([thing for kind in kinds for thing in kind]))


def map_types_to_parents(types: tuple[TypedName, ...]) -> dict[str, str]:
    """Return a mapping from each declared type to its direct supertype."""
    return {declared.name: declared.type for declared in types}


def list_supertypes(parent_by_type: Mapping[str, str], type_name: str) -> list[str]:
    """Return a type and all its supertypes, nearest first. The root is always last."""
    types: list[str] = []
    while type_name != OBJECT and type_name not in types:
        types.append(type_name)
        type_name = parent_by_type.get(type_name, OBJECT)
    return [*types, OBJECT]


def group_objects_by_type(domain: PddlDomain, problem: PddlProblem) -> Mapping[str, tuple[str, ...]]:
    """Return a mapping from each declared type to its objects, constants first, in order of declaration."""
    above = map_types_to_parents(domain.types)
    members: dict[str, list[str]] = {name: [] for name in (OBJECT, *(item.name for item in domain.types))}
    for item in (*domain.constants, *problem.objects):
        for name in list_supertypes(above, item.type):
            members.setdefault(name, []).append(item.name)
    return _ObjectsByType({name: tuple(dict.fromkeys(items)) for name, items in members.items()})


def split_effect(
    effect: PddlEffect, conditions: tuple[f.Formula, ...] = ()
) -> Iterator[tuple[Add | Delete, tuple[f.Formula, ...]]]:
    """Yield the additions and deletions of an effect, left to right, each with its conditions.

    Conditions come in the order of the enclosing effects, outermost first.
    """
    match effect:
        case Add() | Delete():
            yield effect, conditions
        case AndEffect(parts):
            for part in parts:
                yield from split_effect(part, conditions)
        case ForAllEffect(part=part):
            yield from split_effect(part, conditions)
        case WhenEffect(condition, part):
            yield from split_effect(part, (*conditions, condition))


def find_effect_atoms(effect: PddlEffect) -> Iterator[f.Atom]:
    """Yield the atoms that an effect adds or deletes, left to right."""
    return (part.atom for part, _ in split_effect(effect))


def find_effect_conditions(effect: PddlEffect) -> Iterator[f.Formula]:
    """Yield the condition of each conditional part of an effect, left to right.

    A condition is repeated for each addition and deletion that depends on it.
    """
    return (condition for _, conditions in split_effect(effect) for condition in conditions)


def find_effect_variables(effect: PddlEffect) -> frozenset[str]:
    """Return the names of the variables in an effect's atoms, and of the free variables of its conditions."""
    match effect:
        case Add(atom) | Delete(atom):
            return find_free_variables(atom)
        case WhenEffect(condition, part):
            return find_effect_variables(part) | find_free_variables(condition)
        case ForAllEffect(part=part):
            return find_effect_variables(part)
        case AndEffect(parts):
            return frozenset[str]().union(*map(find_effect_variables, parts))


def map_effect_parts(
    effect: PddlEffect,
    change_part: Callable[[PddlEffect], PddlEffect],
    change_condition: Callable[[f.Formula], f.Formula],
) -> PddlEffect:
    """Return an effect with functions applied to its immediate parts and to its own condition."""
    match effect:
        case AndEffect(parts):
            return AndEffect(tuple([change_part(part) for part in parts]))
        case ForAllEffect(variable, part):
            return ForAllEffect(variable, change_part(part))
        case WhenEffect(premise, part):
            return WhenEffect(change_condition(premise), change_part(part))
        case _:
            return effect


def map_effect(
    effect: PddlEffect,
    change_condition: Callable[[f.Formula], f.Formula],
    change_atom: Callable[[f.Atom], f.Atom],
) -> PddlEffect:
    """Return an effect with functions applied to its conditions and to its added and deleted atoms."""
    if isinstance(effect, (Add, Delete)):
        return type(effect)(change_atom(effect.atom))
    return map_effect_parts(
        effect, lambda part: map_effect(part, change_condition, change_atom), change_condition
    )


@dataclass(frozen=True, slots=True)
class OperatorText:
    """An operator as text: its name, and the unparsed texts of its parts.

    The parts are the parameters, the precondition and the effect, each a parenthesised list.
    """

    name: str
    parameters: str
    precondition: str
    effect: str

    @property
    def text_length(self) -> int:
        """The number of characters in the texts of parameters, precondition and effect together."""
        return len(self.parameters) + len(self.precondition) + len(self.effect)

    @property
    def write_pddl(self) -> str:
        """The operator as a PDDL action."""
        return (
            f"(:action {self.name} :parameters {self.parameters} "
            f":precondition {self.precondition} :effect {self.effect})"
        )
