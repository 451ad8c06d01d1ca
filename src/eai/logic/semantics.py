"""Evaluates formulas on traces, and explains the result (paper, section "LTL representation of goals").

A state formula holds on a trace if it holds at some position. ``f then g`` holds if the trace can be cut into
two nonempty pieces, the first satisfying ``f`` and the second ``g``. And, or, not and quantifiers around
``then`` combine the truth values of their parts on the same trace, as usual. The operators beyond the paper
are about positions, as usual in LTL on finite traces (De Giacomo and Vardi 2013). Below next, eventually,
always and until, a state formula means "at this position". At the top, these operators mean "at the first
position".

Every subformula is evaluated once for all positions at a time, as a mask of positions, so that connectives
are integer operations. The piece of an operand before ``then`` may end anywhere. Some operands cannot become
false when their piece grows: all without not, always, implies and forn over ``then``. For these, only the
last possible end is tried. For operands that cannot become false when the piece shrinks, only the first end
is tried. All others are evaluated on every piece, which costs a factor of the trace's length.

A quantifier tries only those objects for which its body can be true, or false, at all (`support`):
``exists x. exists y. (pour(x, y))`` on a trace with one pouring does not try 290 times 290 pairs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial, reduce
from operator import and_, or_
from typing import TypeAlias

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.logic.matching import maximum_matching
from eai.logic.trace import Trace, positions_in
from eai.logic.traversal import monotony, temporal_parts

Binding: TypeAlias = Mapping[str, str]
"""Mapping from the names of variables to their objects."""

_EvaluatePart: TypeAlias = Callable[[f.Formula, Binding], int]


def holds(formula: f.Formula, trace: Trace) -> bool:
    """Whether a closed formula holds on the trace.

    Raises:
        InputError: a variable is not bound by any quantifier.
    """
    evaluator = _Evaluator(formula, trace)
    return bool(evaluator.find_starts(formula, {}, trace.length - 1) & 1)


class _Evaluator:
    """Evaluates the parts of one formula on one trace."""

    def __init__(self, formula: f.Formula, trace: Trace) -> None:
        self._trace = trace
        self._formula = formula  # keeps the formula's parts alive, so that their ids stay unique
        self._temporal = temporal_parts(formula)
        self._monotony = monotony(formula)
        self._closed: dict[int, int] = {}
        self._tables: dict[tuple[int, frozenset[tuple[str, str]]], list[int]] = {}

    def is_temporal(self, formula: f.Formula) -> bool:
        """Whether a subformula has a temporal operator."""
        return id(formula) in self._temporal

    def find_state_positions(self, formula: f.Formula, binding: Binding) -> int:
        """Return the positions at which a state formula holds."""
        if binding:
            return self._compute_state_positions(formula, binding)
        mask = self._closed.get(id(formula))
        if mask is None:
            mask = self._closed[id(formula)] = self._compute_state_positions(formula, binding)
        return mask

    def _compute_state_positions(self, formula: f.Formula, binding: Binding) -> int:
        match formula:
            case f.Atom(predicate, arguments):
                return self._trace.atom(predicate, _objects(arguments, binding))
            case f.Occurs(action, arguments):
                return self._trace.occurrence(action, _objects(arguments, binding))
            case f.Equals(left, right):
                a, b = _objects((left, right), binding)
                return _up_to(self._trace.length - 1) if a == b else 0
            case _:
                return self._combine(formula, binding, self.find_state_positions, self._trace.length - 1)

    def find_positions(self, formula: f.Formula, binding: Binding, end: int) -> int:
        """Return the positions at which the formula holds, on the trace cut off after ``end``."""
        if not self.is_temporal(formula):
            return self.find_state_positions(formula, binding) & _up_to(end)
        match formula:
            case f.Next(operand):
                return self.find_positions(operand, binding, end) >> 1
            case f.Eventually(operand):
                return _up_to_last(self.find_positions(operand, binding, end))
            case f.Always(operand):
                everything = _up_to(end)
                return everything & ~_up_to_last(everything & ~self.find_positions(operand, binding, end))
            case f.Until(left, right):
                return _positions_until(
                    self.find_positions(left, binding, end), self.find_positions(right, binding, end)
                )
            case f.Then(parts):
                last = self.find_starts(parts[-1], binding, end) if parts else _up_to(end)
                return self._find_sequence_starts(parts[:-1], binding, last)
            case _:
                return self._combine(formula, binding, partial(self.find_positions, end=end), end)

    def find_starts(self, formula: f.Formula, binding: Binding, end: int) -> int:
        """Return the start positions of pieces that end at ``end`` and satisfy the formula."""
        if not self.is_temporal(formula):
            return _up_to_last(self.find_state_positions(formula, binding) & _up_to(end))
        if isinstance(formula, (f.Next, f.Eventually, f.Always, f.Until, f.Then)):
            return self.find_positions(formula, binding, end)
        return self._combine(formula, binding, partial(self.find_starts, end=end), end)

    def _find_sequence_starts(self, parts: Sequence[f.Formula], binding: Binding, starts: int) -> int:
        """Return the start positions of consecutive pieces that satisfy the parts and end at ``starts``."""
        for part in reversed(parts):
            starts = self._find_piece_starts(part, binding, starts)
        return starts

    def _find_piece_starts(self, formula: f.Formula, binding: Binding, rest: int) -> int:
        """Return the start positions of pieces that satisfy the formula and end just before ``rest``."""
        ends = rest >> 1
        # A lasting formula that holds on some piece also holds on the longest one.
        if id(formula) in self._monotony.lasting:
            return self.find_starts(formula, binding, ends.bit_length() - 1) if ends else 0
        # A perishing formula that some piece satisfies is satisfied by the piece of length 1.
        if id(formula) in self._monotony.perishing and ends == _up_to_last(ends):
            return self._find_single_positions(formula, binding) & ends
        table = self._find_table(formula, binding)
        return reduce(or_, [table[end] for end in positions_in(ends)], 0)

    def _find_single_positions(self, formula: f.Formula, binding: Binding) -> int:
        """Return the positions at which a piece of length 1 satisfies the formula."""
        if not self.is_temporal(formula):
            return self.find_state_positions(formula, binding)
        match formula:
            case f.Next():
                return 0
            case f.Then(parts):
                return self._find_single_positions(parts[0], binding) if len(parts) == 1 else 0
            case f.Eventually(operand) | f.Always(operand) | f.Until(right=operand):
                return self._find_single_positions(operand, binding)
            case _:
                return self._combine(formula, binding, self._find_single_positions, self._trace.length - 1)

    def _find_table(self, formula: f.Formula, binding: Binding) -> list[int]:
        key = (id(formula), frozenset(binding.items()))
        if key not in self._tables:
            self._tables[key] = self._compute_table(formula, binding)
        return self._tables[key]

    def _compute_table(self, formula: f.Formula, binding: Binding) -> list[int]:
        """Compute the start positions of pieces for every end. Parts of connectives are computed first."""
        if not self.is_temporal(formula):
            mask = self.find_state_positions(formula, binding)
            return [_up_to_last(mask & _up_to(end)) for end in range(self._trace.length)]
        match formula:
            case f.Not(operand):
                return [_up_to(end) & ~m for end, m in enumerate(self._compute_table(operand, binding))]
            case f.And(operands) | f.Or(operands):
                join = and_ if isinstance(formula, f.And) else or_
                tables = [self._compute_table(operand, binding) for operand in operands]
                return [reduce(join, masks) for masks in zip(*tables, strict=True)]
            case f.Then((*first, last)):
                return [
                    self._find_sequence_starts(first, binding, m) for m in self._compute_table(last, binding)
                ]
            case _:
                return [self.find_starts(formula, binding, end) for end in range(self._trace.length)]

    def _combine(self, formula: f.Formula, binding: Binding, evaluate: _EvaluatePart, end: int) -> int:
        everything = _up_to(end)
        match formula:
            case f.Not(operand):
                return everything & ~evaluate(operand, binding)
            case f.And(operands):
                return reduce(and_, [evaluate(operand, binding) for operand in operands], everything)
            case f.Or(operands):
                return reduce(or_, [evaluate(operand, binding) for operand in operands], 0)
            case f.Implies(premise, conclusion):
                return (everything & ~evaluate(premise, binding)) | evaluate(conclusion, binding)
            case f.ForAll(variable, body):
                return reduce(
                    and_, self._evaluate_instances(variable, body, binding, evaluate, False), everything
                )
            case f.Exists(variable, body):
                return reduce(or_, self._evaluate_instances(variable, body, binding, evaluate, True), 0)
            case f.Exactly(count, variable, body):
                return _positions_of_exactly(
                    count, self._evaluate_instances(variable, body, binding, evaluate, True), everything
                )
            case f.ForPairs():
                return self._evaluate_pairing(formula, binding, evaluate, everything)
            case _:
                raise AssertionError(f"{type(formula).__name__} is no connective")

    def _evaluate_instances(
        self, variable: f.Variable, body: f.Formula, binding: Binding, evaluate: _EvaluatePart, truth: bool
    ) -> list[int]:
        """Return the positions at which the body holds for each value that can give it the wanted truth."""
        name = variable.name
        values = self._find_candidates(variable, body, binding, truth)
        return [evaluate(body, {**binding, name: value}) for value in values]

    def _find_candidates(
        self, variable: f.Variable, body: f.Formula, binding: Binding, truth: bool
    ) -> frozenset[str]:
        """Return the values of a variable for which the body can have the wanted truth at some position."""
        domain = self._trace.domain(variable.category)
        inner = {name: value for name, value in binding.items() if name != variable.name}
        possible = support(body, variable.name, inner, truth, self._find_participants)
        return domain if possible is None else domain & possible

    def _find_participants(self, leaf: f.Atom | f.Occurs, index: int, binding: Binding) -> Set[str] | None:
        """Return the objects that occur at an argument of an action on the trace; None for an atom."""
        return self._trace.participants(leaf.action, index) if isinstance(leaf, f.Occurs) else None

    def _evaluate_pairing(
        self, formula: f.ForPairs, binding: Binding, evaluate: _EvaluatePart, everything: int
    ) -> int:
        first, second, body, count = formula.first, formula.second, formula.body, formula.count
        rows = self._trace.objects(first.category)
        columns = self._trace.objects(second.category)
        truths = [
            [0 if x == y else evaluate(body, {**binding, first.name: x, second.name: y}) for y in columns]
            for x in rows
        ]
        needed = min(len(rows), len(columns)) if count is None else count
        verdicts: dict[tuple[tuple[int, ...], ...], bool] = {}
        mask = 0
        for position in positions_in(everything):
            pairs = tuple(tuple(j for j, m in enumerate(row) if m >> position & 1) for row in truths)
            if pairs not in verdicts:
                verdicts[pairs] = sum(j is not None for j in maximum_matching(pairs)) >= needed
            mask |= verdicts[pairs] << position
        return mask


def _objects(terms: tuple[f.Term, ...], binding: Binding) -> tuple[str, ...]:
    try:
        return tuple([t.name if isinstance(t, f.Constant) else binding[t.name] for t in terms])
    except KeyError as error:
        raise InputError(f"variable {error.args[0]} is not bound by a quantifier") from None


def _up_to(end: int) -> int:
    return (2 << end) - 1


def _up_to_last(mask: int) -> int:
    """Return the mask of all positions up to the last position in a mask."""
    return (1 << mask.bit_length()) - 1


def _positions_until(left: int, right: int) -> int:
    """Return the positions from which ``left`` holds up to a position of ``right``.

    Each round doubles the distance that is covered.
    """
    reach = 1
    while left:
        right |= left & (right >> reach)
        left &= left >> reach
        reach *= 2
    return right


def _positions_of_exactly(count: int, masks: list[int], everything: int) -> int:
    """Return the positions that are in exactly ``count`` masks.

    A binary counter adds the masks. Each digit is a mask of positions.
    """
    digits: list[int] = []
    for mask in masks:
        carry = mask
        for i, digit in enumerate(digits):
            digits[i], carry = digit ^ carry, digit & carry
        if carry:
            digits.append(carry)
    if count >> len(digits):
        return 0
    return reduce(and_, [d if count >> i & 1 else everything & ~d for i, d in enumerate(digits)], everything)


PossibleArguments: TypeAlias = Callable[[f.Atom | f.Occurs, int, Binding], Set[str] | None]
"""Function that returns the objects that can be argument number i of a true atom; None if any object can."""


def support(
    formula: f.Formula, variable: str, binding: Binding, truth: bool, possible_arguments: PossibleArguments
) -> Set[str] | None:
    """Return a superset of the values of a variable that can give the formula this truth.

    Args:
        formula: the formula.
        variable: the variable.
        binding: the values of variables bound further out; ``variable`` is not among them.
        truth: the truth that the formula should have at some position.
        possible_arguments: returns the objects that may be an argument of a true atom or action.

    Returns:
        The set, or None if every object would have to be tried.
    """

    def support_of(operand: f.Formula, wanted: bool) -> Set[str] | None:
        return support(operand, variable, binding, wanted, possible_arguments)

    match formula:
        case f.Atom(_, arguments) | f.Occurs(_, arguments) if truth and f.Variable(variable) in arguments:
            return possible_arguments(formula, arguments.index(f.Variable(variable)), binding)
        case f.Equals(left, right) if truth:
            return _equal_to(left, right, variable, binding)
        case f.Not(operand):
            return support_of(operand, not truth)
        case f.And(operands) | f.Or(operands):
            supports = [support_of(operand, truth) for operand in operands]
            return (
                _find_smallest(supports) if isinstance(formula, f.And) == truth else unite_supports(supports)
            )
        case f.Implies(premise, conclusion):
            return support_of(f.Or((f.Not(premise), conclusion)), truth)
        case f.Exists(inner, body) | f.ForAll(inner, body):
            # A body restricts values only if some value must give it this truth: the domain may be empty.
            if isinstance(formula, f.Exists) != truth or inner.name == variable:
                return None
            outer = {name: value for name, value in binding.items() if name != inner.name}
            return support(body, variable, outer, truth, possible_arguments)
        case f.Next(operand) | f.Until(right=operand) if truth:
            return support_of(operand, truth)
        case f.Eventually(operand) | f.Always(operand):
            return support_of(operand, truth)
        case f.Then(parts) if truth:
            return _find_smallest(support_of(operand, truth) for operand in parts)
        case _:
            return None


def _equal_to(left: f.Term, right: f.Term, variable: str, binding: Binding) -> Set[str] | None:
    for term, other in ((left, right), (right, left)):
        if term == f.Variable(variable):
            if isinstance(other, f.Constant):
                return {other.name}
            if other.name in binding:
                return {binding[other.name]}
    return None


def _find_smallest(supports: Iterable[Set[str] | None]) -> Set[str] | None:
    return min((objects for objects in supports if objects is not None), key=len, default=None)


def unite_supports(supports: Iterable[Set[str] | None]) -> Set[str] | None:
    """Return the union of supports: any part may make the formula true. None if one support is None."""
    union: Set[str] = frozenset()
    for objects in supports:
        if objects is None:
            return None
        union |= objects
    return union


@dataclass(frozen=True, slots=True)
class _Evidence:
    """The verdict on a formula, with its evidence.

    Attributes:
        holds: whether the formula holds.
        positions: for a state formula, every position at which it holds. For ``then``, the positions at which
            its parts were first completed one after the other, up to the first part that was not. For any
            other formula, every position from which the rest of the trace satisfies it.
        failed: the smallest parts that make the formula false. These are the conjuncts that never hold; or a
            conjunction whose conjuncts never hold together; or the first part of a ``then`` that is not
            completed after the parts before it; otherwise the formula itself.
    """

    holds: bool
    positions: tuple[int, ...]
    failed: tuple[f.Formula, ...] = ()


@dataclass(frozen=True, slots=True)
class _ViolatedPart:
    """A violated part of a formula, and the position at which it should have held; None for any position."""

    part: f.Formula
    position: int | None


def find_violation(formula: f.Formula, trace: Trace) -> _ViolatedPart:
    """Return the violated subformula of a formula that does not hold on the trace.

    For always and until, the violated subformula is the body or left side, with the first position of its
    failure. If the left side of an until always holds, the right side is violated. For a conjunction, the
    first false conjunct is violated. If all conjuncts hold, but only apart from each other, the conjunction
    is violated.
    """
    evaluator, end = _Evaluator(formula, trace), trace.length - 1
    match formula:
        case f.And(parts) if parts:
            failing = [part for part in parts if not evaluator.find_starts(part, {}, end) & 1]
            return find_violation(failing[0], trace) if failing else _ViolatedPart(formula, None)
        case f.Always(body) | f.Until(left=body):
            violations = ~evaluator.find_positions(body, {}, end) & ((2 << end) - 1)
            if violations:
                return _ViolatedPart(body, next(positions_in(violations)))
            return _ViolatedPart(formula.right if isinstance(formula, f.Until) else body, None)
        case _:
            return _ViolatedPart(explain(formula, trace).failed[0], None)


def explain(formula: f.Formula, trace: Trace) -> _Evidence:
    """Evaluate a closed formula on the trace, and return the evidence.

    Raises:
        InputError: a variable is not bound by any quantifier.
    """
    evaluator, end = _Evaluator(formula, trace), trace.length - 1
    if isinstance(formula, f.Then) and formula.parts:
        return _explain_sequence(
            formula, bool(evaluator.find_starts(formula, {}, end) & 1), evaluator, trace, 0
        )
    failed = _find_blamed_parts(formula, evaluator, trace, 0)
    mask = (
        evaluator.find_starts(formula, {}, end)
        if evaluator.is_temporal(formula)
        else evaluator.find_state_positions(formula, {})
    )
    return _Evidence(not failed, tuple(positions_in(mask)), failed)


def _find_blamed_parts(
    formula: f.Formula, evaluator: _Evaluator, trace: Trace, start: int
) -> tuple[f.Formula, ...]:
    """Return the parts of a formula that make it false from ``start`` on; () if it holds."""
    if evaluator.find_starts(formula, {}, trace.length - 1) >> start & 1:
        return ()
    match formula:
        case f.Then(parts) if parts:
            return _explain_sequence(formula, False, evaluator, trace, start).failed
        case f.And(operands):
            blamed = [_find_blamed_parts(operand, evaluator, trace, start) for operand in operands]
            return tuple([culprit for parts in blamed for culprit in parts]) or (formula,)
        case _:
            return (formula,)


def _explain_sequence(
    formula: f.Then, holds: bool, evaluator: _Evaluator, trace: Trace, start: int
) -> _Evidence:
    """Complete the parts of a ``then`` one after the other, each as early as possible."""
    positions: list[int] = []
    for part in formula.parts:
        last = _find_first_completion(part, evaluator, trace, start)
        if last is None:
            if holds:  # some part before this one must be completed at a later position
                return _Evidence(True, tuple(positions))
            blamed = _find_blamed_parts(part, evaluator, trace, start) if start < trace.length else ()
            return _Evidence(False, tuple(positions), blamed or (part,))
        positions.append(last)
        start = last + 1
    return _Evidence(holds, tuple(positions), () if holds else (formula,))


def _find_first_completion(part: f.Formula, evaluator: _Evaluator, trace: Trace, start: int) -> int | None:
    if not evaluator.is_temporal(part):
        rest = evaluator.find_state_positions(part, {}) >> start
        return start + (rest & -rest).bit_length() - 1 if rest else None
    ends = range(start, trace.length)
    return next((end for end in ends if evaluator.find_starts(part, {}, end) >> start & 1), None)
