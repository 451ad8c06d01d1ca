"""Find formulas that are false on every trace with a given initial state."""

from __future__ import annotations

from collections.abc import Iterable

import eai.logic.formula as f
from eai.logic.semantics import holds
from eai.logic.trace import Trace
from eai.logic.traversal import is_state_formula, walk


def is_broken(formula: f.Formula, start: Trace) -> bool:
    """Whether a closed formula is proved false for all traces with a given initial state.

    False means that there is no proof. Some traces may be impossible by the actions of the domain.

    Args:
        formula: the formula; its quantifiers contain no temporal operators.
        start: the trace that consists of the initial state only.
    """
    return _truth(formula, start, is_top=True) is False


def _truth(formula: f.Formula, start: Trace, *, is_top: bool) -> bool | None:
    """Return the truth of a formula if it is equal on all traces with this initial state, else None.

    A state formula outside of temporal operators may hold at any position of a trace.
    """
    if is_state_formula(formula):
        if any(isinstance(part, f.Occurs) for part in walk(formula)):
            return None
        is_true = holds(formula, start)
        return None if is_top and not is_true else is_true
    match formula:
        case f.Not(operand):
            return _negate(_truth(operand, start, is_top=is_top))
        case f.And(operands):
            return _all(_truth(operand, start, is_top=is_top) for operand in operands)
        case f.Or(operands):
            return _negate(_all(_negate(_truth(operand, start, is_top=is_top)) for operand in operands))
        case f.Implies(premise, conclusion):
            denied = _negate(_truth(conclusion, start, is_top=is_top))
            return _negate(_all([_truth(premise, start, is_top=is_top), denied]))
        case f.Always(operand):
            return False if _truth(operand, start, is_top=False) is False else None
        case f.Eventually(operand):
            return True if _truth(operand, start, is_top=False) is True else None
        case f.Until(left, right):
            now = _truth(right, start, is_top=False)
            return now if now or (now is False and _truth(left, start, is_top=False) is False) else None
        case f.Then((first, *_)):
            return False if _truth(first, start, is_top=True) is False else None
        case _:
            return None


def _negate(truth: bool | None) -> bool | None:
    return None if truth is None else not truth


def _all(truths: Iterable[bool | None]) -> bool | None:
    values = list(truths)
    return False if False in values else None if None in values else True
