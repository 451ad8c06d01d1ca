"""Domains, problems and operators as values.

Conditions are formulas (`eai.logic.formula`), with `Variable` for ``?x`` (the question mark belongs to the
syntax) and `Constant` for everything else. Effects are a type of their own, since an effect is an instruction
and not a proposition. Names are in lower case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import free_variables
from eai.world.effect import Add as Add
from eai.world.effect import Delete as Delete

OBJECT = "object"
"""The root of every type hierarchy."""


@dataclass(frozen=True, slots=True)
class Both:
    """All parts take place together; none is "no effect"."""

    parts: tuple[PddlEffect, ...]


@dataclass(frozen=True, slots=True)
class Each:
    """The part takes place for every object of the variable's type."""

    variable: f.Variable
    part: PddlEffect


@dataclass(frozen=True, slots=True)
class WhenEffect:
    """The part takes place if the condition held before."""

    condition: f.Formula
    part: PddlEffect


PddlEffect: TypeAlias = Add | Delete | Both | Each | WhenEffect
"""The effect of an action, all at once: an atom that one part adds becomes true even if one deletes it."""

NO_EFFECT = Both(())


@dataclass(frozen=True, slots=True)
class TypedName:
    """A type with its supertype, or an object with its type."""

    name: str
    type: str = OBJECT


@dataclass(frozen=True, slots=True)
class PddlPredicate:
    """A declared predicate with its typed parameters."""

    name: str
    parameters: tuple[f.Variable, ...]


@dataclass(frozen=True, slots=True)
class PddlAction:
    """An operator."""

    name: str
    parameters: tuple[f.Variable, ...]
    precondition: f.Formula
    effect: PddlEffect


@dataclass(frozen=True, slots=True)
class PddlAxiom:
    """A derived predicate: it holds of its parameters where the condition does."""

    name: str
    parameters: tuple[f.Variable, ...]
    condition: f.Formula

    def scope(self, objects: Sequence[str]) -> dict[str, str]:
        """The objects that it holds of, by the names of the parameters that they stand for."""
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
    """A planning problem. What ``initial`` does not list is false; ``denied`` are the atoms that say so."""

    name: str
    domain: str
    objects: tuple[TypedName, ...]
    initial: tuple[f.Atom, ...]
    denied: tuple[f.Atom, ...]
    goal: f.Formula


def type_of(variable: f.Variable) -> str:
    """The type that a variable ranges over; a variable without a type ranges over everything."""
    return variable.category or OBJECT


_EITHER = "(either "


def either(types: Iterable[str]) -> str:
    """The type of what is of any of some types, as PDDL writes it."""
    return f"{_EITHER}{' '.join(types)})"


def alternatives(name: str) -> tuple[str, ...]:
    """The types any of which a type stands for: itself, or those of ``(either ...)``."""
    return tuple(name[len(_EITHER) : -1].split()) if name.startswith(_EITHER) else (name,)


class _TypeMembers(dict[str, tuple[str, ...]]):
    """The objects of every declared type, and so of alternatives of these."""

    def __missing__(self, name: str) -> tuple[str, ...]:
        kinds = [self[each] for each in alternatives(name) if each in self]
        return tuple(dict.fromkeys([thing for kind in kinds for thing in kind]))


def parents(types: tuple[TypedName, ...]) -> dict[str, str]:
    """For each declared type the one right above it."""
    return {declared.name: declared.type for declared in types}


def supertypes(above: Mapping[str, str], name: str) -> list[str]:
    """The type itself and everything above it, nearest first; the root comes last and always."""
    found: list[str] = []
    while name != OBJECT and name not in found:
        found.append(name)
        name = above.get(name, OBJECT)
    return [*found, OBJECT]


def objects_by_type(domain: PddlDomain, problem: PddlProblem) -> Mapping[str, tuple[str, ...]]:
    """For every declared type its objects, constants first, in order of declaration."""
    above = parents(domain.types)
    members: dict[str, list[str]] = {name: [] for name in (OBJECT, *(item.name for item in domain.types))}
    for item in (*domain.constants, *problem.objects):
        for name in supertypes(above, item.type):
            members.setdefault(name, []).append(item.name)
    return _TypeMembers({name: tuple(dict.fromkeys(items)) for name, items in members.items()})


def effect_parts(
    effect: PddlEffect, conditions: tuple[f.Formula, ...] = ()
) -> Iterator[tuple[Add | Delete, tuple[f.Formula, ...]]]:
    """The parts of an effect that add and delete, left to right, and the conditions of each from outside."""
    match effect:
        case Add() | Delete():
            yield effect, conditions
        case Both(parts):
            for part in parts:
                yield from effect_parts(part, conditions)
        case Each(part=part):
            yield from effect_parts(part, conditions)
        case WhenEffect(condition, part):
            yield from effect_parts(part, (*conditions, condition))


def effect_atoms(effect: PddlEffect) -> Iterator[f.Atom]:
    """The atoms that an effect adds or deletes, left to right."""
    return (part.atom for part, _ in effect_parts(effect))


def effect_conditions(effect: PddlEffect) -> Iterator[f.Formula]:
    """The conditions of an effect's conditional parts, left to right, each as often as a part has it."""
    return (condition for _, conditions in effect_parts(effect) for condition in conditions)


def effect_variables(effect: PddlEffect) -> frozenset[str]:
    """The names of the variables of all that an effect adds and deletes, and of its conditions where free."""
    return frozenset[str]().union(*map(free_variables, (*effect_atoms(effect), *effect_conditions(effect))))


def map_effect_parts(
    effect: PddlEffect,
    change: Callable[[PddlEffect], PddlEffect],
    condition: Callable[[f.Formula], f.Formula],
) -> PddlEffect:
    """The effect with its immediate parts and its own condition replaced."""
    match effect:
        case Both(parts):
            return Both(tuple([change(part) for part in parts]))
        case Each(variable, part):
            return Each(variable, change(part))
        case WhenEffect(premise, part):
            return WhenEffect(condition(premise), change(part))
        case _:
            return effect


def map_effect(
    effect: PddlEffect, condition: Callable[[f.Formula], f.Formula], atom: Callable[[f.Atom], f.Atom]
) -> PddlEffect:
    """The effect with its conditions and its added and deleted atoms replaced."""
    if isinstance(effect, (Add, Delete)):
        return type(effect)(atom(effect.atom))
    return map_effect_parts(effect, lambda part: map_effect(part, condition, atom), condition)


@dataclass(frozen=True, slots=True)
class OperatorText:
    """An operator as an answer writes it, before anything is understood.

    It is the name and the text of its three parts, each a parenthesised list.
    """

    name: str
    parameters: str
    precondition: str
    effect: str

    @property
    def size(self) -> int:
        """How many characters its parts take."""
        return len(self.parameters) + len(self.precondition) + len(self.effect)

    @property
    def pddl(self) -> str:
        """The operator as a PDDL action."""
        return (
            f"(:action {self.name} :parameters {self.parameters} "
            f":precondition {self.precondition} :effect {self.effect})"
        )
