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
from eai.logic.choice import (
    AndNode,
    AndOrTree,
    AndOrTreeLiteral,
    BipartiteMatchingNode,
    ExactCountNode,
    Literal,
    OrNode,
)
from eai.logic.matching import find_heaviest_matching
from eai.logic.trace import iterate_positions

_MAX_SETS = 2_000
"""Maximum number of sets of common conditions that a search keeps.

Common conditions are about atoms that several parts of a goal mention. The search combines the parts one by
one, and keeps the sets of common conditions that these parts can choose. If it discards a set, it may miss
the best way to satisfy the goal. The share of met conditions that it finds is then a lower bound.
"""

_MAX_UNPRUNED_SETS = 64
"""Number of sets of common conditions above which a search discards dominated sets.

Common conditions are about atoms that several parts of a goal mention. A set is dominated if another set
gives at least the same total value, whichever conditions the other parts choose.
"""

_MAX_DOMINATING_SETS = 8
"""Number of the best sets of conditions that are compared with all other sets, to discard dominated sets."""


class _ShareOfMetConditions(NamedTuple):
    """The share of an option's conditions that hold in a state.

    An option is a set of conditions that together satisfy a task's goals.

    Attributes:
        met: number of conditions of the option that hold.
        total: number of conditions of the option.
        is_exact: whether it is proved that no option has a larger share; False if the search discarded
            options.
    """

    met: int
    total: int
    is_exact: bool = True


def make_finder_of_most_satisfied_goal_option(
    goal_trees: Sequence[AndOrTree], extra_conditions_in_every_option: int = 0
) -> _MostSatisfiedGoalOptionFinder:
    """Return a function that finds the option of a goal with the largest share of met conditions.

    If several options have this share, the function finds the option with the fewest conditions.

    Args:
        goal_trees: for each goal part, the choices of conditions that satisfy the part. An option combines
            one choice of each part.
        extra_conditions_in_every_option: number of further conditions, which every option contains.
    """
    return _MostSatisfiedGoalOptionFinder(goal_trees, extra_conditions_in_every_option)


class _MostSatisfiedGoalOptionFinder:
    """Finds the option of a goal with the largest share of met conditions.

    Attributes:
        atoms: the atoms in the goal's conditions. Condition ``2 * i`` states that atom ``i`` is true, and
            condition ``2 * i + 1`` that it is false.
    """

    def __init__(self, goal_trees: Sequence[AndOrTree], extra_conditions_in_every_option: int) -> None:
        numbers: dict[f.Atom | f.Occurs, int] = {}
        root = _replace_conditions_by_numbers(AndNode(tuple(goal_trees)), numbers)
        self.atoms = tuple(numbers)
        self._further = extra_conditions_in_every_option
        self._positive = _make_mask_of_positive_conditions(len(self.atoms))
        members = root.parts if isinstance(root, AndNode) else (root,)
        self._fixed = _make_condition_mask([part for part in members if isinstance(part, int)])
        choices = tuple([part for part in members if not isinstance(part, int)])
        compiler = _BestValuesFinderBuilder(choices, self._fixed, self._positive)
        self._find_best_values: _BestValuesFinder = _return_no_values_for_contradictory_goal
        if not _is_contradictory(self._fixed, self._positive):
            self._find_best_values = compiler.make_finder_for_goal_part(AndNode(choices))

    def __call__(self, true_atom_mask: int, met_extra_condition_count: int = 0) -> _ShareOfMetConditions:
        """Return the largest share of met conditions among all options (sets that satisfy the goal).

        The share is 0 of 1 if there is no option.

        Args:
            true_atom_mask: the atoms that are true in the state, as a bit mask.
            met_extra_condition_count: number of met conditions among the further conditions, which every
                option contains.
        """
        best, is_exact = _ShareOfMetConditions(0, 1), True
        while True:
            option = self._find_share_of_option_with_greatest_gain(
                true_atom_mask, met_extra_condition_count, best
            )
            is_exact = is_exact and option.is_exact
            gain = option.met * best.total - best.met * option.total
            if gain > 0:
                best = option
            else:
                return (option if gain == 0 else best)._replace(is_exact=is_exact)

    def _find_share_of_option_with_greatest_gain(
        self, true_atom_mask: int, met_extra_condition_count: int, current_share: _ShareOfMetConditions
    ) -> _ShareOfMetConditions:
        """Return the share of met conditions of the option with the greatest gain over ``current_share``.

        An option is a set of conditions that satisfies the goal. It has ``total`` conditions, and ``met`` of
        them hold. Its gain is ``current_share.total * met - current_share.met * total``. The gain is positive
        if the option's share is larger than ``current_share``. Among options with the greatest gain, the
        function chooses the option with the fewest conditions. So the search maximizes
        ``scale * gain - total``, with a ``scale`` greater than any total. If no option is possible,
        ``current_share`` is returned.
        """
        scale = 2 * len(self.atoms) + self._further + 1
        unmet = -current_share.met * scale - 1
        met = unmet + current_share.total * scale
        values = [
            met if true_atom_mask >> number & 1 == wanted else unmet
            for number in range(len(self.atoms))
            for wanted in (1, 0)
        ]
        search = _GoalOptionSearch(values)
        table = self._find_best_values(search)
        if not table:
            return current_share._replace(is_exact=not search.is_cut)
        value = (
            table[0]
            + search.sum_condition_values(self._fixed)
            + met_extra_condition_count * met
            + (self._further - met_extra_condition_count) * unmet
        )
        total = -value % scale
        gain = (value + total) // scale
        return _ShareOfMetConditions(
            (gain + current_share.met * total) // current_share.total, total, not search.is_cut
        )


_ConditionMask: TypeAlias = int
"""Bit mask of conditions; condition ``2 * i`` states that atom ``i`` is true, ``2 * i + 1`` its negation."""

_TreeOfConditionNumbers: TypeAlias = (
    "int | AndNode[_TreeOfConditionNumbers] | OrNode[_TreeOfConditionNumbers]"
    " | ExactCountNode[_TreeOfConditionNumbers] | BipartiteMatchingNode[_TreeOfConditionNumbers]"
)
"""An and-or tree of the conditions of a goal. Its leaves are the numbers of conditions."""

_BestValueByConditionsSharedByGoalParts: TypeAlias = dict[_ConditionMask, int]
"""The values of the best ways to satisfy one part of a goal: one value for each set of common conditions.

A way to satisfy the part is a set of conditions, and each condition has a value (`_GoalOptionSearch`). Common
conditions are about atoms that other parts of the goal mention, too. A key is a set of common conditions, as
a bit mask. Among the ways with exactly these common conditions, the best way has the greatest sum of the
values of its other conditions. This sum is the value of the key.
"""


class _GoalOptionSearch:
    """One search for the conditions that satisfy a goal with the greatest sum of values.

    Attributes:
        values: the value of each condition by number: how much it adds to the sum that the search maximizes.
        is_cut: whether the search discarded sets of conditions because there were too many.
    """

    __slots__ = ("is_cut", "values")

    def __init__(self, values: Sequence[int]) -> None:
        self.values = values
        self.is_cut = False

    def sum_condition_values(self, conditions: _ConditionMask) -> int:
        """Return the sum of the values of some conditions, given as a bit mask."""
        return sum([self.values[number] for number in iterate_positions(conditions)])


_BestValuesFinder: TypeAlias = Callable[[_GoalOptionSearch], _BestValueByConditionsSharedByGoalParts]
"""Function that returns the values of the best ways to satisfy one part of a goal.

The search that it gets has the values of conditions. `_BestValueByConditionsSharedByGoalParts` explains the
result.
"""


def _replace_conditions_by_numbers(
    tree: AndOrTree, number_by_atom: dict[f.Atom | f.Occurs, int]
) -> _TreeOfConditionNumbers:
    """Return an and-or tree with numbers in place of conditions, and without nested conjunctions."""
    match tree:
        case AndOrTreeLiteral(literal):
            return _assign_number_to_literal(literal, number_by_atom)
        case AndNode(parts):
            inner = [_replace_conditions_by_numbers(part, number_by_atom) for part in parts]
            nested = [part.parts if isinstance(part, AndNode) else (part,) for part in inner]
            return AndNode(tuple([part for group in nested for part in group]))
        case OrNode(parts):
            return OrNode(tuple([_replace_conditions_by_numbers(part, number_by_atom) for part in parts]))
        case ExactCountNode(count, parts):
            return ExactCountNode(
                count, tuple([_replace_conditions_by_numbers(part, number_by_atom) for part in parts])
            )
        case BipartiteMatchingNode(count, cells):
            rows = [
                [
                    None if cell is None else _replace_conditions_by_numbers(cell, number_by_atom)
                    for cell in row
                ]
                for row in cells
            ]
            return BipartiteMatchingNode(count, tuple(map(tuple, rows)))
        case _:
            assert_never(tree)


def _assign_number_to_literal(literal: Literal, number_by_atom: dict[f.Atom | f.Occurs, int]) -> int:
    negated = isinstance(literal, f.Not)
    atom = literal.operand if isinstance(literal, f.Not) else literal
    if not isinstance(atom, (f.Atom, f.Occurs)):
        raise TypeError(f"{atom}: expected an atom or an action as condition of a goal")
    return 2 * number_by_atom.setdefault(atom, len(number_by_atom)) + negated


def _make_condition_mask(numbers: Iterable[int]) -> _ConditionMask:
    return reduce(or_, [1 << number for number in numbers], 0)


def _make_mask_of_positive_conditions(atom_count: int) -> _ConditionMask:
    """Return the bit mask of all conditions that are atoms without a negation."""
    return ((1 << 2 * atom_count) - 1) // 3


def _negate_conditions(conditions: _ConditionMask, all_positive_conditions: _ConditionMask) -> _ConditionMask:
    return (conditions & all_positive_conditions) << 1 | conditions >> 1 & all_positive_conditions


def _is_contradictory(conditions: _ConditionMask, all_positive_conditions: _ConditionMask) -> bool:
    """Whether a set of conditions contains a condition and its negation."""
    return bool(conditions & conditions >> 1 & all_positive_conditions)


def _get_immediate_subtrees(tree: _TreeOfConditionNumbers) -> Sequence[_TreeOfConditionNumbers]:
    """Return the parts of a compound part of a goal, without parts inside these parts."""
    match tree:
        case int():
            return ()
        case AndNode(parts) | OrNode(parts) | ExactCountNode(_, parts):
            return parts
        case BipartiteMatchingNode(_, cells):
            return [cell for row in cells for cell in row if cell is not None]
        case _:
            assert_never(tree)


class _BestValuesFinderBuilder:
    """Makes functions that find sets of conditions that satisfy a part of a goal.

    The sets contain only common conditions: conditions about atoms that several parts of the goal mention.
    """

    def __init__(
        self,
        choices: Sequence[_TreeOfConditionNumbers],
        fixed: _ConditionMask,
        all_positive_conditions: _ConditionMask,
    ) -> None:
        self._fixed = fixed
        self._positive = all_positive_conditions
        self._barred = _negate_conditions(fixed, all_positive_conditions)
        self._common: set[int] = set()
        self._occurring = 0
        self._all = self._count_atom_mentions(AndNode(tuple(choices)))

    def _count_atom_mentions(self, part: _TreeOfConditionNumbers) -> Counter[int]:
        """Count the conditions about each atom in a part of the goal.

        Conditions that every option of the goal contains are not counted, and neither are their negations. As
        a side effect, atoms that occur in two operands of the part, or of a part inside this part, are added
        to `_common`. Two operands of a disjunction do not count, because the search chooses only one operand.
        """
        if isinstance(part, int):
            if (self._fixed | self._barred) >> part & 1:
                return Counter()
            self._occurring |= 1 << part
            return Counter((part >> 1,))
        counts = [self._count_atom_mentions(member) for member in _get_immediate_subtrees(part)]
        total: Counter[int] = Counter()
        for inner in counts:
            if not isinstance(part, OrNode):
                self._common.update(total.keys() & inner.keys())
            total.update(inner)
        return total

    def make_finder_for_goal_part(self, goal_part: _TreeOfConditionNumbers) -> _BestValuesFinder:
        """Return a function that finds the values of the best ways to satisfy a part of the goal.

        `_BestValueByConditionsSharedByGoalParts` explains the result of the function.
        """
        match goal_part:
            case int():
                return self._make_finder_for_condition(goal_part)
            case AndNode(parts):
                return self._make_finder_for_conjunction(parts)
            case OrNode(parts):
                return self._wrap_finder_to_drop_unshared_conditions(
                    _make_finder_for_disjunction(
                        [self.make_finder_for_goal_part(member) for member in parts]
                    ),
                    goal_part,
                )
            case ExactCountNode(count, parts):
                return self._wrap_finder_to_drop_unshared_conditions(
                    self._make_finder_for_exact_count(
                        count, [self.make_finder_for_goal_part(member) for member in parts]
                    ),
                    goal_part,
                )
            case BipartiteMatchingNode(count, cells):
                tables = [
                    [None if cell is None else self.make_finder_for_goal_part(cell) for cell in row]
                    for row in cells
                ]
                return self._wrap_finder_to_drop_unshared_conditions(
                    self._make_finder_for_matching_node(count, tables), goal_part
                )
            case _:
                assert_never(goal_part)

    def _make_finder_for_condition(self, condition_number: int) -> _BestValuesFinder:
        if self._fixed >> condition_number & 1:
            return lambda search: {0: 0}
        if self._barred >> condition_number & 1:
            return lambda search: {}
        if condition_number >> 1 in self._common:
            return lambda search: {1 << condition_number: 0}
        return lambda search: {0: search.values[condition_number]}

    def _make_finder_for_conjunction(self, parts: Sequence[_TreeOfConditionNumbers]) -> _BestValuesFinder:
        plain = [part for part in parts if isinstance(part, int) and part >> 1 not in self._common]
        plain = [number for number in plain if not (self._fixed | self._barred) >> number & 1]
        barred = any(isinstance(part, int) and self._barred >> part & 1 for part in parts)
        others = [part for part in parts if not isinstance(part, int) or part >> 1 in self._common]
        counts = [self._count_atom_mentions(part) for part in others]
        alone: list[tuple[_BestValuesFinder, Counter[int]]] = []
        joined: list[tuple[_BestValuesFinder, Counter[int]]] = []
        for part, count in zip(others, counts, strict=True):
            (joined if self._find_atoms_shared_with_other_goal_parts(count) else alone).append(
                (self.make_finder_for_goal_part(part), count)
            )
        steps = self._order_conjuncts_to_drop_conditions_early(joined)

        def find_best_values_of_goal_part(
            search: _GoalOptionSearch,
        ) -> _BestValueByConditionsSharedByGoalParts:
            if barred:
                return {}
            value = sum([search.values[number] for number in plain])
            for member, _ in alone:
                sets = member(search)
                if not sets:
                    return {}
                value += sets[0]
            best: _BestValueByConditionsSharedByGoalParts = {0: value}
            for member, closed in steps:
                best = self._prune_condition_sets(
                    _remove_conditions_and_add_their_values(
                        self._join_condition_sets_and_add_values(best, member(search)), closed, search
                    ),
                    search,
                )
            return best

        return find_best_values_of_goal_part

    def _order_conjuncts_to_drop_conditions_early(
        self, conjuncts: list[tuple[_BestValuesFinder, Counter[int]]]
    ) -> list[tuple[_BestValuesFinder, _ConditionMask]]:
        """Order the parts of a conjunction so that the search can soon remove conditions from its sets.

        The search combines the parts in this order, and keeps sets of conditions. It removes the conditions
        on an atom from all sets as soon as no later part mentions the atom. Return for each part the function
        that finds the best ways to satisfy the part, and the bit mask of the conditions to remove then.
        """
        steps = []
        seen: Counter[int] = Counter()
        left = list(conjuncts)
        while left:
            member = min(
                left,
                key=lambda candidate: len(self._find_atoms_shared_with_other_goal_parts(seen + candidate[1])),
            )
            left.remove(member)
            seen = seen + member[1]
            steps.append((member[0], self._find_conditions_in_no_other_goal_part(seen)))
        return steps

    def _find_atoms_shared_with_other_goal_parts(self, mention_counts: Counter[int]) -> list[int]:
        """Return the common atoms of given parts of the goal that other parts contain, too.

        ``mention_counts`` has the number of conditions about each atom in the given parts. If the
        number for the whole goal is greater, other parts contain the atom.
        """
        return [
            atom for atom, times in mention_counts.items() if atom in self._common and times < self._all[atom]
        ]

    def _find_conditions_in_no_other_goal_part(self, mention_counts: Counter[int]) -> _ConditionMask:
        """Return as a bit mask the conditions on common atoms that only the given parts of the goal mention.

        Common atoms occur in several parts of the goal (`_common`). ``mention_counts`` has the number of
        conditions about each atom in the given parts. No other part mentions an atom if the goal has no
        further conditions about the atom.
        """
        atoms = [
            atom
            for atom, times in mention_counts.items()
            if atom in self._common and times == self._all[atom]
        ]
        return _make_condition_mask([number for atom in atoms for number in (2 * atom, 2 * atom + 1)])

    def _make_finder_for_exact_count(
        self, count: int, part_finders: Sequence[_BestValuesFinder]
    ) -> _BestValuesFinder:
        def find_best_values_of_goal_part(
            search: _GoalOptionSearch,
        ) -> _BestValueByConditionsSharedByGoalParts:
            tables = [sets for member in part_finders if (sets := member(search))]
            if all(sets.keys() == {0} for sets in tables):
                values = nlargest(count, [sets[0] for sets in tables])
                return {0: sum(values)} if len(values) == count else {}
            best: list[_BestValueByConditionsSharedByGoalParts] = [{0: 0}, *[{} for _ in range(count)]]
            for sets in tables:
                for size in range(count, 0, -1):
                    _merge_keeping_greater_values(
                        best[size], self._join_condition_sets_and_add_values(best[size - 1], sets)
                    )
                    best[size] = self._prune_condition_sets(best[size], search)
            return best[count]

        return find_best_values_of_goal_part

    def _make_finder_for_matching_node(
        self, matching_size: int, finders_by_row: Sequence[Sequence[_BestValuesFinder | None]]
    ) -> _BestValuesFinder:
        def find_best_values_of_goal_part(
            search: _GoalOptionSearch,
        ) -> _BestValueByConditionsSharedByGoalParts:
            rows = [[{} if cell is None else cell(search) for cell in row] for row in finders_by_row]
            if all(sets.keys() <= {0} for row in rows for sets in row):
                weights = [[sets.get(0) for sets in row] for row in rows]
                pairs = find_heaviest_matching(weights, matching_size)
                return {} if pairs is None else {0: sum([weights[row][column] or 0 for row, column in pairs])}
            return self._find_best_values_of_matching_node(matching_size, rows, search)

        return find_best_values_of_goal_part

    def _find_best_values_of_matching_node(
        self,
        matching_size: int,
        best_values_by_row: Sequence[Sequence[_BestValueByConditionsSharedByGoalParts]],
        search: _GoalOptionSearch,
    ) -> _BestValueByConditionsSharedByGoalParts:
        """Return the values of the best ways to satisfy ``matching_size`` cells, no two in one row or column.

        The cells are those of a table for ``forpairs`` (a quantifier over pairs of objects). The objects of
        one category have rows, and the objects of the other category have columns. The cell of a pair has the
        values of the ways to make the body true for the pair. The search goes row by row. For every set of
        columns with a chosen cell, it keeps the best ways so far.
        """
        best: dict[int, _BestValueByConditionsSharedByGoalParts] = {0: {0: 0}}
        for row in best_values_by_row:
            wider = {taken: dict(sets) for taken, sets in best.items()}
            for taken, sets in best.items():
                for column, cell in enumerate(row):
                    if cell and not taken >> column & 1 and taken.bit_count() < matching_size:
                        _merge_keeping_greater_values(
                            wider.setdefault(taken | 1 << column, {}),
                            self._join_condition_sets_and_add_values(sets, cell),
                        )
            best = {taken: self._prune_condition_sets(sets, search) for taken, sets in wider.items()}
            if len(best) > _MAX_SETS:
                search.is_cut = True
                best = dict(nlargest(_MAX_SETS, best.items(), key=lambda item: item[0].bit_count()))
        last: _BestValueByConditionsSharedByGoalParts = {}
        for taken, sets in best.items():
            if taken.bit_count() == matching_size:
                _merge_keeping_greater_values(last, sets)
        return last

    def _join_condition_sets_and_add_values(
        self, left: _BestValueByConditionsSharedByGoalParts, right: _BestValueByConditionsSharedByGoalParts
    ) -> _BestValueByConditionsSharedByGoalParts:
        """Return all unions of a set from ``left`` and a set from ``right``, with the sums of their values.

        If several pairs have the same union, the greatest sum is kept. Unions that contain a condition and
        its negation are left out.
        """
        joined: _BestValueByConditionsSharedByGoalParts = {}
        for one, value in left.items():
            for other, further in right.items():
                both = one | other
                if both & both >> 1 & self._positive:
                    continue
                total = value + further
                if total > joined.get(both, total - 1):
                    joined[both] = total
        return joined

    def _wrap_finder_to_drop_unshared_conditions(
        self, find_best_values_of_goal_part: _BestValuesFinder, goal_part: _TreeOfConditionNumbers
    ) -> _BestValuesFinder:
        """Return a function that finds the best ways to satisfy a part of the goal.

        The function calls ``find_best_values_of_goal_part``. It removes all conditions that no other part of
        the goal mentions. It adds the values of these conditions to the values of their sets.
        """
        closed = self._find_conditions_in_no_other_goal_part(self._count_atom_mentions(goal_part))
        if not closed:
            return find_best_values_of_goal_part
        return lambda search: _remove_conditions_and_add_their_values(
            find_best_values_of_goal_part(search), closed, search
        )

    def _prune_condition_sets(
        self, best_values: _BestValueByConditionsSharedByGoalParts, search: _GoalOptionSearch
    ) -> _BestValueByConditionsSharedByGoalParts:
        """Return all sets, or fewer sets with great values if there are too many.

        If there are more than `_MAX_UNPRUNED_SETS`, sets that one of the `_MAX_DOMINATING_SETS` best sets
        dominates are discarded. If more than `_MAX_SETS` remain, only the `_MAX_SETS` best are returned.
        """
        if len(best_values) <= _MAX_UNPRUNED_SETS:
            return best_values
        rivals = nlargest(
            _MAX_DOMINATING_SETS,
            best_values,
            key=lambda each: best_values[each] + search.sum_condition_values(each),
        )
        gains = _make_condition_mask([number for number, value in enumerate(search.values) if value > 0])

        def is_dominated_by_best_condition_set(conditions: _ConditionMask) -> bool:
            for rival in rivals:
                more, less = rival & ~conditions, conditions & ~rival
                if rival == conditions or self._has_condition_with_negation_in_goal(more):
                    continue
                surely = (
                    best_values[rival]
                    - best_values[conditions]
                    + search.sum_condition_values(more & ~gains)
                    - search.sum_condition_values(less & gains)
                )
                if surely >= 0:
                    return True
            return False

        kept = {
            each: value
            for each, value in best_values.items()
            if each in rivals or not is_dominated_by_best_condition_set(each)
        }
        if len(kept) <= _MAX_SETS:
            return kept
        search.is_cut = True
        best = nlargest(_MAX_SETS, kept, key=lambda each: kept[each] + search.sum_condition_values(each))
        return {each: kept[each] for each in best}

    def _has_condition_with_negation_in_goal(self, conditions: _ConditionMask) -> bool:
        return bool(_negate_conditions(conditions, self._positive) & self._occurring)


def _return_no_values_for_contradictory_goal(
    search: _GoalOptionSearch,
) -> _BestValueByConditionsSharedByGoalParts:
    return {}


def _make_finder_for_disjunction(part_finders: Sequence[_BestValuesFinder]) -> _BestValuesFinder:
    def find_best_values_of_goal_part(search: _GoalOptionSearch) -> _BestValueByConditionsSharedByGoalParts:
        best: _BestValueByConditionsSharedByGoalParts = {}
        for member in part_finders:
            _merge_keeping_greater_values(best, member(search))
        return best

    return find_best_values_of_goal_part


def _merge_keeping_greater_values(
    best: _BestValueByConditionsSharedByGoalParts, others: _BestValueByConditionsSharedByGoalParts
) -> None:
    """Add sets of conditions with their values to `best`.

    If `best` has a set already, the greater value counts.
    """
    for conditions, value in others.items():
        if value > best.get(conditions, value - 1):
            best[conditions] = value


def _remove_conditions_and_add_their_values(
    best_values: _BestValueByConditionsSharedByGoalParts,
    removed_conditions: _ConditionMask,
    search: _GoalOptionSearch,
) -> _BestValueByConditionsSharedByGoalParts:
    """Remove the conditions in ``removed_conditions`` from all keys of ``best_values``, sets of conditions.

    The value of a removed condition in the search is added to the value of the set. Callers must know that no
    later part of the goal mentions the removed conditions. If sets become equal, the greatest value is kept.
    """
    if not removed_conditions:
        return best_values
    best: _BestValueByConditionsSharedByGoalParts = {}
    for conditions, value in best_values.items():
        _merge_keeping_greater_values(
            best,
            {
                conditions & ~removed_conditions: value
                + search.sum_condition_values(conditions & removed_conditions)
            },
        )
    return best
