"""Formulas made from formulas by replacing what stands at their leaves, and how much that makes.

The extent of a subgoal is counted before anything is unfolded: a few words can ask for millions of literals,
as quantifiers multiply, and so do alternatives. What asks for too much is refused, the same on every
machine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.task import Task
from eai.errors import InputError
from eai.logic.traversal import children, is_state_formula
from eai.world.relation import bits

Leaf: TypeAlias = f.Atom | f.Occurs | f.Equals


def rewrite(
    formula: f.Formula,
    change: Callable[[Leaf, frozenset[str]], f.Formula],
    bound: frozenset[str] = frozenset(),
) -> f.Formula:
    """The formula with each leaf replaced by what ``change`` makes of it and of the variables bound there.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """
    match formula:
        case f.Atom() | f.Occurs() | f.Equals():
            return change(formula, bound)
        case f.And(parts) | f.Or(parts) | f.Then(parts):
            return type(formula)(tuple(rewrite(part, change, bound) for part in parts))
        case f.Not(operand):
            return f.Not(rewrite(operand, change, bound))
        case f.Implies(premise, conclusion):
            return f.Implies(rewrite(premise, change, bound), rewrite(conclusion, change, bound))
        case f.ForAll(variable, body) | f.Exists(variable, body) | f.Exactly(_, variable, body):
            return replace(formula, body=rewrite(body, change, bound | {variable.name}))
        case f.ForPairs(first, second, body):
            return replace(formula, body=rewrite(body, change, bound | {first.name, second.name}))
        case _:
            raise InputError(f"{type(formula).__name__} is not an operator of goals and subgoals")


def rewrite_in_time(formula: f.Formula, change: Callable[[f.Formula], f.Formula]) -> f.Formula:
    """A formula of temporal logic in which each of the largest parts about one state is changed.

    Raises:
        InputError: it has a quantifier around a temporal operator.
    """
    if is_state_formula(formula):
        return change(formula)
    match formula:
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return type(formula)(rewrite_in_time(operand, change))
        case f.And(parts) | f.Or(parts) | f.Then(parts):
            return type(formula)(tuple([rewrite_in_time(part, change) for part in parts]))
        case f.Until(left, right) | f.Implies(left, right):
            return type(formula)(rewrite_in_time(left, change), rewrite_in_time(right, change))
        case _:
            raise InputError("expected temporal operators outside of quantifiers")


def substitute(formula: f.Formula, values: Mapping[f.Term, f.Term]) -> f.Formula:
    """The formula with constants, and variables where they are free, replaced.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """

    def value(term: f.Term, bound: frozenset[str]) -> f.Term:
        return term if term.name in bound else values.get(term, term)

    def change(leaf: Leaf, bound: frozenset[str]) -> f.Formula:
        if isinstance(leaf, f.Equals):
            return f.Equals(value(leaf.left, bound), value(leaf.right, bound))
        return replace(leaf, arguments=tuple([value(term, bound) for term in leaf.arguments]))

    return rewrite(formula, change)


def negation_normal(formula: f.Formula, *, negated: bool = False) -> f.Formula:
    """The formula, or its negation, with negations at the leaves only and without implications.

    Negations of counting quantifiers and of temporal operators stay where they are.
    """
    match formula:
        case f.Not(operand):
            return negation_normal(operand, negated=not negated)
        case f.And(parts) | f.Or(parts):
            kind = f.And if isinstance(formula, f.And) != negated else f.Or
            return kind(tuple([negation_normal(part, negated=negated) for part in parts]))
        case f.Implies(premise, conclusion):
            either = f.Or((f.Not(premise), conclusion))
            return negation_normal(either, negated=negated)
        case f.ForAll(variable, body) | f.Exists(variable, body):
            quantifier = f.ForAll if isinstance(formula, f.ForAll) != negated else f.Exists
            return quantifier(variable, negation_normal(body, negated=negated))
        case f.Then(parts) if not negated:
            return f.Then(tuple([negation_normal(part) for part in parts]))
        case _:
            return f.Not(formula) if negated else formula


MAX_LITERALS = 100_000
"""The most literals that a subgoal may come down to, and all its alternatives together."""

TOO_MUCH = f"it comes down to more than {MAX_LITERALS:,} literals"


class Extent:
    """What the quantifiers of subgoals range over, and how much that makes.

    Args:
        task: the task.
    """

    def __init__(self, task: Task) -> None:
        self._scene = task.scene
        self._relevant = task.relevant

    def everything(self, variable: f.Variable) -> Sequence[int]:
        """The objects of a variable's class: what a ``forall`` asks for."""
        return tuple(bits(self._scene.category(variable.category)))

    def usable(self, variable: f.Variable) -> Sequence[int]:
        """The task's objects of a class, or, if there are none, all in the scene: what ``exists`` tries."""
        mask = self._scene.category(variable.category)
        return [i for i in self._relevant if mask >> i & 1] or tuple(bits(mask))

    def literals(self, formula: f.Formula) -> int:
        """How many literals a test of a formula may look at.

        A kind of which there is nothing counts as one thing: what stands within or around is looked at.

        Raises:
            InputError: there are more than `MAX_LITERALS`.
        """
        match formula:
            case f.Exists(variable, body) | f.ForAll(variable, body) | f.Exactly(_, variable, body):
                number = self._size(variable) * self.literals(body)
            case f.ForPairs(first, second, body):
                number = self._size(first) * self._size(second) * self.literals(body)
            case _:
                number = sum(map(self.literals, children(formula))) or 1
        return _few(number)

    def _size(self, variable: f.Variable) -> int:
        return max(1, self._scene.category(variable.category).bit_count())

    def to_be_done(self, formula: f.Formula) -> int:
        """How many literals the alternatives of a formula in negation normal form have, all together.

        An alternative counts as one at least, also if it asks for nothing of a kind of which there is none.

        Raises:
            InputError: there are more than `MAX_LITERALS`, or a test looks at more.
        """
        self.literals(formula)
        return _few(self._choices(formula) * max(1, self._longest(formula)))

    def _choices(self, formula: f.Formula) -> int:
        """How many alternatives there are, counted no further than is allowed."""
        match formula:
            case f.And(parts):
                choices = prod(map(self._choices, parts))
            case f.Or(parts):
                choices = sum(map(self._choices, parts))
            case f.Exists(variable, body):
                choices = len(self.usable(variable)) * self._choices(body)
            case f.ForAll(variable, body):
                choices = self._choices(body) ** len(self.everything(variable))
            case _:
                choices = 1
        return min(choices, MAX_LITERALS + 1)

    def _longest(self, formula: f.Formula) -> int:
        """How many literals one alternative has at most."""
        match formula:
            case f.And(parts):
                return sum(map(self._longest, parts))
            case f.Or(parts):
                return max(map(self._longest, parts), default=0)
            case f.Exists(_, body):
                return self._longest(body)
            case f.ForAll(variable, body):
                return len(self.everything(variable)) * self._longest(body)
            case _:
                return 1


def _few(number: int) -> int:
    if number > MAX_LITERALS:
        raise InputError(TOO_MUCH)
    return number
