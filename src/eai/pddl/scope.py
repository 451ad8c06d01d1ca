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

from eai.logic.formula import (
    FALSE,
    And,
    Atom,
    Equals,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
    Or,
    Term,
    Variable,
)
from eai.pddl.model import (
    AddEffect,
    Both,
    DeleteEffect,
    Each,
    PddlAction,
    PddlEffect,
    WhenEffect,
    effect_atoms,
)
from eai.pddl.offence import Offence, PddlFinding

UNBOUND_ADDED = Atom("eai--unbound-added")
"""The atom that stands for adding an atom with an unbound variable."""

Names = frozenset[str]


def bind_loose_variables(action: PddlAction) -> PddlAction | PddlFinding:
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
    bound = PddlAction(
        name=action.name,
        parameters=(*action.parameters, *leak.found),
        precondition=binder.condition(precondition, scope),
        effect=binder.effect(action.effect, scope),
    )
    if binder.refused:
        return PddlFinding(Offence.UNBOUND_VARIABLE, binder.refused[0], f"condition of {action.name}")
    return bound


def negation_normal(formula: Formula, *, negated: bool = False) -> Formula:
    """The formula with negation in front of atoms only and without implications."""
    match formula:
        case Not(operand):
            return negation_normal(operand, negated=not negated)
        case And(operands) | Or(operands):
            connective = And if isinstance(formula, And) != negated else Or
            return connective(tuple(negation_normal(operand, negated=negated) for operand in operands))
        case Implies(premise, conclusion):
            return negation_normal(Or((Not(premise), conclusion)), negated=negated)
        case ForAll(variable, body) | Exists(variable, body):
            quantifier = ForAll if isinstance(formula, ForAll) != negated else Exists
            return quantifier(variable, negation_normal(body, negated=negated))
        case _:
            return Not(formula) if negated else formula


@dataclass(slots=True)
class _Leak:
    """Opens the existential quantifiers that leak, left to right, unless their name is taken."""

    taken: set[str]
    found: list[Variable] = field(default_factory=list)

    def open(self, formula: Formula) -> Formula:
        match formula:
            case And(operands):
                return And(tuple(map(self.open, operands)))
            case Exists(variable, body):
                if variable.name in self.taken:
                    return Exists(variable, self.open(body))
                self.taken.add(variable.name)
                self.found.append(variable)
                return self.open(body)
            case _:
                return formula


@dataclass(slots=True)
class _Binder:
    """Gives what is unbound its meaning; ``refused`` collects the names for which there is none."""

    refused: list[str] = field(default_factory=list)

    def condition(self, formula: Formula, scope: Names, *, universal: bool = False) -> Formula:
        match formula:
            case Atom(_, arguments):
                return self._literal(formula, arguments, scope, universal=universal)
            case Equals(left, right):
                return self._literal(formula, (left, right), scope, universal=universal)
            case Not(operand):
                return Not(self.condition(operand, scope, universal=universal))
            case And(operands) | Or(operands):
                parts = (self.condition(operand, scope, universal=universal) for operand in operands)
                return type(formula)(tuple(parts))
            case ForAll(variable, body) | Exists(variable, body):
                inside = universal or isinstance(formula, ForAll)
                bound = self.condition(body, scope | {variable.name}, universal=inside)
                return type(formula)(variable, bound)
            case _:
                return formula

    def effect(self, effect: PddlEffect, scope: Names) -> PddlEffect:
        match effect:
            case AddEffect(atom):
                return effect if _is_bound(atom.arguments, scope) else AddEffect(UNBOUND_ADDED)
            case DeleteEffect(atom):
                return effect if _is_bound(atom.arguments, scope) else Both(())
            case Both(parts):
                return Both(tuple(self.effect(part, scope) for part in parts))
            case Each(variable, part):
                return Each(variable, self.effect(part, scope | {variable.name}))
            case WhenEffect():
                return self._when(effect, scope)

    def _when(self, effect: WhenEffect, scope: Names) -> PddlEffect:
        leak = _Leak(taken=set(scope))
        condition = leak.open(negation_normal(effect.condition))
        inner = scope | {variable.name for variable in leak.found}
        result: PddlEffect = WhenEffect(self.condition(condition, inner), self.effect(effect.part, inner))
        for variable in reversed(leak.found):
            result = Each(variable, result)
        return result

    def _literal(
        self, literal: Formula, arguments: tuple[Term, ...], scope: Names, *, universal: bool
    ) -> Formula:
        if _is_bound(arguments, scope):
            return literal
        if universal:
            self.refused.extend(_loose_terms(arguments, scope))
        return FALSE


def _is_bound(arguments: tuple[Term, ...], scope: Names) -> bool:
    return next(_loose_terms(arguments, scope), None) is None


def _loose_terms(arguments: tuple[Term, ...], scope: Names) -> Iterator[str]:
    return (term.name for term in arguments if isinstance(term, Variable) and term.name not in scope)


def _has_loose(condition: Formula, effect: PddlEffect, scope: Names) -> bool:
    return next(_loose(condition, scope), None) is not None or _has_loose_effect(effect, scope)


def _has_loose_effect(effect: PddlEffect, scope: Names) -> bool:
    match effect:
        case Both(parts):
            return any(_has_loose_effect(part, scope) for part in parts)
        case Each(variable, part):
            return _has_loose_effect(part, scope | {variable.name})
        case WhenEffect(condition, part):
            return _has_loose(condition, part, scope)
        case _:
            return any(not _is_bound(atom.arguments, scope) for atom in effect_atoms(effect))


def _loose(formula: Formula, scope: Names) -> Iterator[str]:
    match formula:
        case Atom(_, arguments):
            yield from _loose_terms(arguments, scope)
        case Equals(left, right):
            yield from _loose_terms((left, right), scope)
        case Not(operand):
            yield from _loose(operand, scope)
        case And(operands) | Or(operands):
            for operand in operands:
                yield from _loose(operand, scope)
        case Implies(premise, conclusion):
            yield from _loose(And((premise, conclusion)), scope)
        case ForAll(variable, body) | Exists(variable, body):
            yield from _loose(body, scope | {variable.name})
