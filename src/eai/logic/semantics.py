"""When a formula holds on a trace, and why or why not (paper, section "LTL representation of goals").

A state formula holds on a trace if it holds at some position of it. ``f then g`` holds if the trace
can be cut into two non-empty pieces, the first satisfying ``f`` and the second ``g``. And, or, not and the
quantifiers of formulas with ``then`` are what they are everywhere: they combine the truths of their parts on
the same trace. The operators beyond the paper speak of positions, as usual in LTL on finite traces (De
Giacomo and Vardi 2013): below next, eventually, always and until a state formula means "at this position",
and at the top these operators mean "at the first position".

Every subformula is evaluated once for all positions at a time, as a mask of positions, so that connectives
are integer operations. The piece of an operand in front of ``then`` may end anywhere. If the operand cannot
become false when its piece grows (as all formulas without not, always, implies and forn over ``then``), only
the last possible end counts; if it cannot when the piece shrinks, only the first. What mixes both needs its
truth on every piece, which costs a factor of the trace's length.

Of a quantifier only those objects are tried for which its body can be true, or false, at all (`support`):
``exists x. exists y. (pour(x, y))`` on a trace with one pouring need not try 290 times 290 pairs.
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
"""Objects by the variables that stand for them."""

_Reading: TypeAlias = Callable[[f.Formula, Binding], int]


def holds(formula: f.Formula, trace: Trace) -> bool:
    """Whether a closed formula holds on the trace.

    Raises:
        InputError: a variable is not bound by any quantifier.
    """
    evaluator = _Evaluator(formula, trace)
    return bool(evaluator.on(formula, {}, trace.length - 1) & 1)


class _Evaluator:
    """Evaluates the parts of one formula on one trace."""

    def __init__(self, formula: f.Formula, trace: Trace) -> None:
        self._trace = trace
        self._formula = formula  # keeps the ids below alive
        self._temporal = temporal_parts(formula)
        self._monotony = monotony(formula)
        self._closed: dict[int, int] = {}
        self._tables: dict[tuple[int, frozenset[tuple[str, str]]], list[int]] = {}

    def is_temporal(self, formula: f.Formula) -> bool:
        """Whether a part of the formula speaks of more than one position."""
        return id(formula) in self._temporal

    def state(self, formula: f.Formula, binding: Binding) -> int:
        """The positions at which a state formula holds."""
        if binding:
            return self._state(formula, binding)
        mask = self._closed.get(id(formula))
        if mask is None:
            mask = self._closed[id(formula)] = self._state(formula, binding)
        return mask

    def _state(self, formula: f.Formula, binding: Binding) -> int:
        match formula:
            case f.Atom(predicate, arguments):
                return self._trace.atom(predicate, _objects(arguments, binding))
            case f.Occurs(action, arguments):
                return self._trace.occurrence(action, _objects(arguments, binding))
            case f.Equals(left, right):
                a, b = _objects((left, right), binding)
                return _up_to(self._trace.length - 1) if a == b else 0
            case _:
                return self._combined(formula, binding, self.state, self._trace.length - 1)

    def at(self, formula: f.Formula, binding: Binding, end: int) -> int:
        """The positions of the trace that stops at ``end`` at which the formula holds, read there."""
        if not self.is_temporal(formula):
            return self.state(formula, binding) & _up_to(end)
        match formula:
            case f.Next(operand):
                return self.at(operand, binding, end) >> 1
            case f.Eventually(operand):
                return _before(self.at(operand, binding, end))
            case f.Always(operand):
                everything = _up_to(end)
                return everything & ~_before(everything & ~self.at(operand, binding, end))
            case f.Until(left, right):
                return _until(self.at(left, binding, end), self.at(right, binding, end))
            case f.Then(parts):
                last = self.on(parts[-1], binding, end) if parts else _up_to(end)
                return self._preceded(parts[:-1], binding, last)
            case _:
                return self._combined(formula, binding, partial(self.at, end=end), end)

    def on(self, formula: f.Formula, binding: Binding, end: int) -> int:
        """The positions from which the rest of the trace, stopping at ``end``, satisfies the formula."""
        if not self.is_temporal(formula):
            return _before(self.state(formula, binding) & _up_to(end))
        if isinstance(formula, (f.Next, f.Eventually, f.Always, f.Until, f.Then)):
            return self.at(formula, binding, end)
        return self._combined(formula, binding, partial(self.on, end=end), end)

    def _preceded(self, parts: Sequence[f.Formula], binding: Binding, starts: int) -> int:
        """The positions from which consecutive pieces satisfy the parts, up to just before a start."""
        for part in reversed(parts):
            starts = self._followed_by(part, binding, starts)
        return starts

    def _followed_by(self, formula: f.Formula, binding: Binding, rest: int) -> int:
        """The positions from which a piece satisfies the formula and the next position is in ``rest``."""
        ends = rest >> 1
        if id(formula) in self._monotony.lasting:  # the last end is the best one
            return self.on(formula, binding, ends.bit_length() - 1) if ends else 0
        if id(formula) in self._monotony.perishing and ends == _before(ends):  # the first end is
            return self._alone(formula, binding) & ends
        table = self._table(formula, binding)
        return reduce(or_, [table[end] for end in positions_in(ends)], 0)

    def _alone(self, formula: f.Formula, binding: Binding) -> int:
        """The positions that satisfy the formula as pieces of length 1."""
        if not self.is_temporal(formula):
            return self.state(formula, binding)
        match formula:
            case f.Next():
                return 0
            case f.Then(parts):
                return self._alone(parts[0], binding) if len(parts) == 1 else 0
            case f.Eventually(operand) | f.Always(operand) | f.Until(right=operand):
                return self._alone(operand, binding)
            case _:
                return self._combined(formula, binding, self._alone, self._trace.length - 1)

    def _table(self, formula: f.Formula, binding: Binding) -> list[int]:
        """For every end, the positions from which the piece up to it satisfies the formula."""
        key = (id(formula), frozenset(binding.items()))
        if key not in self._tables:
            self._tables[key] = self._for_all_ends(formula, binding)
        return self._tables[key]

    def _for_all_ends(self, formula: f.Formula, binding: Binding) -> list[int]:
        """The masks that `on` gives for every end, the parts of connectives being read for all ends first."""
        if not self.is_temporal(formula):
            mask = self.state(formula, binding)
            return [_before(mask & _up_to(end)) for end in range(self._trace.length)]
        match formula:
            case f.Not(operand):
                return [_up_to(end) & ~m for end, m in enumerate(self._for_all_ends(operand, binding))]
            case f.And(operands) | f.Or(operands):
                join = and_ if isinstance(formula, f.And) else or_
                tables = [self._for_all_ends(operand, binding) for operand in operands]
                return [reduce(join, masks) for masks in zip(*tables, strict=True)]
            case f.Then((*first, last)):
                return [self._preceded(first, binding, m) for m in self._for_all_ends(last, binding)]
            case _:
                return [self.on(formula, binding, end) for end in range(self._trace.length)]

    def _combined(self, formula: f.Formula, binding: Binding, read: _Reading, end: int) -> int:
        """A connective or quantifier over parts that are read in one way."""
        everything = _up_to(end)
        match formula:
            case f.Not(operand):
                return everything & ~read(operand, binding)
            case f.And(operands):
                return reduce(and_, [read(each, binding) for each in operands], everything)
            case f.Or(operands):
                return reduce(or_, [read(each, binding) for each in operands], 0)
            case f.Implies(premise, conclusion):
                return (everything & ~read(premise, binding)) | read(conclusion, binding)
            case f.ForAll(variable, body):
                return reduce(and_, self._instances(variable, body, binding, read, False), everything)
            case f.Exists(variable, body):
                return reduce(or_, self._instances(variable, body, binding, read, True), 0)
            case f.Exactly(count, variable, body):
                return _exactly(count, self._instances(variable, body, binding, read, True), everything)
            case f.ForPairs():
                return self._paired(formula, binding, read, everything)
            case _:
                raise AssertionError(f"{type(formula).__name__} is no connective")

    def _instances(
        self, variable: f.Variable, body: f.Formula, binding: Binding, read: _Reading, truth: bool
    ) -> list[int]:
        """Where the body holds, for every value that can give it this truth at all."""
        name = variable.name
        values = self._candidates(variable, body, binding, truth)
        return [read(body, {**binding, name: value}) for value in values]

    def _candidates(
        self, variable: f.Variable, body: f.Formula, binding: Binding, truth: bool
    ) -> frozenset[str]:
        """The values of a variable for which the body can have this truth at some position."""
        domain = self._trace.domain(variable.category)
        inner = {name: value for name, value in binding.items() if name != variable.name}
        possible = support(body, variable.name, inner, truth, self._participants)
        return domain if possible is None else domain & possible

    def _participants(self, leaf: f.Atom | f.Occurs, place: int, binding: Binding) -> Set[str] | None:
        """The objects with which an action is ever taken; of states nothing is known without trying."""
        return self._trace.participants(leaf.action, place) if isinstance(leaf, f.Occurs) else None

    def _paired(self, formula: f.ForPairs, binding: Binding, read: _Reading, everything: int) -> int:
        """The positions at which a maximum matching of true pairs is large enough."""
        first, second, body, count = formula.first, formula.second, formula.body, formula.count
        rows = self._trace.objects(first.category)
        columns = self._trace.objects(second.category)
        truths = [
            [0 if x == y else read(body, {**binding, first.name: x, second.name: y}) for y in columns]
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
    """All positions from 0 to ``end``."""
    return (2 << end) - 1


def _before(mask: int) -> int:
    """All positions up to the last one in the mask."""
    return (1 << mask.bit_length()) - 1


def _until(left: int, right: int) -> int:
    """The positions from which ``left`` holds up to a position of ``right``; doubles its reach each round."""
    reach = 1
    while left:
        right |= left & (right >> reach)
        left &= left >> reach
        reach *= 2
    return right


def _exactly(count: int, masks: list[int], everything: int) -> int:
    """The positions that are in exactly ``count`` of the masks: a binary counter, one mask a digit."""
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
"""Tells the objects of which some may stand at a place of an atom or action that holds; None if any may."""


def support(
    formula: f.Formula, variable: str, binding: Binding, truth: bool, known: PossibleArguments
) -> Set[str] | None:
    """A set outside of which no value of the variable gives the formula this truth at any position.

    Returns None where no such set is known without trying. ``binding`` holds the values of variables bound
    further out; ``variable`` is not among them.
    """

    def of(part: f.Formula, wanted: bool) -> Set[str] | None:
        return support(part, variable, binding, wanted, known)

    match formula:
        case f.Atom(_, arguments) | f.Occurs(_, arguments) if truth and f.Variable(variable) in arguments:
            return known(formula, arguments.index(f.Variable(variable)), binding)
        case f.Equals(left, right) if truth:
            return _equal_to(left, right, variable, binding)
        case f.Not(operand):
            return of(operand, not truth)
        case f.And(operands) | f.Or(operands):
            found = [of(part, truth) for part in operands]
            return _smallest(found) if isinstance(formula, f.And) == truth else unite_supports(found)
        case f.Implies(premise, conclusion):
            return of(f.Or((f.Not(premise), conclusion)), truth)
        case f.Exists(inner, body) | f.ForAll(inner, body):
            # Only a body that must have this truth for some value says anything: a domain may be empty.
            if isinstance(formula, f.Exists) != truth or inner.name == variable:
                return None
            outer = {name: value for name, value in binding.items() if name != inner.name}
            return support(body, variable, outer, truth, known)
        case f.Next(operand) | f.Until(right=operand) if truth:
            return of(operand, truth)
        case f.Eventually(operand) | f.Always(operand):
            return of(operand, truth)
        case f.Then(parts) if truth:
            return _smallest(of(part, truth) for part in parts)
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


def _smallest(found: Iterable[Set[str] | None]) -> Set[str] | None:
    return min((objects for objects in found if objects is not None), key=len, default=None)


def unite_supports(found: Iterable[Set[str] | None]) -> Set[str] | None:
    """The union of some supports: of what is true, or false, if one of several things is."""
    union: Set[str] = frozenset()
    for objects in found:
        if objects is None:
            return None
        union |= objects
    return union


@dataclass(frozen=True, slots=True)
class _Evidence:
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
    failed: tuple[f.Formula, ...] = ()


@dataclass(frozen=True, slots=True)
class _Breach:
    """The violated part of a formula: one that should have held at a position, or (None) at some."""

    part: f.Formula
    position: int | None


def find_violation(formula: f.Formula, trace: Trace) -> _Breach:
    """The violated parts of a formula that does not hold on the trace.

    Of what must always be so, and of what must be so until something else is, the first position at which it
    is not; if that something never is, it; of a conjunction its first such part, or all of it where its parts
    hold, but only apart from each other.
    """
    evaluator, end = _Evaluator(formula, trace), trace.length - 1
    match formula:
        case f.And(parts) if parts:
            failing = [part for part in parts if not evaluator.on(part, {}, end) & 1]
            return find_violation(failing[0], trace) if failing else _Breach(formula, None)
        case f.Always(body) | f.Until(left=body):
            lacking = ~evaluator.at(body, {}, end) & ((2 << end) - 1)
            if lacking:
                return _Breach(body, next(positions_in(lacking)))
            return _Breach(formula.right if isinstance(formula, f.Until) else body, None)
        case _:
            return _Breach(explain(formula, trace).failed[0], None)


def explain(formula: f.Formula, trace: Trace) -> _Evidence:
    """Whether a closed formula holds on the trace, and the evidence.

    Raises:
        InputError: a variable is not bound by any quantifier.
    """
    evaluator, end = _Evaluator(formula, trace), trace.length - 1
    if isinstance(formula, f.Then) and formula.parts:
        return _explain_sequence(formula, bool(evaluator.on(formula, {}, end) & 1), evaluator, trace, 0)
    failed = _blame(formula, evaluator, trace, 0)
    mask = evaluator.on(formula, {}, end) if evaluator.is_temporal(formula) else evaluator.state(formula, {})
    return _Evidence(not failed, tuple(positions_in(mask)), failed)


def _blame(formula: f.Formula, evaluator: _Evaluator, trace: Trace, start: int) -> tuple[f.Formula, ...]:
    """The parts of a formula that make it not hold from ``start`` on; none if it does hold."""
    if evaluator.on(formula, {}, trace.length - 1) >> start & 1:
        return ()
    match formula:
        case f.Then(parts) if parts:
            return _explain_sequence(formula, False, evaluator, trace, start).failed
        case f.And(operands):
            blamed = [_blame(operand, evaluator, trace, start) for operand in operands]
            return tuple([culprit for each in blamed for culprit in each]) or (formula,)
        case _:
            return (formula,)


def _explain_sequence(
    formula: f.Then, holds: bool, evaluator: _Evaluator, trace: Trace, start: int
) -> _Evidence:
    """Complete the parts of a ``then`` one after the other, each as early as possible."""
    positions: list[int] = []
    for part in formula.parts:
        last = _first_completion(part, evaluator, trace, start)
        if last is None:
            if holds:  # a later completion of an earlier part makes the rest possible
                return _Evidence(True, tuple(positions))
            left = _blame(part, evaluator, trace, start) if start < trace.length else ()
            return _Evidence(False, tuple(positions), left or (part,))
        positions.append(last)
        start = last + 1
    return _Evidence(holds, tuple(positions), () if holds else (formula,))


def _first_completion(part: f.Formula, evaluator: _Evaluator, trace: Trace, start: int) -> int | None:
    """The end of the shortest piece from ``start`` on that satisfies the part, or None."""
    if not evaluator.is_temporal(part):
        rest = evaluator.state(part, {}) >> start
        return start + (rest & -rest).bit_length() - 1 if rest else None
    ends = range(start, trace.length)
    return next((end for end in ends if evaluator.on(part, {}, end) >> start & 1), None)
