"""Effect schemas: what operators add and delete, each with all that must hold for it to happen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import eai.logic.formula as f
from eai.world.effect import Add, Delete, Effect, ForEach, Let, When
from eai.world.operator import Operator

_NO_ATOM = f.Atom("")


class EffectSchema(NamedTuple):
    """One addition or deletion in the effects of an operator.

    Attributes:
        operator: the operator.
        adds: whether it makes the atom true; otherwise it makes it false.
        atom: its variables are parameters of the operator or bound by the effects around it.
        variables: the operator's parameters, then the variables of the effects around this one.
        checks: what the operator checks.
        given: what the effects around this one ask for.
    """

    operator: Operator
    adds: bool
    atom: f.Atom
    variables: tuple[str, ...]
    checks: tuple[f.Formula, ...]
    given: tuple[f.Formula, ...] = ()


def taking(operator: Operator) -> EffectSchema:
    """The operator as it is taken for its own sake, whatever it changes."""
    names = tuple(p.name for p in operator.parameters)
    return EffectSchema(operator, True, _NO_ATOM, names, tuple(check.condition for check in operator.checks))


def effect_schemas(operator: Operator) -> Iterator[EffectSchema]:
    """All additions and deletions of an operator, in the order in which they are written."""
    taken = taking(operator)
    yield from _schemas(operator.effects, taken)
    for each in operator.tries:
        own = (each.condition, *(check.condition for check in each.checks))
        yield from _schemas(each.effects, taken._replace(checks=(*taken.checks, *own)))


def written(effects: Iterable[Effect]) -> Iterator[str]:
    """The predicates that effects change, also those that `effect_schemas` leaves out."""
    for effect in effects:
        match effect:
            case Add(atom) | Delete(atom):
                yield atom.predicate
            case When(_, inner, otherwise):
                yield from written((*inner, *otherwise))
            case ForEach(_, _, inner) | Let(_, _, inner):
                yield from written(inner)


def _schemas(effects: Iterable[Effect], around: EffectSchema) -> Iterator[EffectSchema]:
    """The additions and deletions that effects make where all that is ``around`` them holds."""
    for effect in effects:
        match effect:
            case Add(atom) | Delete(atom):
                yield around._replace(atom=atom, adds=isinstance(effect, Add))
            case When(condition, inner, otherwise):
                yield from _schemas(inner, _given(around, condition))
                yield from _schemas(otherwise, _given(around, f.Not(condition)))
            case ForEach(variable, condition, inner) | Let(variable, condition, inner):
                # Where the variable hides another one, the effect is left out: estimates can do without it.
                if variable.name not in around.variables:
                    wider = around._replace(variables=(*around.variables, variable.name))
                    if isinstance(effect, Let):
                        checks = tuple(_of_this_one(c, variable, condition) for c in around.checks)
                        wider = wider._replace(checks=checks)
                    yield from _schemas(inner, _given(wider, condition))


def _given(around: EffectSchema, condition: f.Formula) -> EffectSchema:
    return around._replace(given=(*around.given, condition))


def _of_this_one(check: f.Formula, variable: f.Variable, condition: f.Formula) -> f.Formula:
    """What a check on whatever meets ``condition`` says of the one object that does.

    "What the hand holds is not too big" becomes "this object is not too big" where the object is going to be
    in the hand, but is not yet.
    """
    match check:
        case f.Atom(predicate, arguments) if (
            isinstance(condition, f.Atom) and condition.predicate == predicate
        ):
            same = zip(arguments, condition.arguments, strict=True)
            return f.Or((check, _all([f.Equals(one, other) for one, other in same])))
        case f.Exists(quantified, body) if quantified == variable:
            parts = body.operands if isinstance(body, f.And) else (body,)
            return _all([part for part in parts if part != condition]) if condition in parts else check
        case f.Not(operand):
            inner = _of_this_one(operand, variable, condition)
            return f.FALSE if inner == f.TRUE else f.TRUE if inner == f.FALSE else f.Not(inner)
        case f.And(operands) | f.Or(operands):
            return type(check)(tuple(_of_this_one(part, variable, condition) for part in operands))
        case _:
            return check


def _all(parts: Sequence[f.Formula]) -> f.Formula:
    return parts[0] if len(parts) == 1 else f.And(tuple(parts))
