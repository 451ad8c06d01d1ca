"""Find formulas that are false on every trace with a given initial state."""

from __future__ import annotations

from collections.abc import Iterable

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
    formula: f.Formula, initial_state_trace: Trace, *, at_any_position: bool
) -> bool | None:
    """Return the truth of a formula on all traces with this initial state, or None if it is not proved.

    Args:
        formula: the formula.
        initial_state_trace: the trace that consists of the initial state only.
        at_any_position: whether a state formula (without temporal operators) holds on a trace if it is true
            at any position. Otherwise it must be true at the first position.
    """
    if is_state_formula(formula):
        if any(isinstance(part, f.Occurs) for part in walk_subformulas(formula)):
            return None
        is_true = holds(formula, initial_state_trace)
        return None if at_any_position and not is_true else is_true
    match formula:
        case f.Not(operand):
            return _negate_three_valued_truth(
                _decide_truth_on_all_continuations(
                    operand, initial_state_trace, at_any_position=at_any_position
                )
            )
        case f.And(operands):
            return _conjoin_three_valued_truths(
                _decide_truth_on_all_continuations(
                    operand, initial_state_trace, at_any_position=at_any_position
                )
                for operand in operands
            )
        case f.Or(operands):
            return _negate_three_valued_truth(
                _conjoin_three_valued_truths(
                    _negate_three_valued_truth(
                        _decide_truth_on_all_continuations(
                            operand, initial_state_trace, at_any_position=at_any_position
                        )
                    )
                    for operand in operands
                )
            )
        case f.Implies(premise, conclusion):
            denied = _negate_three_valued_truth(
                _decide_truth_on_all_continuations(
                    conclusion, initial_state_trace, at_any_position=at_any_position
                )
            )
            return _negate_three_valued_truth(
                _conjoin_three_valued_truths(
                    [
                        _decide_truth_on_all_continuations(
                            premise, initial_state_trace, at_any_position=at_any_position
                        ),
                        denied,
                    ]
                )
            )
        case f.Always(operand):
            return (
                False
                if _decide_truth_on_all_continuations(operand, initial_state_trace, at_any_position=False)
                is False
                else None
            )
        case f.Eventually(operand):
            return (
                True
                if _decide_truth_on_all_continuations(operand, initial_state_trace, at_any_position=False)
                is True
                else None
            )
        case f.Until(left, right):
            now = _decide_truth_on_all_continuations(right, initial_state_trace, at_any_position=False)
            return (
                now
                if now
                or (
                    now is False
                    and _decide_truth_on_all_continuations(left, initial_state_trace, at_any_position=False)
                    is False
                )
                else None
            )
        case f.Then((first, *_)):
            return (
                False
                if _decide_truth_on_all_continuations(first, initial_state_trace, at_any_position=True)
                is False
                else None
            )
        case _:
            return None


def _negate_three_valued_truth(truth: bool | None) -> bool | None:
    return None if truth is None else not truth


def _conjoin_three_valued_truths(truths: Iterable[bool | None]) -> bool | None:
    values = list(truths)
    return False if False in values else None if None in values else True
