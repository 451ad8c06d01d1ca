"""Unbound variables: operators that use some, given the meaning that the reference's planner gave them.

The planner behind the published numbers (Fast Downward before mid-2024) neither refused such operators nor
treated them by any rule written down; this module states the rule as one rewriting
(`bind_loose_variables`), after which a current planner gives the same answers. Two steps:

1. An ``exists`` of the precondition that lies under nothing but ``and`` and ``exists`` binds its name in the
   whole operator, as if it were a parameter; one in the condition of a ``when`` binds it in that ``when``.
2. Whatever is still unbound makes a condition's literal false, makes a deletion vanish, and turns an addition
   into an addition of `UNBOUND_ADDED`: if that atom can be reached, the planner crashed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import eai.logic.formula as f
import eai.pddl.model as m
from eai.pddl.offence import Offence, PddlFinding

UNBOUND_ADDED = f.Atom("eai--unbound-added")
"""The atom that stands for adding an atom with an unbound variable."""

Names = frozenset[str]


def bind_loose_variables(action: m.PddlAction) -> m.PddlAction | PddlFinding:
    """The operator with every variable bound, or the offence for which the reference's planner refused it.

    Refused is an unbound variable inside a ``forall`` of a condition (an ``exists`` under ``not`` is one).
    An operator without unbound variables is returned as it is.
    """
    parameters = frozenset(parameter.name for parameter in action.parameters)
    if not _has_loose(action.precondition, action.effect, parameters):
        return action
    leak = _Leak(taken=set(parameters))
    precondition = leak.open(negation_normal(action.precondition))
    scope = parameters | {variable.name for variable in leak.found}
    binder = _Binder()
    bound = m.PddlAction(
        name=action.name,
        parameters=(*action.parameters, *leak.found),
        precondition=binder.condition(precondition, scope),
        effect=binder.effect(action.effect, scope),
    )
    if binder.refused:
        return PddlFinding(Offence.UNBOUND_VARIABLE, binder.refused[0], f"condition of {action.name}")
    return bound


def negation_normal(formula: f.Formula, *, negated: bool = False) -> f.Formula:
    """The formula with negation in front of atoms only and without implications."""
    match formula:
        case f.Not(operand):
            return negation_normal(operand, negated=not negated)
        case f.And(operands) | f.Or(operands):
            connective = f.And if isinstance(formula, f.And) != negated else f.Or
            return connective(tuple(negation_normal(operand, negated=negated) for operand in operands))
        case f.Implies(premise, conclusion):
            return negation_normal(f.Or((f.Not(premise), conclusion)), negated=negated)
        case f.ForAll(variable, body) | f.Exists(variable, body):
            quantifier = f.ForAll if isinstance(formula, f.ForAll) != negated else f.Exists
            return quantifier(variable, negation_normal(body, negated=negated))
        case _:
            return f.Not(formula) if negated else formula


@dataclass(slots=True)
class _Leak:
    """Opens the existential quantifiers that leak, left to right, unless their name is taken."""

    taken: set[str]
    found: list[f.Variable] = field(default_factory=list)

    def open(self, formula: f.Formula) -> f.Formula:
        match formula:
            case f.And(operands):
                return f.And(tuple(map(self.open, operands)))
            case f.Exists(variable, body):
                if variable.name in self.taken:
                    return f.Exists(variable, self.open(body))
                self.taken.add(variable.name)
                self.found.append(variable)
                return self.open(body)
            case _:
                return formula


@dataclass(slots=True)
class _Binder:
    """Gives what is unbound its meaning; ``refused`` collects the names for which there is none."""

    refused: list[str] = field(default_factory=list)

    def condition(self, formula: f.Formula, scope: Names, *, universal: bool = False) -> f.Formula:
        match formula:
            case f.Atom(_, arguments):
                return self._literal(formula, arguments, scope, universal=universal)
            case f.Equals(left, right):
                return self._literal(formula, (left, right), scope, universal=universal)
            case f.Not(operand):
                return f.Not(self.condition(operand, scope, universal=universal))
            case f.And(operands) | f.Or(operands):
                parts = (self.condition(operand, scope, universal=universal) for operand in operands)
                return type(formula)(tuple(parts))
            case f.ForAll(variable, body) | f.Exists(variable, body):
                inside = universal or isinstance(formula, f.ForAll)
                bound = self.condition(body, scope | {variable.name}, universal=inside)
                return type(formula)(variable, bound)
            case _:
                return formula

    def effect(self, effect: m.PddlEffect, scope: Names) -> m.PddlEffect:
        match effect:
            case m.AddEffect(atom):
                return effect if _is_bound(atom.arguments, scope) else m.AddEffect(UNBOUND_ADDED)
            case m.DeleteEffect(atom):
                return effect if _is_bound(atom.arguments, scope) else m.Both(())
            case m.Both(parts):
                return m.Both(tuple(self.effect(part, scope) for part in parts))
            case m.Each(variable, part):
                return m.Each(variable, self.effect(part, scope | {variable.name}))
            case m.WhenEffect():
                return self._when(effect, scope)

    def _when(self, effect: m.WhenEffect, scope: Names) -> m.PddlEffect:
        leak = _Leak(taken=set(scope))
        condition = leak.open(negation_normal(effect.condition))
        inner = scope | {variable.name for variable in leak.found}
        result: m.PddlEffect = m.WhenEffect(self.condition(condition, inner), self.effect(effect.part, inner))
        for variable in reversed(leak.found):
            result = m.Each(variable, result)
        return result

    def _literal(
        self, literal: f.Formula, arguments: tuple[f.Term, ...], scope: Names, *, universal: bool
    ) -> f.Formula:
        if _is_bound(arguments, scope):
            return literal
        if universal:
            self.refused.extend(_loose_terms(arguments, scope))
        return f.FALSE


def _is_bound(arguments: tuple[f.Term, ...], scope: Names) -> bool:
    return next(_loose_terms(arguments, scope), None) is None


def _loose_terms(arguments: tuple[f.Term, ...], scope: Names) -> Iterator[str]:
    return (term.name for term in arguments if isinstance(term, f.Variable) and term.name not in scope)


def _has_loose(condition: f.Formula, effect: m.PddlEffect, scope: Names) -> bool:
    return next(_loose(condition, scope), None) is not None or _has_loose_effect(effect, scope)


def _has_loose_effect(effect: m.PddlEffect, scope: Names) -> bool:
    match effect:
        case m.Both(parts):
            return any(_has_loose_effect(part, scope) for part in parts)
        case m.Each(variable, part):
            return _has_loose_effect(part, scope | {variable.name})
        case m.WhenEffect(condition, part):
            return _has_loose(condition, part, scope)
        case _:
            return any(not _is_bound(atom.arguments, scope) for atom in m.effect_atoms(effect))


def _loose(formula: f.Formula, scope: Names) -> Iterator[str]:
    match formula:
        case f.Atom(_, arguments):
            yield from _loose_terms(arguments, scope)
        case f.Equals(left, right):
            yield from _loose_terms((left, right), scope)
        case f.Not(operand):
            yield from _loose(operand, scope)
        case f.And(operands) | f.Or(operands):
            for operand in operands:
                yield from _loose(operand, scope)
        case f.Implies(premise, conclusion):
            yield from _loose(f.And((premise, conclusion)), scope)
        case f.ForAll(variable, body) | f.Exists(variable, body):
            yield from _loose(body, scope | {variable.name})
