"""A second, naive evaluation of conditions and effects on plain sets of facts, to compare the engine with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

from eai.logic.formula import (
    And,
    Atom,
    Equals,
    Exactly,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
    Or,
    Term,
)
from eai.world.derived import ComputedPredicate, DefinedPredicate, LookupPredicate
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.frame import AGENT
from eai.world.state import Fact, State

Bound = Mapping[str, int]


def holds(state: State, facts: frozenset[Fact], formula: Formula, bound: Bound) -> bool:
    """Whether a formula holds in a set of facts; ``state`` is passed to functions of the domain."""
    everything = range(len(state.scene.objects))

    def values(category: str | None) -> list[int]:
        return [i for i in everything if category in (None, state.scene.objects[i].category)]

    match formula:
        case Atom(predicate, arguments):
            objects = tuple(_object(state, term, bound) for term in arguments)
            derived = state.scene.vocabulary.derived_by_name.get(predicate)
            match derived:
                case None:
                    return Fact(predicate, objects) in facts
                case DefinedPredicate(_, parameters, definition):
                    inner = dict(zip((p.name for p in parameters), objects, strict=True))
                    return holds(state, facts, definition, inner)
                case ComputedPredicate(test=test):
                    return test(state, objects)
                case LookupPredicate(values=lookup):
                    return bool(lookup(state, objects[:-1]) >> objects[-1] & 1)
        case Equals(left, right):
            return _object(state, left, bound) == _object(state, right, bound)
        case Not(operand):
            return not holds(state, facts, operand, bound)
        case And(operands):
            return all(holds(state, facts, f, bound) for f in operands)
        case Or(operands):
            return any(holds(state, facts, f, bound) for f in operands)
        case Implies(premise, conclusion):
            return not holds(state, facts, premise, bound) or holds(state, facts, conclusion, bound)
        case Exists(v, body):
            return any(holds(state, facts, body, {**bound, v.name: i}) for i in values(v.category))
        case ForAll(v, body):
            return all(holds(state, facts, body, {**bound, v.name: i}) for i in values(v.category))
        case Exactly(count, v, body):
            return sum(holds(state, facts, body, {**bound, v.name: i}) for i in values(v.category)) == count
    raise TypeError(formula)


def apply(
    state: State, before: frozenset[Fact], facts: frozenset[Fact], effect: Effect, bound: Bound
) -> frozenset[Fact]:
    """Return the facts after an effect; conditions are evaluated in ``before``."""
    match effect:
        case Add(atom):
            return facts | {Fact(atom.predicate, tuple(_object(state, t, bound) for t in atom.arguments))}
        case Delete(atom):
            return facts - set(_matching(state, atom, bound))
        case When(condition, effects, otherwise):
            for inner in effects if holds(state, before, condition, bound) else otherwise:
                facts = apply(state, before, facts, inner, bound)
            return facts
        case ForEach(variable, condition, effects) | Let(variable, condition, effects):
            chosen = [
                i
                for i in range(len(state.scene.objects))
                if holds(state, before, condition, {**bound, variable.name: i})
            ]
            for inner in effects:
                for i in chosen if isinstance(effect, ForEach) else chosen[:1]:
                    facts = apply(state, before, facts, inner, {**bound, variable.name: i})
            return facts
    raise TypeError(effect)


def _matching(state: State, atom: Atom, bound: Bound) -> Iterator[Fact]:
    everything = range(len(state.scene.objects))
    choices = [everything if t == ANYTHING else (_object(state, t, bound),) for t in atom.arguments]
    return (Fact(atom.predicate, objects) for objects in product(*choices))


def _object(state: State, term: Term, bound: Bound) -> int:
    if term == AGENT:
        assert state.scene.agent is not None
        return state.scene.agent
    return bound[term.name] if term.name in bound else state.scene.index[term.name]
