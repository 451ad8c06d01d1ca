"""Effect schemas: the additions and deletions in the effects of operators, each with its conditions.

`find_changes_for_literal` returns the changes of stored facts that may make a literal true. Effect schemas
show which operators make these changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, TypeAlias, TypeVar

import eai.logic.formula as f
from eai.logic.traversal import get_subformulas
from eai.planning.subgoal import GroundAtom
from eai.world.derived import find_definition
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.operator import Operator
from eai.world.vocabulary import Vocabulary

_NO_ATOM = f.Atom("")

_Object = TypeVar("_Object")
"""Type variable for objects: an object is given by its index or its name."""

FindObject: TypeAlias = "Callable[[f.Constant], int | None]"
"""Function that returns the number of the object that a constant names, or None if it may be any object."""


class EffectSchema(NamedTuple):
    """An addition or deletion in the effects of an operator.

    Attributes:
        operator: the operator.
        adds: True if the effect makes the atom true, False if it makes the atom false.
        atom: the atom. Its variables are parameters of the operator, or variables of enclosing effects.
        variables: the operator's parameters, then the variables of the enclosing effects.
        checks: the conditions of the operator's checks.
        conditions: the conditions of the enclosing effects.
        read_variables: the variables whose values are determined by the state before the action, not by its
            arguments.
    """

    operator: Operator
    adds: bool
    atom: f.Atom
    variables: tuple[str, ...]
    checks: tuple[f.Formula, ...]
    conditions: tuple[f.Formula, ...] = ()
    read_variables: frozenset[str] = frozenset()


def make_schema_without_effect(operator: Operator) -> EffectSchema:
    """Return a schema that stands for the execution of an operator and has no fact as its effect.

    Its only condition is that the operator's checks pass. It serves for goals to execute the operator, and as
    a template for the operator's other schemas.
    """
    names = tuple(p.name for p in operator.parameters)
    return EffectSchema(operator, True, _NO_ATOM, names, tuple(check.condition for check in operator.checks))


def make_effect_schemas(operator: Operator) -> Iterator[EffectSchema]:
    """Yield the schemas of an operator's additions and deletions, in the order in which they are written."""
    operator_schema = make_schema_without_effect(operator)
    yield from _make_nested_schemas(operator.effects, operator_schema)
    for attempt in operator.alternatives:
        yield from _make_nested_schemas(
            attempt.effects, operator_schema._replace(checks=(*operator_schema.checks, *attempt.conditions))
        )


def find_predicates_changed_by_effects(effects: Iterable[Effect]) -> Iterator[str]:
    """Yield the predicates that effects change, including effects that `make_effect_schemas` leaves out."""
    for effect in effects:
        match effect:
            case Add(atom) | Delete(atom):
                yield atom.predicate
            case When(_, inner, otherwise):
                yield from find_predicates_changed_by_effects((*inner, *otherwise))
            case ForEach(_, _, inner) | Let(_, _, inner):
                yield from find_predicates_changed_by_effects(inner)


def find_changed_predicates(operator: Operator) -> list[str]:
    """Return the predicates that an operator changes, one entry for each addition or deletion.

    The effects of the operator's alternatives are included.
    """
    return [
        name
        for effects in (operator.effects, *(t.effects for t in operator.alternatives))
        for name in find_predicates_changed_by_effects(effects)
    ]


def find_predicates_with_incomplete_schemas(operator: Operator) -> frozenset[str]:
    """Return the predicates that an operator changes if its effect schemas are incomplete, else an empty set.

    `make_effect_schemas` leaves out an effect whose variable has the name of an outer variable. The schemas
    are then incomplete.
    """
    changed = find_changed_predicates(operator)
    return frozenset(changed if len(changed) > len([*make_effect_schemas(operator)]) else ())


def _make_nested_schemas(effects: Iterable[Effect], outer: EffectSchema) -> Iterator[EffectSchema]:
    """Yield the schemas of effects inside other effects; ``outer`` is a schema of the enclosing effects."""
    for effect in effects:
        match effect:
            case Add(atom) | Delete(atom):
                yield outer._replace(atom=atom, adds=isinstance(effect, Add))
            case When(condition, inner, otherwise):
                yield from _make_nested_schemas(inner, _add_condition_to_schema(outer, condition))
                yield from _make_nested_schemas(otherwise, _add_condition_to_schema(outer, f.Not(condition)))
            case ForEach(variable, condition, inner) | Let(variable, condition, inner):
                # An effect whose variable has the name of an outer variable is left out.
                if variable.name not in outer.variables:
                    wider = outer._replace(variables=(*outer.variables, variable.name))
                    if isinstance(effect, Let):
                        checks = tuple(
                            _specialize_check_to_one_object(c, variable, condition) for c in outer.checks
                        )
                        wider = wider._replace(
                            checks=checks, read_variables=wider.read_variables | {variable.name}
                        )
                    yield from _make_nested_schemas(inner, _add_condition_to_schema(wider, condition))


def match_atom(
    atom: f.Atom,
    arguments: Sequence[_Object | None],
    find_object: Callable[[f.Constant], _Object | None],
    bound: Mapping[str, _Object] = MappingProxyType({}),
) -> dict[str, _Object] | None:
    """Return a mapping from variables to objects that gives an effect's atom these arguments, or None.

    Args:
        atom: the atom of the effect.
        arguments: objects; None for any object.
        find_object: function that returns the object that a constant names, or None if it may be any object.
        bound: mapping from variables to objects that are fixed beforehand.
    """
    scope = {**bound}
    for term, argument in zip(atom.arguments, arguments, strict=True):
        if argument is None or term == ANYTHING:
            continue
        if isinstance(term, f.Variable):
            if scope.setdefault(term.name, argument) != argument:
                return None
        elif find_object(term) not in (None, argument):
            return None
    return scope


def _add_condition_to_schema(outer: EffectSchema, condition: f.Formula) -> EffectSchema:
    return outer._replace(conditions=(*outer.conditions, condition))


def _specialize_check_to_one_object(
    check: f.Formula, object_variable: f.Variable, object_condition: f.Formula
) -> f.Formula:
    """Turn a check about all objects that meet ``object_condition`` into a check about one such object.

    The object is the value of ``object_variable``.

    For example, the operator puts an object into the hand. The check "the object in the hand is not too big"
    becomes "this object is not too big".
    """
    match check:
        case f.Atom(predicate, arguments) if (
            isinstance(object_condition, f.Atom) and object_condition.predicate == predicate
        ):
            same = zip(arguments, object_condition.arguments, strict=True)
            return f.Or((check, _conjoin([f.Equals(one, other) for one, other in same])))
        case f.Exists(quantified, body) if quantified == object_variable:
            parts = f.get_operands(body, f.And)
            if object_condition in parts:
                return _conjoin([part for part in parts if part != object_condition])
            return check
        case f.Not(operand):
            inner = _specialize_check_to_one_object(operand, object_variable, object_condition)
            return f.FALSE if inner == f.TRUE else f.TRUE if inner == f.FALSE else f.Not(inner)
        case f.And(operands) | f.Or(operands):
            return type(check)(
                tuple(
                    _specialize_check_to_one_object(part, object_variable, object_condition)
                    for part in operands
                )
            )
        case _:
            return check


def _conjoin(parts: Sequence[f.Formula]) -> f.Formula:
    return parts[0] if len(parts) == 1 else f.And(tuple(parts))


class FactChange(NamedTuple):
    """A change of a fact of a stored predicate, which becomes true or false.

    An argument that is None stands for any object.
    """

    predicate: str
    arguments: tuple[int | None, ...]
    truth: bool


def find_changes_for_literal(
    literal: GroundAtom, vocabulary: Vocabulary, find_object: FindObject
) -> list[FactChange]:
    """Return the changes of stored facts that may make a literal true, by the definition of its predicate.

    The caller may number objects in any way. Variables that quantifiers in a definition bind stand for any
    object. If a function computes the literal's predicate, the result has every possible change of the
    predicates that the function reads.

    Args:
        literal: the literal.
        vocabulary: the vocabulary that declares the literal's predicate.
        find_object: function that returns the number of the object that a constant names, or None if it may
            be any object.
    """
    return _replace_derived_changes_by_stored_changes([FactChange(*literal)], vocabulary, find_object)


def find_changes_towards(
    formula: f.Formula,
    scope: Mapping[str, int | None],
    truth: bool,
    vocabulary: Vocabulary,
    find_object: FindObject,
) -> list[FactChange]:
    """Return the changes of stored facts that may make a condition true, or false if ``truth`` is False.

    A variable that ``scope`` maps to None may be any object. A derived predicate is replaced by the stored
    predicates that define it.
    """
    return _replace_derived_changes_by_stored_changes(
        list(_find_atom_changes_towards_truth(formula, scope, truth, find_object)), vocabulary, find_object
    )


def _replace_derived_changes_by_stored_changes(
    pending: list[FactChange], vocabulary: Vocabulary, find_object: FindObject
) -> list[FactChange]:
    """Replace changes of derived predicates by the changes of stored predicates that may cause them."""
    seen: dict[FactChange, None] = {}
    changes: list[FactChange] = []
    while pending:
        change = pending.pop()
        if change in seen:
            continue
        seen[change] = None
        derived = vocabulary.derived_by_name.get(change.predicate)
        if derived is None:
            changes.append(change)
            continue
        definition = find_definition(derived)
        if definition is not None:
            scope = dict(zip([p.name for p in definition.parameters], change.arguments, strict=True))
            pending += _find_atom_changes_towards_truth(
                definition.definition, scope, change.truth, find_object
            )
        else:
            for name in derived.reads:
                anything = (None,) * (vocabulary.find_arity(name) or 0)
                pending += [FactChange(name, anything, truth) for truth in (True, False)]
    return changes


def _find_atom_changes_towards_truth(
    formula: f.Formula, scope: Mapping[str, int | None], wanted_truth: bool, find_object: FindObject
) -> Iterator[FactChange]:
    """Yield each atom of a formula with the truth value that helps the formula to get ``wanted_truth``."""
    match formula:
        case f.Atom(predicate, terms):
            arguments = [scope.get(t.name) if isinstance(t, f.Variable) else find_object(t) for t in terms]
            yield FactChange(predicate, tuple(arguments), wanted_truth)
        case f.Not(operand):
            yield from _find_atom_changes_towards_truth(operand, scope, not wanted_truth, find_object)
        case f.Implies(premise, conclusion):
            yield from _find_atom_changes_towards_truth(premise, scope, not wanted_truth, find_object)
            yield from _find_atom_changes_towards_truth(conclusion, scope, wanted_truth, find_object)
        case f.Exactly() | f.ForPairs():
            for part in get_subformulas(formula):
                yield from _find_atom_changes_towards_truth(part, {}, True, find_object)
                yield from _find_atom_changes_towards_truth(part, {}, False, find_object)
        case f.ForAll(variable, body) | f.Exists(variable, body):
            inner = {name: value for name, value in scope.items() if name != variable.name}
            yield from _find_atom_changes_towards_truth(body, inner, wanted_truth, find_object)
        case _:
            for part in get_subformulas(formula):
                yield from _find_atom_changes_towards_truth(part, scope, wanted_truth, find_object)
