"""Which objects matter to a quantifier: those for which its body can be true, or false, at all.

``exists x. exists y. (pour(x, y))`` on a trace with one pouring need not try 290 times 290 pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from eai.logic.formula import (
    Always,
    And,
    Constant,
    Equals,
    Eventually,
    Exists,
    ForAll,
    Formula,
    Implies,
    Next,
    Not,
    Occurs,
    Or,
    Term,
    Then,
    Until,
    Variable,
)
from eai.logic.trace import Trace


def support(
    formula: Formula, variable: str, binding: Mapping[str, str], truth: bool, trace: Trace
) -> frozenset[str] | None:
    """A set outside of which no value of the variable gives the formula this truth at any position.

    Returns None where no such set is known without trying. ``binding`` holds the values of variables bound
    further out; ``variable`` is not among them.
    """

    def of(part: Formula, wanted: bool) -> frozenset[str] | None:
        return support(part, variable, binding, wanted, trace)

    match formula:
        case Occurs(action, arguments) if truth and Variable(variable) in arguments:
            return trace.participants(action, arguments.index(Variable(variable)))
        case Equals(left, right) if truth:
            return _equal_to(left, right, variable, binding)
        case Not(operand):
            return of(operand, not truth)
        case And(operands) | Or(operands):
            found = (of(part, truth) for part in operands)
            return _smallest(found) if isinstance(formula, And) == truth else _all_together(found)
        case Implies(premise, conclusion):
            return of(Or((Not(premise), conclusion)), truth)
        case Exists(inner, body) | ForAll(inner, body):
            # Only a body that must have this truth for some value says anything: a domain may be empty.
            if isinstance(formula, Exists) != truth or inner.name == variable:
                return None
            outer = {name: value for name, value in binding.items() if name != inner.name}
            return support(body, variable, outer, truth, trace)
        case Next(operand) | Until(right=operand) if truth:
            return of(operand, truth)
        case Eventually(operand) | Always(operand):
            return of(operand, truth)
        case Then(parts) if truth:
            return _smallest(of(part, truth) for part in parts)
        case _:
            return None


def _equal_to(left: Term, right: Term, variable: str, binding: Mapping[str, str]) -> frozenset[str] | None:
    for term, other in ((left, right), (right, left)):
        if term == Variable(variable):
            if isinstance(other, Constant):
                return frozenset((other.name,))
            if other.name in binding:
                return frozenset((binding[other.name],))
    return None


def _smallest(found: Iterable[frozenset[str] | None]) -> frozenset[str] | None:
    return min((objects for objects in found if objects is not None), key=len, default=None)


def _all_together(found: Iterable[frozenset[str] | None]) -> frozenset[str] | None:
    union: frozenset[str] = frozenset()
    for objects in found:
        if objects is None:
            return None
        union |= objects
    return union
