"""Which objects matter to a quantifier: those for which its body can be true, or false, at all.

``exists x. exists y. (pour(x, y))`` on a trace with one pouring need not try 290 times 290 pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import eai.logic.formula as f
from eai.logic.trace import Trace


def support(
    formula: f.Formula, variable: str, binding: Mapping[str, str], truth: bool, trace: Trace
) -> frozenset[str] | None:
    """A set outside of which no value of the variable gives the formula this truth at any position.

    Returns None where no such set is known without trying. ``binding`` holds the values of variables bound
    further out; ``variable`` is not among them.
    """

    def of(part: f.Formula, wanted: bool) -> frozenset[str] | None:
        return support(part, variable, binding, wanted, trace)

    match formula:
        case f.Occurs(action, arguments) if truth and f.Variable(variable) in arguments:
            return trace.participants(action, arguments.index(f.Variable(variable)))
        case f.Equals(left, right) if truth:
            return _equal_to(left, right, variable, binding)
        case f.Not(operand):
            return of(operand, not truth)
        case f.And(operands) | f.Or(operands):
            found = (of(part, truth) for part in operands)
            return _smallest(found) if isinstance(formula, f.And) == truth else _all_together(found)
        case f.Implies(premise, conclusion):
            return of(f.Or((f.Not(premise), conclusion)), truth)
        case f.Exists(inner, body) | f.ForAll(inner, body):
            # Only a body that must have this truth for some value says anything: a domain may be empty.
            if isinstance(formula, f.Exists) != truth or inner.name == variable:
                return None
            outer = {name: value for name, value in binding.items() if name != inner.name}
            return support(body, variable, outer, truth, trace)
        case f.Next(operand) | f.Until(right=operand) if truth:
            return of(operand, truth)
        case f.Eventually(operand) | f.Always(operand):
            return of(operand, truth)
        case f.Then(parts) if truth:
            return _smallest(of(part, truth) for part in parts)
        case _:
            return None


def _equal_to(
    left: f.Term, right: f.Term, variable: str, binding: Mapping[str, str]
) -> frozenset[str] | None:
    for term, other in ((left, right), (right, left)):
        if term == f.Variable(variable):
            if isinstance(other, f.Constant):
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
