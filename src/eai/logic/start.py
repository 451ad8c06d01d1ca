"""Find formulas that are false on every trace with a given initial state."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import eai.logic.formula as f
from eai.logic.semantics import holds
from eai.logic.trace import Trace
from eai.logic.traversal import is_state_formula, walk_subformulas


def is_refuted_by_initial_state(formula: f.Formula, start: Trace) -> bool:
    """Whether a closed formula is proved false for all traces with a given initial state.

    False means that there is no proof. The proof also considers traces that no actions of the domain produce.

    Args:
        formula: the formula; its quantifiers contain no temporal operators.
        start: the trace that consists of the initial state only.
    """
    return _decide_truth_on_all_continuations(formula, start, at_any_position=True) is False


def _decide_truth_on_all_continuations(
    formula: f.Formula, start: Trace, *, at_any_position: bool
) -> bool | None:
    """Return the truth of a formula on all traces with this initial state, or None if it is not proved.

    Args:
        formula: the formula.
        start: the trace that consists of the initial state only.
        at_any_position: whether a state formula (without temporal operators) holds on a trace if it is true
            at any position. Otherwise it must be true at the first position.
    """
    if is_state_formula(formula):
        if any(isinstance(part, f.Occurs) for part in walk_subformulas(formula)):
            return None
        is_true = holds(formula, start)
        return None if at_any_position and not is_true else is_true
    decide_operand = partial(_decide_truth_on_all_continuations, start=start, at_any_position=at_any_position)
    decide_at_first = partial(_decide_truth_on_all_continuations, start=start, at_any_position=False)
    match formula:
        case f.Not(operand):
            return _negate_three_valued_truth(decide_operand(operand))
        case f.And(operands):
            return _conjoin_three_valued_truths(map(decide_operand, operands))
        case f.Or(operands):
            return _disjoin_three_valued_truths(map(decide_operand, operands))
        case f.Implies(premise, conclusion):
            return _disjoin_three_valued_truths(
                [_negate_three_valued_truth(decide_operand(premise)), decide_operand(conclusion)]
            )
        case f.Always(operand):
            return False if decide_at_first(operand) is False else None
        case f.Eventually(operand):
            return True if decide_at_first(operand) else None
        case f.Until(left, right):
            now = decide_at_first(right)
            return None if now is False and decide_at_first(left) is not False else now
        case f.Then((first, *_)):
            truth = _decide_truth_on_all_continuations(first, start, at_any_position=True)
            return False if truth is False else None
        case _:
            return None


def _negate_three_valued_truth(truth: bool | None) -> bool | None:
    return None if truth is None else not truth


def _conjoin_three_valued_truths(truths: Iterable[bool | None]) -> bool | None:
    values = set(truths)
    return False if False in values else None if None in values else True


def _disjoin_three_valued_truths(truths: Iterable[bool | None]) -> bool | None:
    values = set(truths)
    return True if True in values else None if None in values else False
