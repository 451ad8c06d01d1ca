"""Find the option of a goal with the largest share of met conditions (paper, section 2, ability 3).

An option of a goal is a conjunction of conditions without variables that satisfies the goal
(`eai.logic.choice`). A goal has parts, and each part offers a choice of conditions. An option consists of one
choice for each part. The best choices for single parts together are not always the best option, because the
share is a ratio of two sums. Dinkelbach's method (1967) finds the best option. It starts from a share, and
gives each met and each unmet condition a value that depends on this share. Then it chooses the option with
the greatest sum of values, which the parts determine separately. The method repeats this with the share of
the chosen option until the share no longer grows.

The search never lists all options. A condition that several parts can choose is a common condition. It counts
once. Parts without common conditions are chosen independently. No option contains both a condition and its
negation. So for every set of chosen common conditions, the search keeps the greatest sum of values of all
other conditions. When no later part can choose a common condition, the search forgets this condition. The
effort therefore grows exponentially only with the number of common conditions that the search must remember
at the same time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from heapq import nlargest
from operator import or_
from typing import NamedTuple, TypeAlias

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.logic.choice import AllOf, AndOrTree, AndOrTreeLiteral, AndOrTreePairing, AnyOf, ExactlyOf, Literal
from eai.logic.matching import find_heaviest_matching
from eai.logic.trace import iterate_positions

_MAX_SETS = 2_000
"""Maximum number of sets of common conditions that a search keeps.

If a search drops a set, the share that it finds is only a lower bound.
"""

_MAX_UNPRUNED_SETS = 64
"""Maximum number of sets of conditions that a search keeps without looking for dominated sets among them."""

_MAX_RIVALS = 8
"""Number of the best sets of conditions. A set is dropped if one among these dominates this set."""


class _ShareOfMetConditions(NamedTuple):
    """The share of an option's conditions that hold in a state.

    Attributes:
        met: number of conditions of the option that hold.
        total: number of conditions of the option.
        is_exact: whether it is proved that no option has a larger share; False if the search dropped options.
    """

    met: int
    total: int
    is_exact: bool = True


def make_best_share_finder(parts: Sequence[AndOrTree], others: int = 0) -> _BestOptionFinder:
    """Return a function that finds the option of a goal with the largest share of met conditions.

    If several options have this share, the function finds the option with the fewest conditions.

    Args:
        parts: for each goal part, the choices of conditions that satisfy the part.
        others: number of further conditions, which every option contains.
    """
    return _BestOptionFinder(parts, others)


class _BestOptionFinder:
    """Finds the option of a goal with the largest share of met conditions.

    Attributes:
        atoms: the atoms in the goal's conditions. Condition ``2 * i`` states that atom ``i`` is true, and
            condition ``2 * i + 1`` that it is false.
    """

    def __init__(self, parts: Sequence[AndOrTree], others: int) -> None:
        numbers: dict[f.Atom | f.Occurs, int] = {}
        root = _number_conditions(AllOf(tuple(parts)), numbers)
        self.atoms = tuple(numbers)
        self._others = others
        self._positive = _make_positive_mask(len(self.atoms))
        members = root.parts if isinstance(root, AllOf) else (root,)
        self._fixed = _make_condition_mask([part for part in members if isinstance(part, int)])
        choices = tuple([part for part in members if not isinstance(part, int)])
        compiler = _OptionCompiler(choices, self._fixed, self._positive)
        self._table: _FindSets = _find_no_sets
        if not _contradicts(self._fixed, self._positive):
            self._table = compiler.compile_part(AllOf(choices))

    def __call__(self, true: int, others_met: int = 0) -> _ShareOfMetConditions:
        """Return the largest share of conditions that an option meets; 0 of 1 if the goal has no option.

        Args:
            true: the atoms that are true in the state, as a bit mask.
            others_met: number of met conditions among the further conditions, which every option contains.
        """
        best, is_exact = _ShareOfMetConditions(0, 1), True
        while True:
            option = self._find_best_share(true, others_met, best)
            is_exact = is_exact and option.is_exact
            gain = option.met * best.total - best.met * option.total
            if gain > 0:
                best = option
            else:
                return (option if gain == 0 else best)._replace(is_exact=is_exact)

    def _find_best_share(
        self, true: int, others_met: int, before: _ShareOfMetConditions
    ) -> _ShareOfMetConditions:
        """Return the share of the option with the largest gain over a share, or the latter without an option.

        The gain of an option over the share `before` is ``before.total * met - before.met * total``. If
        several options have the largest gain, the shortest counts. The search therefore maximizes ``scale *
        gain - total``, with a `scale` greater than any total.
        """
        scale = 2 * len(self.atoms) + self._others + 1
        unmet = -before.met * scale - 1
        met = unmet + before.total * scale
        values = [
            met if true >> number & 1 == wanted else unmet
            for number in range(len(self.atoms))
            for wanted in (1, 0)
        ]
        search = _OptionSearch(values)
        table = self._table(search)
        if not table:
            return before._replace(is_exact=not search.is_cut)
        value = table[0] + search.value(self._fixed) + others_met * met + (self._others - others_met) * unmet
        total = -value % scale
        gain = (value + total) // scale
        return _ShareOfMetConditions((gain + before.met * total) // before.total, total, not search.is_cut)


_Counted: TypeAlias = (
    "int | AllOf[_Counted] | AnyOf[_Counted] | ExactlyOf[_Counted] | AndOrTreePairing[_Counted]"
)
"""A choice of conditions for a goal, in which integers stand for the conditions."""

_SetValues: TypeAlias = dict[int, int]
"""Mapping from a set of common conditions, as a bit mask, to the greatest sum of other conditions' values."""


class _OptionSearch:
    """One search for the option whose conditions have the greatest sum of values.

    Attributes:
        values: the value of each condition, by the condition's number.
        is_cut: whether the search dropped sets of conditions because there were too many.
    """

    __slots__ = ("is_cut", "values")

    def __init__(self, values: Sequence[int]) -> None:
        self.values = values
        self.is_cut = False

    def value(self, conditions: int) -> int:
        """Return the sum of the values of some conditions, given as a bit mask."""
        return sum([self.values[number] for number in iterate_positions(conditions)])


_FindSets: TypeAlias = Callable[[_OptionSearch], _SetValues]


def _number_conditions(choice: AndOrTree, numbers: dict[f.Atom | f.Occurs, int]) -> _Counted:
    """Return a choice of conditions with integers in place of conditions, and without nested conjunctions."""
    match choice:
        case AndOrTreeLiteral(literal):
            return _number_literal(literal, numbers)
        case AllOf(parts):
            inner = [_number_conditions(part, numbers) for part in parts]
            nested = [part.parts if isinstance(part, AllOf) else (part,) for part in inner]
            return AllOf(tuple([part for group in nested for part in group]))
        case AnyOf(parts):
            return AnyOf(tuple([_number_conditions(part, numbers) for part in parts]))
        case ExactlyOf(count, parts):
            return ExactlyOf(count, tuple([_number_conditions(part, numbers) for part in parts]))
        case AndOrTreePairing(count, cells):
            rows = [
                [None if cell is None else _number_conditions(cell, numbers) for cell in row] for row in cells
            ]
            return AndOrTreePairing(count, tuple(map(tuple, rows)))
        case _:
            assert_never(choice)


def _number_literal(literal: Literal, numbers: dict[f.Atom | f.Occurs, int]) -> int:
    negated = isinstance(literal, f.Not)
    atom = literal.operand if isinstance(literal, f.Not) else literal
    if not isinstance(atom, (f.Atom, f.Occurs)):
        raise TypeError(f"{atom} is no ground condition")
    return 2 * numbers.setdefault(atom, len(numbers)) + negated


def _make_condition_mask(numbers: Iterable[int]) -> int:
    return reduce(or_, [1 << number for number in numbers], 0)


def _make_positive_mask(atoms: int) -> int:
    """Return the bit mask of all conditions that are atoms without a negation."""
    return ((1 << 2 * atoms) - 1) // 3


def _find_negations(conditions: int, positive: int) -> int:
    return (conditions & positive) << 1 | conditions >> 1 & positive


def _contradicts(conditions: int, positive: int) -> bool:
    """Whether a set of conditions contains a condition and its negation."""
    return bool(conditions & conditions >> 1 & positive)


def _get_direct_parts(part: _Counted) -> Sequence[_Counted]:
    """Return the parts of a compound part of a goal, without parts inside these parts."""
    match part:
        case int():
            return ()
        case AllOf(parts) | AnyOf(parts) | ExactlyOf(_, parts):
            return parts
        case AndOrTreePairing(_, cells):
            return [cell for row in cells for cell in row if cell is not None]
        case _:
            assert_never(part)


class _OptionCompiler:
    """Makes for each part of a goal a function that finds the part's best sets of common conditions."""

    def __init__(self, choices: Sequence[_Counted], fixed: int, positive: int) -> None:
        self._fixed = fixed
        self._positive = positive
        self._barred = _find_negations(fixed, positive)
        self._common: set[int] = set()
        self._occurring = 0
        self._all = self._count_atom_mentions(AllOf(tuple(choices)))

    def _count_atom_mentions(self, part: _Counted) -> Counter[int]:
        """Count how many parts mention each atom, and note atoms that several members of a part mention."""
        if isinstance(part, int):
            if (self._fixed | self._barred) >> part & 1:
                return Counter()
            self._occurring |= 1 << part
            return Counter((part >> 1,))
        counts = [self._count_atom_mentions(member) for member in _get_direct_parts(part)]
        total: Counter[int] = Counter()
        for inner in counts:
            if not isinstance(part, AnyOf):
                self._common.update(total.keys() & inner.keys())
            total.update(inner)
        return total

    def compile_part(self, part: _Counted) -> _FindSets:
        """Return a function that finds a part's best sets of common conditions that other parts mention."""
        match part:
            case int():
                return self._compile_condition(part)
            case AllOf(parts):
                return self._compile_all_of(parts)
            case AnyOf(parts):
                return self._close_found_sets(
                    _compile_any_of([self.compile_part(member) for member in parts]), part
                )
            case ExactlyOf(count, parts):
                return self._close_found_sets(
                    self._compile_exactly_of(count, [self.compile_part(member) for member in parts]), part
                )
            case AndOrTreePairing(count, cells):
                tables = [
                    [None if cell is None else self.compile_part(cell) for cell in row] for row in cells
                ]
                return self._close_found_sets(self._compile_pairing(count, tables), part)
            case _:
                assert_never(part)

    def _compile_condition(self, number: int) -> _FindSets:
        if self._fixed >> number & 1:
            return lambda search: {0: 0}
        if self._barred >> number & 1:
            return lambda search: {}
        if number >> 1 in self._common:
            return lambda search: {1 << number: 0}
        return lambda search: {0: search.values[number]}

    def _compile_all_of(self, parts: Sequence[_Counted]) -> _FindSets:
        plain = [part for part in parts if isinstance(part, int) and part >> 1 not in self._common]
        plain = [number for number in plain if not (self._fixed | self._barred) >> number & 1]
        barred = any(isinstance(part, int) and self._barred >> part & 1 for part in parts)
        others = [part for part in parts if not isinstance(part, int) or part >> 1 in self._common]
        counts = [self._count_atom_mentions(part) for part in others]
        alone: list[tuple[_FindSets, Counter[int]]] = []
        joined: list[tuple[_FindSets, Counter[int]]] = []
        for part, count in zip(others, counts, strict=True):
            (joined if self._find_shared_atoms(count) else alone).append((self.compile_part(part), count))
        steps = self._order_members(joined)

        def table(search: _OptionSearch) -> _SetValues:
            if barred:
                return {}
            value = sum([search.values[number] for number in plain])
            for member, _ in alone:
                sets = member(search)
                if not sets:
                    return {}
                value += sets[0]
            best: _SetValues = {0: value}
            for member, closed in steps:
                best = self._prune_condition_sets(
                    _close_conditions(self._join_condition_sets(best, member(search)), closed, search), search
                )
            return best

        return table

    def _order_members(self, members: list[tuple[_FindSets, Counter[int]]]) -> list[tuple[_FindSets, int]]:
        """Order the members of a part of a goal so that the search can forget common conditions early.

        Return pairs: a member, and the common conditions that no later member can choose, as a bit mask.
        """
        steps = []
        seen: Counter[int] = Counter()
        left = list(members)
        while left:
            member = min(left, key=lambda candidate: len(self._find_shared_atoms(seen + candidate[1])))
            left.remove(member)
            seen = seen + member[1]
            steps.append((member[0], self._find_unshared_conditions(seen)))
        return steps

    def _find_shared_atoms(self, count: Counter[int]) -> list[int]:
        """Return those atoms in the counted parts that also occur in other parts."""
        return [atom for atom, times in count.items() if atom in self._common and times < self._all[atom]]

    def _find_unshared_conditions(self, count: Counter[int]) -> int:
        """Return the bit mask of the common conditions that only the counted parts mention."""
        atoms = [atom for atom, times in count.items() if atom in self._common and times == self._all[atom]]
        return _make_condition_mask([number for atom in atoms for number in (2 * atom, 2 * atom + 1)])

    def _compile_exactly_of(self, count: int, members: Sequence[_FindSets]) -> _FindSets:
        def table(search: _OptionSearch) -> _SetValues:
            tables = [sets for member in members if (sets := member(search))]
            if all(sets.keys() == {0} for sets in tables):
                values = nlargest(count, [sets[0] for sets in tables])
                return {0: sum(values)} if len(values) == count else {}
            best: list[_SetValues] = [{0: 0}, *[{} for _ in range(count)]]
            for sets in tables:
                for size in range(count, 0, -1):
                    _keep_better_sets(best[size], self._join_condition_sets(best[size - 1], sets))
                    best[size] = self._prune_condition_sets(best[size], search)
            return best[count]

        return table

    def _compile_pairing(self, count: int, cells: Sequence[Sequence[_FindSets | None]]) -> _FindSets:
        def table(search: _OptionSearch) -> _SetValues:
            rows = [[{} if cell is None else cell(search) for cell in row] for row in cells]
            if all(sets.keys() <= {0} for row in rows for sets in row):
                weights = [[sets.get(0) for sets in row] for row in rows]
                pairs = find_heaviest_matching(weights, count)
                return {} if pairs is None else {0: sum([weights[row][column] or 0 for row, column in pairs])}
            return self._pair_row_by_row(count, rows, search)

        return table

    def _pair_row_by_row(
        self, count: int, rows: Sequence[Sequence[_SetValues]], search: _OptionSearch
    ) -> _SetValues:
        """Return the best sets of common conditions for a pairing of rows with columns.

        The search goes row by row, and keeps the best sets for every set of columns used so far.
        """
        best: dict[int, _SetValues] = {0: {0: 0}}
        for row in rows:
            wider = {taken: dict(sets) for taken, sets in best.items()}
            for taken, sets in best.items():
                for column, cell in enumerate(row):
                    if cell and not taken >> column & 1 and taken.bit_count() < count:
                        _keep_better_sets(
                            wider.setdefault(taken | 1 << column, {}), self._join_condition_sets(sets, cell)
                        )
            best = {taken: self._prune_condition_sets(sets, search) for taken, sets in wider.items()}
            if len(best) > _MAX_SETS:
                search.is_cut = True
                best = dict(nlargest(_MAX_SETS, best.items(), key=lambda item: item[0].bit_count()))
        last: _SetValues = {}
        for taken, sets in best.items():
            if taken.bit_count() == count:
                _keep_better_sets(last, sets)
        return last

    def _join_condition_sets(self, left: _SetValues, right: _SetValues) -> _SetValues:
        """Return the union of each left and each right set, unless it has a condition and its negation."""
        joined: _SetValues = {}
        for one, value in left.items():
            for other, further in right.items():
                both = one | other
                if both & both >> 1 & self._positive:
                    continue
                total = value + further
                if total > joined.get(both, total - 1):
                    joined[both] = total
        return joined

    def _close_found_sets(self, table: _FindSets, part: _Counted) -> _FindSets:
        closed = self._find_unshared_conditions(self._count_atom_mentions(part))
        if not closed:
            return table
        return lambda search: _close_conditions(table(search), closed, search)

    def _prune_condition_sets(self, sets: _SetValues, search: _OptionSearch) -> _SetValues:
        """Return at most `_MAX_SETS` of the sets of conditions, without those that another set dominates."""
        if len(sets) <= _MAX_UNPRUNED_SETS:
            return sets
        rivals = nlargest(_MAX_RIVALS, sets, key=lambda each: sets[each] + search.value(each))
        gains = _make_condition_mask([number for number, value in enumerate(search.values) if value > 0])

        def is_dominated(conditions: int) -> bool:
            for rival in rivals:
                more, less = rival & ~conditions, conditions & ~rival
                if rival == conditions or self._may_contradict(more):
                    continue
                surely = (
                    sets[rival] - sets[conditions] + search.value(more & ~gains) - search.value(less & gains)
                )
                if surely >= 0:
                    return True
            return False

        kept = {each: value for each, value in sets.items() if each in rivals or not is_dominated(each)}
        if len(kept) <= _MAX_SETS:
            return kept
        search.is_cut = True
        best = nlargest(_MAX_SETS, kept, key=lambda each: kept[each] + search.value(each))
        return {each: kept[each] for each in best}

    def _may_contradict(self, conditions: int) -> bool:
        return bool(_find_negations(conditions, self._positive) & self._occurring)


def _find_no_sets(search: _OptionSearch) -> _SetValues:
    return {}


def _compile_any_of(members: Sequence[_FindSets]) -> _FindSets:
    def table(search: _OptionSearch) -> _SetValues:
        best: _SetValues = {}
        for member in members:
            _keep_better_sets(best, member(search))
        return best

    return table


def _keep_better_sets(best: _SetValues, others: _SetValues) -> None:
    """Add sets of conditions with their values to `best`.

    If `best` has a set already, the greater value counts.
    """
    for conditions, value in others.items():
        if value > best.get(conditions, value - 1):
            best[conditions] = value


def _close_conditions(sets: _SetValues, closed: int, search: _OptionSearch) -> _SetValues:
    """Remove conditions that no later part can choose, and add their values to the values of the sets."""
    if not closed:
        return sets
    best: _SetValues = {}
    for conditions, value in sets.items():
        _keep_better_sets(best, {conditions & ~closed: value + search.value(conditions & closed)})
    return best
