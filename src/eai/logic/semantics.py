"""Evaluates formulas on traces, and explains the result (paper, section "LTL representation of goals").

A state formula holds on a trace if it holds at some position. ``f then g`` holds if the trace can be cut into
two nonempty segments, so that ``f`` holds on the first and ``g`` on the second. And, or, not and quantifiers
around ``then`` combine the truth values of their parts on the same trace, as usual. The temporal operators
that the paper lacks are about positions, as usual in LTL on finite traces (De Giacomo and Vardi 2013). Below
next, eventually, always and until, a state formula means "at this position". Outside of other operators,
these four operators mean "at the first position".

Every subformula is evaluated once for all positions, as a mask of positions, so that connectives are integer
operations. In ``f then g``, the segment of ``f`` may end anywhere. Formulas without not, always, implies and
forn over ``then`` cannot become false when their segment grows. So only the last possible end is tried for
these formulas. For formulas that cannot become false when their segment shrinks, only the first end is tried.
All other formulas are evaluated on every segment, which multiplies the time by the length of the trace.

A quantifier tries only objects for which its body can have the wanted truth
(`find_possible_values_of_variable`). So ``exists x. exists y. (pour(x, y))`` on a trace with one pouring
does not try 290 times 290 pairs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial, reduce
from operator import and_, or_
from typing import TypeAlias

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.logic.matching import find_maximum_matching
from eai.logic.trace import PositionMask, Trace, iterate_positions
from eai.logic.traversal import find_subformula_ids_monotone_in_trace_length, find_temporal_subformula_ids

Binding: TypeAlias = Mapping[str, str]
"""Mapping from names of variables to names of objects."""

_EvaluateSubformula: TypeAlias = Callable[[f.Formula, Binding], PositionMask]


def holds(formula: f.Formula, trace: Trace) -> bool:
    """Whether a closed formula holds on the trace.

    Raises:
        InputError: a variable is not bound by any quantifier.
    """
    evaluator = _TraceEvaluator(formula, trace)
    return bool(evaluator.find_starts_of_satisfying_segments(formula, {}, evaluator.last_position) & 1)


class _TraceEvaluator:
    """Evaluates the subformulas of one formula on one trace."""

    def __init__(self, formula: f.Formula, trace: Trace) -> None:
        self._trace = trace
        self.last_position = trace.length - 1
        self._formula = formula  # keeps the subformulas alive, so that their ids stay unique
        self._temporal = find_temporal_subformula_ids(formula)
        self._monotony = find_subformula_ids_monotone_in_trace_length(formula)
        self._closed: dict[int, int] = {}
        self._tables: dict[tuple[int, frozenset[tuple[str, str]]], list[int]] = {}

    def is_temporal(self, formula: f.Formula) -> bool:
        """Whether a subformula has a temporal operator."""
        return id(formula) in self._temporal

    def get_state_formula_mask(self, formula: f.Formula, binding: Binding) -> PositionMask:
        """Return the mask of positions at which a state formula holds."""
        if binding:
            return self._compute_state_formula_mask(formula, binding)
        mask = self._closed.get(id(formula))
        if mask is None:
            mask = self._closed[id(formula)] = self._compute_state_formula_mask(formula, binding)
        return mask

    def _compute_state_formula_mask(self, formula: f.Formula, binding: Binding) -> PositionMask:
        match formula:
            case f.Atom(predicate, arguments):
                return self._trace.find_positions_of_atom(predicate, _resolve_terms(arguments, binding))
            case f.Occurs(action, arguments):
                return self._trace.find_positions_of_action(action, _resolve_terms(arguments, binding))
            case f.Equals(left, right):
                a, b = _resolve_terms((left, right), binding)
                return _make_mask_up_to(self.last_position) if a == b else 0
            case _:
                return self._combine_subformula_masks(
                    formula, binding, self.get_state_formula_mask, self.last_position
                )

    def compute_mask_on_prefix(self, formula: f.Formula, binding: Binding, end: int) -> PositionMask:
        """Return the mask of positions at which the formula holds if the trace stops at position ``end``."""
        if not self.is_temporal(formula):
            return self.get_state_formula_mask(formula, binding) & _make_mask_up_to(end)
        match formula:
            case f.Next(operand):
                return self.compute_mask_on_prefix(operand, binding, end) >> 1
            case f.Eventually(operand):
                return _fill_mask_up_to_last(self.compute_mask_on_prefix(operand, binding, end))
            case f.Always(operand):
                everything = _make_mask_up_to(end)
                return everything & ~_fill_mask_up_to_last(
                    everything & ~self.compute_mask_on_prefix(operand, binding, end)
                )
            case f.Until(left, right):
                return _compute_until_mask(
                    self.compute_mask_on_prefix(left, binding, end),
                    self.compute_mask_on_prefix(right, binding, end),
                )
            case f.Then(parts):
                last = (
                    self.find_starts_of_satisfying_segments(parts[-1], binding, end)
                    if parts
                    else _make_mask_up_to(end)
                )
                return self._find_starts_of_adjacent_segments(parts[:-1], binding, last)
            case _:
                return self._combine_subformula_masks(
                    formula, binding, partial(self.compute_mask_on_prefix, end=end), end
                )

    def find_starts_of_satisfying_segments(
        self, formula: f.Formula, binding: Binding, end: int
    ) -> PositionMask:
        """Return the mask of starts of segments of the trace that end at ``end`` and satisfy the formula."""
        if not self.is_temporal(formula):
            return _fill_mask_up_to_last(
                self.get_state_formula_mask(formula, binding) & _make_mask_up_to(end)
            )
        if isinstance(formula, (f.Next, f.Eventually, f.Always, f.Until, f.Then)):
            return self.compute_mask_on_prefix(formula, binding, end)
        return self._combine_subformula_masks(
            formula, binding, partial(self.find_starts_of_satisfying_segments, end=end), end
        )

    def _find_starts_of_adjacent_segments(
        self, parts: Sequence[f.Formula], binding: Binding, starts_of_following_segment: PositionMask
    ) -> PositionMask:
        """Return the mask of positions at which a sequence of adjacent segments of the trace can start.

        The first segment satisfies the first part, and so on. The last segment ends just before a position of
        the mask ``starts_of_following_segment``.
        """
        for part in reversed(parts):
            starts_of_following_segment = self._find_starts_of_satisfying_segments_before(
                part, binding, starts_of_following_segment
            )
        return starts_of_following_segment

    def _find_starts_of_satisfying_segments_before(
        self, formula: f.Formula, binding: Binding, starts_of_following_segment: PositionMask
    ) -> PositionMask:
        """Return the mask of starts of segments of the trace that satisfy the formula.

        Only segments count that end just before a position of the mask ``starts_of_following_segment``.
        """
        ends = starts_of_following_segment >> 1
        # A formula that stays true when a segment is extended is tested only on the longest segment.
        if id(formula) in self._monotony.ids_staying_true_when_longer:
            if ends:
                return self.find_starts_of_satisfying_segments(formula, binding, ends.bit_length() - 1)
            return 0
        # If shortened segments keep a formula true, a segment satisfies it only if its first state does.
        # If segments may also end anywhere up to the last end, segments of one state are enough.
        if id(formula) in self._monotony.ids_staying_true_when_shorter and ends == _fill_mask_up_to_last(
            ends
        ):
            return self._find_satisfying_one_state_segments(formula, binding) & ends
        table = self._get_satisfying_segment_starts_by_end(formula, binding)
        return reduce(or_, [table[end] for end in iterate_positions(ends)], 0)

    def _find_satisfying_one_state_segments(self, formula: f.Formula, binding: Binding) -> PositionMask:
        """Return the mask of the positions at which a segment of one state satisfies the formula."""
        if not self.is_temporal(formula):
            return self.get_state_formula_mask(formula, binding)
        match formula:
            case f.Next():
                return 0
            case f.Then(()):
                return _make_mask_up_to(self.last_position)
            case f.Then(parts):
                return self._find_satisfying_one_state_segments(parts[0], binding) if len(parts) == 1 else 0
            case f.Eventually(operand) | f.Always(operand) | f.Until(right=operand):
                return self._find_satisfying_one_state_segments(operand, binding)
            case _:
                return self._combine_subformula_masks(
                    formula, binding, self._find_satisfying_one_state_segments, self.last_position
                )

    def _get_satisfying_segment_starts_by_end(
        self, formula: f.Formula, binding: Binding
    ) -> list[PositionMask]:
        key = (id(formula), frozenset(binding.items()))
        if key not in self._tables:
            self._tables[key] = self._compute_satisfying_segment_starts_by_end(formula, binding)
        return self._tables[key]

    def _compute_satisfying_segment_starts_by_end(
        self, formula: f.Formula, binding: Binding
    ) -> list[PositionMask]:
        """Return, for each position, the mask of starts of segments of the trace that end at this position.

        Only segments that satisfy the formula count. Masks for operands of connectives are computed first.
        """
        if not self.is_temporal(formula):
            mask = self.get_state_formula_mask(formula, binding)
            return [_fill_mask_up_to_last(mask & _make_mask_up_to(end)) for end in range(self._trace.length)]
        match formula:
            case f.Not(operand):
                return [
                    _make_mask_up_to(end) & ~m
                    for end, m in enumerate(self._get_satisfying_segment_starts_by_end(operand, binding))
                ]
            case f.And(operands) | f.Or(operands):
                join = and_ if isinstance(formula, f.And) else or_
                tables = [
                    self._get_satisfying_segment_starts_by_end(operand, binding) for operand in operands
                ]
                return [reduce(join, masks) for masks in zip(*tables, strict=True)]
            case f.Then((*first, last)):
                return [
                    self._find_starts_of_adjacent_segments(first, binding, m)
                    for m in self._get_satisfying_segment_starts_by_end(last, binding)
                ]
            case _:
                return [
                    self.find_starts_of_satisfying_segments(formula, binding, end)
                    for end in range(self._trace.length)
                ]

    def _combine_subformula_masks(
        self, formula: f.Formula, binding: Binding, evaluate: _EvaluateSubformula, last_position: int
    ) -> PositionMask:
        everything = _make_mask_up_to(last_position)
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
                    and_,
                    self._compute_body_masks_for_possible_values(variable, body, binding, evaluate, False),
                    everything,
                )
            case f.Exists(variable, body):
                return reduce(
                    or_,
                    self._compute_body_masks_for_possible_values(variable, body, binding, evaluate, True),
                    0,
                )
            case f.Exactly(count, variable, body):
                return _compute_exact_count_mask(
                    count,
                    self._compute_body_masks_for_possible_values(variable, body, binding, evaluate, True),
                    everything,
                )
            case f.ForPairs():
                return self._compute_mask_of_pairs_quantifier(formula, binding, evaluate, everything)
            case _:
                raise AssertionError(f"{type(formula).__name__}: expected a connective or a quantifier")

    def _compute_body_masks_for_possible_values(
        self,
        variable: f.Variable,
        body: f.Formula,
        binding: Binding,
        evaluate: _EvaluateSubformula,
        wanted_truth: bool,
    ) -> list[PositionMask]:
        """Return for each value of a quantified variable the mask of the positions at which the body holds.

        There may be no mask for a value with which the body never has the truth value ``wanted_truth``.
        """
        name = variable.name
        values = self._find_possible_values_of_variable(variable, body, binding, wanted_truth)
        return [evaluate(body, {**binding, name: value}) for value in values]

    def _find_possible_values_of_variable(
        self, variable: f.Variable, body: f.Formula, binding: Binding, wanted_truth: bool
    ) -> frozenset[str]:
        """Return values of a variable for which the body may have the wanted truth somewhere on the trace."""
        domain = self._trace.get_object_set(variable.category)
        inner = {name: value for name, value in binding.items() if name != variable.name}
        possible = find_possible_values_of_variable(
            body, variable.name, inner, wanted_truth, self._find_objects_filling_argument_on_trace
        )
        return domain if possible is None else domain & possible

    def _find_objects_filling_argument_on_trace(
        self, leaf: f.Atom | f.Occurs, argument_index: int, binding: Binding
    ) -> Set[str] | None:
        """Return the objects that occur as an argument of an action in the evaluated trace.

        For an atom (a condition on states), return None: it may be true of any object.
        """
        if isinstance(leaf, f.Occurs):
            return self._trace.find_values_of_argument(leaf.action, argument_index)
        return None

    def _compute_mask_of_pairs_quantifier(
        self,
        formula: f.ForPairs,
        binding: Binding,
        evaluate: _EvaluateSubformula,
        all_positions: PositionMask,
    ) -> PositionMask:
        first, second, body, count = formula.first, formula.second, formula.body, formula.count
        rows = self._trace.list_objects(first.category)
        columns = self._trace.list_objects(second.category)
        truths = [
            [0 if x == y else evaluate(body, {**binding, first.name: x, second.name: y}) for y in columns]
            for x in rows
        ]
        needed = min(len(rows), len(columns)) if count is None else count
        verdicts: dict[tuple[tuple[int, ...], ...], bool] = {}
        mask = 0
        for position in iterate_positions(all_positions):
            pairs = tuple(tuple(j for j, m in enumerate(row) if m >> position & 1) for row in truths)
            if pairs not in verdicts:
                verdicts[pairs] = sum(j is not None for j in find_maximum_matching(pairs)) >= needed
            mask |= verdicts[pairs] << position
        return mask


def _resolve_terms(terms: tuple[f.Term, ...], binding: Binding) -> tuple[str, ...]:
    try:
        return tuple([t.name if isinstance(t, f.Constant) else binding[t.name] for t in terms])
    except KeyError as error:
        raise InputError(f"variable {error.args[0]} is not bound: bind it with exists or forall") from None


def _make_mask_up_to(end: int) -> PositionMask:
    return (2 << end) - 1


def _fill_mask_up_to_last(mask: PositionMask) -> PositionMask:
    """Return the mask of all positions from 0 up to the last position of a mask."""
    return (1 << mask.bit_length()) - 1


def _compute_until_mask(left: PositionMask, right: PositionMask) -> PositionMask:
    """Return the positions from which ``left`` holds until a position of ``right``; all three are bit masks.

    Each round of the loop doubles the distance to the position of ``right``.
    """
    reach = 1
    while left:
        right |= left & (right >> reach)
        left &= left >> reach
        reach *= 2
    return right


def _compute_exact_count_mask(
    count: int, masks: list[PositionMask], everything: PositionMask
) -> PositionMask:
    """Return the mask of the positions that are in exactly ``count`` masks.

    The masks that contain a position are counted in binary, for all positions at once. Bit p of
    ``digits[i]`` is binary digit i of the count for position p.
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


FindPossibleArguments: TypeAlias = Callable[[f.Atom | f.Occurs, int, Binding], Set[str] | None]
"""Function that returns the names of the objects that can be argument number i of an atom or action.

It returns only objects with which the atom or action can be true; None means any object. Its arguments are
the atom or action, i, and the values of the variables that are bound.
"""


def find_possible_values_of_variable(
    formula: f.Formula,
    variable: str,
    binding: Binding,
    wanted_truth: bool,
    find_arguments: FindPossibleArguments,
) -> Set[str] | None:
    """Return all values of a variable for which a formula can have the truth ``wanted_truth``.

    The result may also contain values for which the formula cannot have this truth.

    Args:
        formula: the formula.
        variable: name of the variable.
        binding: the values of variables bound further out, without ``variable``.
        wanted_truth: the truth that the formula should have at some position of a trace.
        find_arguments: function that returns the objects that may be an argument of a true atom or
            action.

    Returns:
        The set of values, or None if every object must be tried.
    """

    def find_variable_values_for_operand_truth(operand: f.Formula, wanted_truth: bool) -> Set[str] | None:
        return find_possible_values_of_variable(operand, variable, binding, wanted_truth, find_arguments)

    match formula:
        case f.Atom(_, arguments) | f.Occurs(_, arguments) if (
            wanted_truth and f.Variable(variable) in arguments
        ):
            return find_arguments(formula, arguments.index(f.Variable(variable)), binding)
        case f.Equals(left, right) if wanted_truth:
            return _find_values_making_terms_equal(left, right, variable, binding)
        case f.Not(operand):
            return find_variable_values_for_operand_truth(operand, not wanted_truth)
        case f.And(operands) | f.Or(operands):
            value_sets = [
                find_variable_values_for_operand_truth(operand, wanted_truth) for operand in operands
            ]
            return (
                _find_smallest_set(value_sets)
                if isinstance(formula, f.And) == wanted_truth
                else unite_value_sets(value_sets)
            )
        case f.Implies(premise, conclusion):
            return find_variable_values_for_operand_truth(f.Or((f.Not(premise), conclusion)), wanted_truth)
        case f.Exists(inner, body) | f.ForAll(inner, body):
            # With no values for the inner variable, forall is true and exists is false in any case.
            if isinstance(formula, f.Exists) != wanted_truth or inner.name == variable:
                return None
            outer = {name: value for name, value in binding.items() if name != inner.name}
            return find_possible_values_of_variable(body, variable, outer, wanted_truth, find_arguments)
        case f.Next(operand) | f.Until(right=operand) if wanted_truth:
            return find_variable_values_for_operand_truth(operand, wanted_truth)
        case f.Eventually(operand) | f.Always(operand):
            return find_variable_values_for_operand_truth(operand, wanted_truth)
        case f.Then(parts) if wanted_truth:
            return _find_smallest_set(
                find_variable_values_for_operand_truth(operand, wanted_truth) for operand in parts
            )
        case _:
            return None


def _find_values_making_terms_equal(
    left: f.Term, right: f.Term, variable: str, binding: Binding
) -> Set[str] | None:
    for term, other in ((left, right), (right, left)):
        if term == f.Variable(variable):
            if isinstance(other, f.Constant):
                return {other.name}
            if other.name in binding:
                return {binding[other.name]}
    return None


def _find_smallest_set(value_sets: Iterable[Set[str] | None]) -> Set[str] | None:
    return min((objects for objects in value_sets if objects is not None), key=len, default=None)


def unite_value_sets(value_sets: Iterable[Set[str] | None]) -> Set[str] | None:
    """Return the union of sets of values, for a formula that is true if any part is true.

    If any of the sets is None, the result is None: every object must be tried.
    """
    union: Set[str] = frozenset()
    for objects in value_sets:
        if objects is None:
            return None
        union |= objects
    return union


@dataclass(frozen=True, slots=True)
class _TruthWithExplanation:
    """The truth of a formula on a trace, and the explanation.

    Attributes:
        holds: whether the formula holds.
        positions: the positions that explain the truth. A state formula lists every position at which it
            holds. A ``then`` lists the position at which each part was first completed after the previous
            part, up to the first part that was not completed. Every other formula lists the start of every
            suffix of the trace that satisfies it.
        failed: the smallest parts that make the formula false. They are the conjuncts of a conjunction that
            never hold, or the conjunction if its conjuncts hold only at different positions. Of a ``then`` it
            is the first part that is not completed after the previous part. Otherwise it is the formula.
    """

    holds: bool
    positions: tuple[int, ...]
    failed: tuple[f.Formula, ...] = ()


@dataclass(frozen=True, slots=True)
class _ViolatedSubformula:
    """A violated part of a formula, and the position at which it should have held (None: at any position)."""

    part: f.Formula
    position: int | None


def find_violation(formula: f.Formula, trace: Trace) -> _ViolatedSubformula:
    """Return the violated part of a formula that does not hold on the trace.

    - ``always``: its body, with the first position at which the body is false.
    - ``until``: its left side, with the first position at which this side is false. If the left side always
      holds: its right side.
    - Conjunction: the violated part of the first conjunct that does not hold on the trace. If each conjunct
      holds at some position, but never all of them at one position: the conjunction.
    """
    evaluator = _TraceEvaluator(formula, trace)
    end = evaluator.last_position
    match formula:
        case f.And(parts) if parts:
            failing = [
                part for part in parts if not evaluator.find_starts_of_satisfying_segments(part, {}, end) & 1
            ]
            return find_violation(failing[0], trace) if failing else _ViolatedSubformula(formula, None)
        case f.Always(body) | f.Until(left=body):
            violations = ~evaluator.compute_mask_on_prefix(body, {}, end) & ((2 << end) - 1)
            if violations:
                return _ViolatedSubformula(body, next(iterate_positions(violations)))
            return _ViolatedSubformula(formula.right if isinstance(formula, f.Until) else body, None)
        case _:
            return _ViolatedSubformula(explain_truth(formula, trace).failed[0], None)


def explain_truth(formula: f.Formula, trace: Trace) -> _TruthWithExplanation:
    """Evaluate a closed formula on the trace, and return its truth with an explanation.

    Raises:
        InputError: a variable is not bound by any quantifier.
    """
    evaluator = _TraceEvaluator(formula, trace)
    starts = evaluator.find_starts_of_satisfying_segments(formula, {}, evaluator.last_position)
    is_true = bool(starts & 1)
    if isinstance(formula, f.Then) and formula.parts:
        return _explain_sequence(formula, is_true, evaluator, 0)
    failed = () if is_true else _find_smallest_false_parts(formula, evaluator, 0)
    mask = starts if evaluator.is_temporal(formula) else evaluator.get_state_formula_mask(formula, {})
    return _TruthWithExplanation(is_true, tuple(iterate_positions(mask)), failed)


def _find_smallest_false_parts(
    formula: f.Formula, evaluator: _TraceEvaluator, start: int
) -> tuple[f.Formula, ...]:
    """Return the smallest parts that make a formula false from position ``start`` on; () if it holds."""
    if evaluator.find_starts_of_satisfying_segments(formula, {}, evaluator.last_position) >> start & 1:
        return ()
    match formula:
        case f.Then(parts) if parts:
            return _explain_sequence(formula, False, evaluator, start).failed
        case f.And(operands):
            blamed = [_find_smallest_false_parts(operand, evaluator, start) for operand in operands]
            return tuple([culprit for parts in blamed for culprit in parts]) or (formula,)
        case _:
            return (formula,)


def _explain_sequence(
    formula: f.Then, is_true: bool, evaluator: _TraceEvaluator, start: int
) -> _TruthWithExplanation:
    """Explain a ``then`` from position ``start`` on. Find the earliest end of each part in turn."""
    positions: list[int] = []
    for part in formula.parts:
        last = _find_first_end_of_satisfying_segment(part, evaluator, start)
        if last is None:
            if is_true:  # the formula holds, but only if an earlier part ends later than here
                return _TruthWithExplanation(True, tuple(positions))
            blamed = (
                _find_smallest_false_parts(part, evaluator, start) if start <= evaluator.last_position else ()
            )
            return _TruthWithExplanation(False, tuple(positions), blamed or (part,))
        positions.append(last)
        start = last + 1
    return _TruthWithExplanation(is_true, tuple(positions), () if is_true else (formula,))


def _find_first_end_of_satisfying_segment(
    part: f.Formula, evaluator: _TraceEvaluator, start: int
) -> int | None:
    if not evaluator.is_temporal(part):
        rest = evaluator.get_state_formula_mask(part, {}) >> start
        return start + (rest & -rest).bit_length() - 1 if rest else None
    ends = range(start, evaluator.last_position + 1)
    return next(
        (end for end in ends if evaluator.find_starts_of_satisfying_segments(part, {}, end) >> start & 1),
        None,
    )
