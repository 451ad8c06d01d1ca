"""A direct, exponential implementation of the semantics, to compare eai.logic.semantics with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

from eai.logic.formula import (
    Always,
    And,
    Atom,
    Constant,
    Equals,
    Eventually,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Next,
    Not,
    Occurs,
    Or,
    Term,
    Then,
    Until,
)
from eai.logic.trace import TakenAction
from eai.logic.traversal import is_state_formula


@dataclass(frozen=True)
class Facts:
    """A state given by its true atoms, and by its objects with their categories."""

    true: frozenset[tuple[str, tuple[str, ...]]]
    categories: tuple[tuple[str, str], ...]

    def holds(self, predicate: str, arguments: tuple[str, ...]) -> bool:
        return (predicate, arguments) in self.true

    def list_objects(self, category: str | None) -> Sequence[str]:
        return [name for name, kind in self.categories if category in (None, kind)]


@dataclass(frozen=True)
class Naive:
    states: tuple[Facts, ...]
    actions: tuple[TakenAction, ...]

    def on(self, formula: Formula, first: int, last: int, binding: dict[str, str]) -> bool:
        """Whether the piece from first to last satisfies the formula."""
        if is_state_formula(formula):
            return any(self.at(formula, i, last, binding) for i in range(first, last + 1))
        if isinstance(formula, (Next, Eventually, Always, Until, Then)):
            return self.at(formula, first, last, binding)
        return self.connective(formula, first, last, binding, on=True)

    def at(self, formula: Formula, i: int, last: int, binding: dict[str, str]) -> bool:
        """Whether the formula holds at position i of the trace that ends at last."""
        match formula:
            case Atom(predicate, arguments):
                return self.states[i].holds(predicate, self.objects(arguments, binding))
            case Occurs(action, arguments):
                taken = self.actions[i] if i < len(self.actions) else None
                return taken == (action, self.objects(arguments, binding))
            case Equals(left, right):
                a, b = self.objects((left, right), binding)
                return a == b
            case Next(operand):
                return i < last and self.at(operand, i + 1, last, binding)
            case Eventually(operand):
                return any(self.at(operand, j, last, binding) for j in range(i, last + 1))
            case Always(operand):
                return all(self.at(operand, j, last, binding) for j in range(i, last + 1))
            case Until(left, right):
                return any(
                    self.at(right, j, last, binding)
                    and all(self.at(left, k, last, binding) for k in range(i, j))
                    for j in range(i, last + 1)
                )
            case Then(parts):
                if len(parts) < 2:
                    return all(self.on(part, i, last, binding) for part in parts)
                return any(
                    self.on(parts[0], i, cut, binding) and self.on(Then(parts[1:]), cut + 1, last, binding)
                    for cut in range(i, last)
                )
            case _:
                return self.connective(formula, i, last, binding, on=False)

    def connective(self, formula: Formula, i: int, last: int, binding: dict[str, str], on: bool) -> bool:
        def true(part: Formula, **more: str) -> bool:
            return (self.on if on else self.at)(part, i, last, {**binding, **more})

        objects = self.states[0].list_objects
        match formula:
            case Not(operand):
                return not true(operand)
            case And(operands):
                return all(true(operand) for operand in operands)
            case Or(operands):
                return any(true(operand) for operand in operands)
            case Implies(premise, conclusion):
                return not true(premise) or true(conclusion)
            case ForAll(variable, body):
                return all(true(body, **{variable.name: o}) for o in objects(variable.category))
            case Exists(variable, body):
                return any(true(body, **{variable.name: o}) for o in objects(variable.category))
            case Exactly(count, variable, body):
                return count == sum(true(body, **{variable.name: o}) for o in objects(variable.category))
            case ForPairs(first, second, body, count):
                xs, ys = objects(first.category), objects(second.category)
                size = min(len(xs), len(ys)) if count is None else count
                return any(
                    all(
                        x != y and true(body, **{first.name: x, second.name: y})
                        for x, y in zip(some, others, strict=True)
                    )
                    for some in permutations(xs, size)
                    for others in permutations(ys, size)
                )
            case _:
                raise AssertionError(formula)

    def objects(self, terms: tuple[Term, ...], binding: dict[str, str]) -> tuple[str, ...]:
        return tuple(term.name if isinstance(term, Constant) else binding[term.name] for term in terms)
