"""Choice trees: the ways to make a formula true, as a ground and-or tree.

An option is a list of ground conditions that makes the formula true. For "every candle in a basket of its
own" an option assigns a basket to each candle. The tree is polynomial in the number of objects, while the
number of options is exponential. So options are generated one by one, and counted without being generated.
The option that shares most conditions with a model's answer is found without listing the other options. For
this search, conditions are numbered, and sets of conditions are bit masks (bit i = condition i).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import chain, combinations, permutations
from math import comb, factorial, prod
from operator import attrgetter, or_
from typing import Generic, TypeAlias, TypeVar

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.logic.matching import find_heaviest_matching

Literal: TypeAlias = f.Atom | f.Occurs | f.Not
"""Ground atom, an action with its objects, or the negation of either."""


ObjectsByCategory: TypeAlias = Callable[[str | None], Sequence[str]]
"""Function that takes a category and returns its objects, each once, in a fixed order.

For None instead of a category it returns all objects.
"""


T = TypeVar("T")
"""Type of the parts of a choice tree: each part is another choice tree or, in the planner, a subgoal."""


@dataclass(frozen=True, slots=True)
class LiteralChoice:
    """A choice tree that consists of one ground condition, without any choice."""

    literal: Literal


@dataclass(frozen=True, slots=True)
class AllOf(Generic[T]):
    """A choice tree whose parts must all be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class AnyOf(Generic[T]):
    """A choice tree with alternative parts: one part must be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class ExactlyOf(Generic[T]):
    """A choice tree with alternative parts: exactly ``count`` parts must be made true."""

    count: int
    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class PairingChoice(Generic[T]):
    """A choice tree with a table of parts: ``count`` cells must be made true, no two in one row or column.

    None marks a cell that cannot be chosen.
    """

    count: int
    cells: tuple[tuple[T | None, ...], ...]


Choice: TypeAlias = (
    "LiteralChoice | AllOf[Choice] | AnyOf[Choice] | ExactlyOf[Choice] | PairingChoice[Choice]"
)


def build_choice_tree(formula: f.Formula, objects: ObjectsByCategory) -> Choice:
    """Return the choice tree of a closed formula. Negation is pushed inwards to the conditions.

    ``then`` is treated as a conjunction in a given order. For ``forn`` (exactly n) an option makes the body
    true for n objects and leaves all other objects open. A pairing has as many pairs as the smaller category
    has objects. Both rules follow the package ``bddl`` (``condition_evaluation.py``). No object is paired
    with itself.

    Raises:
        InputError: a variable is not bound; or a part has no finite tree: a temporal operator other than
            ``then``, a negated ``then`` or a negated counting quantifier.
    """
    return _ChoiceTreeBuilder(objects).build(formula, {}, True)


class _ChoiceTreeBuilder:
    def __init__(self, objects: ObjectsByCategory) -> None:
        self._objects = objects

    def build(self, formula: f.Formula, binding: Mapping[str, str], positive: bool) -> Choice:
        match formula:
            case f.Atom() | f.Occurs() | f.Equals():
                return _build_leaf(formula, binding, positive)
            case f.Not(operand):
                return self.build(operand, binding, not positive)
            case f.And(operands) | f.Or(operands):
                parts = tuple([self.build(operand, binding, positive) for operand in operands])
                return AllOf(parts) if isinstance(formula, f.And) == positive else AnyOf(parts)
            case f.Implies(premise, conclusion):
                return self.build(f.Or((f.Not(premise), conclusion)), binding, positive)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                parts = self._build_instances(variable, body, binding, positive)
                return AllOf(parts) if isinstance(formula, f.ForAll) == positive else AnyOf(parts)
            case f.Exactly(count, variable, body) if positive:
                return ExactlyOf(count, self._build_instances(variable, body, binding, True))
            case f.ForPairs() if positive:
                return self._build_pairing(formula, binding)
            case f.Then(steps) if positive:
                return AllOf(tuple([self.build(step, binding, True) for step in steps]))
            case _:
                negated = "" if positive else "a negated "
                raise InputError(
                    f"{negated}{type(formula).__name__} has no finite list of ways to become true"
                )

    def _build_instances(
        self, variable: f.Variable, body: f.Formula, binding: Mapping[str, str], positive: bool
    ) -> tuple[Choice, ...]:
        values = self._objects(variable.category)
        return tuple([self.build(body, {**binding, variable.name: value}, positive) for value in values])

    def _build_pairing(self, formula: f.ForPairs, binding: Mapping[str, str]) -> PairingChoice[Choice]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._objects(first.category), self._objects(second.category)

        def build_cell(x: str, y: str) -> Choice | None:
            return None if x == y else self.build(body, {**binding, first.name: x, second.name: y}, True)

        count = min(len(rows), len(columns)) if formula.count is None else formula.count
        return PairingChoice(count, tuple(tuple(build_cell(x, y) for y in columns) for x in rows))


def _build_leaf(formula: f.Atom | f.Occurs | f.Equals, binding: Mapping[str, str], positive: bool) -> Choice:
    match formula:
        case f.Equals(left, right):
            true = resolve_term(left, binding) == resolve_term(right, binding)
            return AllOf(()) if true == positive else AnyOf(())
        case f.Atom(predicate, arguments):
            literal: f.Atom | f.Occurs = f.Atom(
                predicate, tuple([resolve_term(t, binding) for t in arguments])
            )
        case f.Occurs(action, arguments):
            literal = f.Occurs(action, tuple([resolve_term(t, binding) for t in arguments]))
    return LiteralChoice(literal if positive else f.Not(literal))


def resolve_term(term: f.Term, binding: Mapping[str, str]) -> f.Constant:
    """Return the object that a term denotes under a binding of variables.

    Raises:
        InputError: the term is a variable without a value.
    """
    if isinstance(term, f.Constant):
        return term
    if term.name not in binding:
        raise InputError(f"variable {term.name} is not bound by a quantifier")
    return f.Constant(binding[term.name])


Option: TypeAlias = tuple[Literal, ...]
"""Ground conditions that make a formula true, in the order of the formula.

A condition may occur more than once, and conditions may contradict each other.
"""


def generate_options(formula: f.Formula, objects: ObjectsByCategory) -> Iterator[Option]:
    """Yield the options of a closed formula, in the order of the formula's disjuncts and of the objects.

    Two options may have the same conditions, if the formula has a condition in two disjuncts.

    Raises:
        InputError: the formula has no finite choice tree (see `build_choice_tree`).
    """
    return generate_tree_options(build_choice_tree(formula, objects))


def count_options(formula: f.Formula, objects: ObjectsByCategory) -> int:
    """Count the options of a closed formula without generating them.

    This takes time polynomial in the number of objects, except for two kinds of pairings. In the first kind,
    an object may be the first object of one pair and the second object of another pair. In the second kind,
    the condition on a pair does not have the same number of options for all pairs. These pairings take time
    exponential in the size of the smaller category.

    Raises:
        InputError: the formula has no finite choice tree (see `build_choice_tree`).
    """
    return count_tree_options(build_choice_tree(formula, objects))


def generate_tree_options(choice: Choice) -> Iterator[Option]:
    """Yield the options of a choice tree, each as a tuple of conditions; later choices vary fastest."""
    match choice:
        case LiteralChoice(literal):
            yield (literal,)
        case AllOf(parts):
            yield from _combine_options_of_parts(parts)
        case AnyOf(parts):
            yield from chain.from_iterable(map(generate_tree_options, parts))
        case ExactlyOf(count, parts):
            if count <= len(parts):  # a huge `count` would fill memory in `combinations`
                yield from chain.from_iterable(map(_combine_options_of_parts, combinations(parts, count)))
        case PairingChoice(count, cells):
            for pairs in _generate_pairings(count, cells):
                yield from _combine_options_of_parts(pairs)
        case _:
            assert_never(choice)


def count_tree_options(choice: Choice) -> int:
    """Count the options of a choice tree without generating them."""
    match choice:
        case LiteralChoice():
            return 1
        case AllOf(parts):
            return prod(map(count_tree_options, parts))
        case AnyOf(parts):
            return sum(map(count_tree_options, parts))
        case ExactlyOf(count, parts):
            return _sum_products_over_subsets(count, [count_tree_options(part) for part in parts])
        case PairingChoice(count, cells):
            numbers = [[0 if cell is None else count_tree_options(cell) for cell in row] for row in cells]
            return _sum_products_over_matchings(count, numbers)
        case _:
            assert_never(choice)


def _combine_options_of_parts(parts: Sequence[Choice]) -> Iterator[Option]:
    if not parts:
        yield ()
        return
    for head in generate_tree_options(parts[0]):
        for tail in _combine_options_of_parts(parts[1:]):
            yield head + tail


def _generate_pairings(count: int, cells: Sequence[Sequence[Choice | None]]) -> Iterator[list[Choice]]:
    """Yield all sets of ``count`` cells of a table without a common row or column.

    The sets are ordered by rows, or by columns if the table has fewer columns than rows.
    """
    lines = cells if len(cells) < (len(cells[0]) if cells else 0) else list(zip(*cells, strict=True))
    across = len(lines[0]) if lines else 0
    if count > min(len(lines), across):  # a huge `count` would fill memory in `combinations`
        return
    for some in combinations(lines, count):
        for others in permutations(range(across), count):
            pairs = [cell for line, i in zip(some, others, strict=True) if (cell := line[i]) is not None]
            if len(pairs) == count:
                yield pairs


def _sum_products_over_subsets(count: int, numbers: Sequence[int]) -> int:
    """Return the sum, over all subsets of ``count`` numbers, of the product of the numbers in the subset."""
    if count > len(numbers):
        return 0
    sums: list[int] = [1] + [0] * count
    for number in numbers:
        for size in range(count, 0, -1):
            sums[size] += sums[size - 1] * number
    return sums[count]


def _sum_products_over_matchings(count: int, weights: Sequence[Sequence[int]]) -> int:
    """Return the sum, over all matchings of ``count`` cells, of the product of the cells' weights.

    A matching is a set of cells with no two in one row or column.
    """
    rows, columns = len(weights), len(weights[0]) if weights else 0
    if count > min(rows, columns):
        return 0
    values = {weight for row in weights for weight in row}
    if len(values) == 1:
        placements = comb(rows, count) * comb(columns, count) * factorial(count)
        return placements * prod([values.pop()] * count)
    lines = weights if rows > columns else list(zip(*weights, strict=True))
    return _sum_matchings_row_by_row(count, lines)


def _sum_matchings_row_by_row(count: int, lines: Sequence[Sequence[int]]) -> int:
    """Compute the sum of `_sum_products_over_matchings` row by row.

    It keeps one partial sum for each set of columns that the cells chosen so far occupy.
    """
    sums = {0: 1}
    for line in lines:
        for taken, number in list(sums.items()):
            for column, weight in enumerate(line):
                if weight and not taken >> column & 1 and taken.bit_count() < count:
                    extended = taken | 1 << column
                    sums[extended] = sums.get(extended, 0) + number * weight
    return sum(number for taken, number in sums.items() if taken.bit_count() == count)


SHARED_WEIGHT = 1 << 20
"""Points that an option gets for each condition that the answer has, too. Each condition costs 1 point."""


@dataclass(slots=True, eq=False)
class _ScoredOption:
    """An option, as a bit mask of conditions, with its score.

    The score grows with the number of conditions that are also in the answer, and falls with the number of
    all conditions of the option.
    """

    score: int
    conditions: int


FindBestOption: TypeAlias = Callable[[int], "_ScoredOption | None"]
"""Function that takes the conditions of an answer, as a bit mask, and returns a goal's best option.

It returns None if there are no options.
"""


def make_best_option_finder(choice: Choice, number: Callable[[Literal], int]) -> FindBestOption:
    """Return a function that finds the option that shares most conditions with an answer.

    If several options share equally many, the shortest is chosen, then the first. Parts that must be true
    together are scored separately, so a condition in two parts counts twice.

    Args:
        choice: the choice tree of the goal.
        number: function that returns the number of a condition; equal conditions have equal numbers.
    """
    match choice:
        case LiteralChoice(literal):
            return _make_finder_for_mask(1 << number(literal))
        case AllOf(parts):
            leaves = [1 << number(part.literal) for part in parts if isinstance(part, LiteralChoice)]
            together = _make_finder_for_mask(reduce(or_, leaves, 0))
            others = [
                make_best_option_finder(part, number) for part in parts if not isinstance(part, LiteralChoice)
            ]
            return _make_finder_for_all((together, *others)) if others else together
        case AnyOf(parts):
            return _make_finder_for_any([make_best_option_finder(part, number) for part in parts])
        case ExactlyOf(count, parts):
            return _make_finder_for_subset(count, [make_best_option_finder(part, number) for part in parts])
        case PairingChoice(count, cells):
            return _make_finder_for_pairing(
                count,
                [
                    [None if cell is None else make_best_option_finder(cell, number) for cell in row]
                    for row in cells
                ],
            )
        case _:
            assert_never(choice)


def _make_finder_for_mask(mask: int) -> FindBestOption:
    size = mask.bit_count()
    return lambda stated: _ScoredOption((mask & stated).bit_count() * SHARED_WEIGHT - size, mask)


def _make_finder_for_all(parts: Sequence[FindBestOption]) -> FindBestOption:
    return lambda stated: _merge_scored_options([part(stated) for part in parts])


def _make_finder_for_any(parts: Sequence[FindBestOption]) -> FindBestOption:
    if len(parts) == 1:
        return parts[0]
    return lambda stated: max(filter(None, [part(stated) for part in parts]), key=_score, default=None)


def _make_finder_for_subset(count: int, parts: Sequence[FindBestOption]) -> FindBestOption:
    def find_best(stated: int) -> _ScoredOption | None:
        overlaps = [overlap for part in parts if (overlap := part(stated)) is not None]
        if len(overlaps) < count:
            return None
        return _merge_scored_options(sorted(overlaps, key=_score, reverse=True)[:count])

    return find_best


def _make_finder_for_pairing(count: int, table: Sequence[Sequence[FindBestOption | None]]) -> FindBestOption:
    def find_best(stated: int) -> _ScoredOption | None:
        overlaps = [[None if cell is None else cell(stated) for cell in row] for row in table]
        weights = [[None if overlap is None else overlap.score for overlap in row] for row in overlaps]
        cells = find_heaviest_matching(weights, count)
        return (
            None if cells is None else _merge_scored_options([overlaps[row][column] for row, column in cells])
        )

    return find_best


def _merge_scored_options(parts: Iterable[_ScoredOption | None]) -> _ScoredOption | None:
    """Merge one option of each part into one option; None if any part has no option."""
    score = conditions = 0
    for part in parts:
        if part is None:
            return None
        score += part.score
        conditions |= part.conditions
    return _ScoredOption(score, conditions)


_score = attrgetter("score")
