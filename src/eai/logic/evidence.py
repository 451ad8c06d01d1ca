"""Why a formula holds on a trace, or why not."""

from __future__ import annotations

from dataclasses import dataclass

from eai.logic.formula import Always, And, Formula, Then, Until
from eai.logic.semantics import Evaluator
from eai.logic.trace import Trace, positions_in


@dataclass(frozen=True, slots=True)
class Evidence:
    """The verdict on a formula with what supports it.

    ``positions``: for a state formula, every position at which it holds; for ``then``, the position at which
    each part was first completed after the part before it, as far as that went; for any other formula, every
    position from which the rest of the trace satisfies it.

    ``failed``: if the formula does not hold, the smallest parts that are to blame: the conjuncts that never
    hold; a conjunction of states whose conjuncts hold only apart from each other; the first part of a
    ``then`` that is not completed after the parts before it; otherwise the formula itself.
    """

    holds: bool
    positions: tuple[int, ...]
    failed: tuple[Formula, ...] = ()


@dataclass(frozen=True, slots=True)
class _Breach:
    """The violated part of a formula: one that should have held at a position, or (None) at some."""

    part: Formula
    position: int | None


def breach(formula: Formula, trace: Trace) -> _Breach:
    """The violated parts of a formula that does not hold on the trace.

    Of what must always be so, and of what must be so until something else is, the first position at which it
    is not; if that something never is, it; of a conjunction its first such part, or all of it where its parts
    hold, but only apart from each other.
    """
    evaluator, end = Evaluator(formula, trace), trace.length - 1
    match formula:
        case And(parts) if parts:
            failing = [part for part in parts if not evaluator.on(part, {}, end) & 1]
            return breach(failing[0], trace) if failing else _Breach(formula, None)
        case Always(body) | Until(left=body):
            lacking = ~evaluator.at(body, {}, end) & ((2 << end) - 1)
            if lacking:
                return _Breach(body, next(positions_in(lacking)))
            return _Breach(formula.right if isinstance(formula, Until) else body, None)
        case _:
            return _Breach(explain(formula, trace).failed[0], None)


def explain(formula: Formula, trace: Trace) -> Evidence:
    """Whether a closed formula holds on the trace, and the evidence.

    Raises:
        InputError: a variable is not bound by any quantifier.
    """
    evaluator, end = Evaluator(formula, trace), trace.length - 1
    if isinstance(formula, Then) and formula.parts:
        return _explain_sequence(formula, bool(evaluator.on(formula, {}, end) & 1), evaluator, trace, 0)
    failed = _blame(formula, evaluator, trace, 0)
    mask = evaluator.on(formula, {}, end) if evaluator.is_temporal(formula) else evaluator.state(formula, {})
    return Evidence(not failed, tuple(positions_in(mask)), failed)


def _blame(formula: Formula, evaluator: Evaluator, trace: Trace, start: int) -> tuple[Formula, ...]:
    """The parts of a formula that make it not hold from ``start`` on; none if it does hold."""
    if evaluator.on(formula, {}, trace.length - 1) >> start & 1:
        return ()
    match formula:
        case Then(parts) if parts:
            return _explain_sequence(formula, False, evaluator, trace, start).failed
        case And(operands):
            blamed = [_blame(operand, evaluator, trace, start) for operand in operands]
            return tuple([culprit for each in blamed for culprit in each]) or (formula,)
        case _:
            return (formula,)


def _explain_sequence(formula: Then, holds: bool, evaluator: Evaluator, trace: Trace, start: int) -> Evidence:
    """Complete the parts of a ``then`` one after the other, each as early as possible."""
    positions: list[int] = []
    for part in formula.parts:
        last = _first_completion(part, evaluator, trace, start)
        if last is None:
            if holds:  # a later completion of an earlier part makes the rest possible
                return Evidence(True, tuple(positions))
            left = _blame(part, evaluator, trace, start) if start < trace.length else ()
            return Evidence(False, tuple(positions), left or (part,))
        positions.append(last)
        start = last + 1
    return Evidence(holds, tuple(positions), () if holds else (formula,))


def _first_completion(part: Formula, evaluator: Evaluator, trace: Trace, start: int) -> int | None:
    """The end of the shortest piece from ``start`` on that satisfies the part, or None."""
    if not evaluator.is_temporal(part):
        rest = evaluator.state(part, {}) >> start
        return start + (rest & -rest).bit_length() - 1 if rest else None
    ends = range(start, trace.length)
    return next((end for end in ends if evaluator.on(part, {}, end) >> start & 1), None)
