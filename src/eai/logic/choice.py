"""And-or trees: the alternative sets of ground conditions that make a formula true.

A term of the disjunctive normal form (DNF) is a list of ground conditions that makes the formula true. For
"every candle in a basket of its own" a term assigns a basket to each candle. The tree is polynomial in the
number of objects, while the number of terms is exponential. So terms are generated one by one, and counted
without being generated. The term that shares most conditions with a model's answer is found without listing
the other terms. For this search, conditions are numbered, and sets of conditions are bit masks (bit i =
condition i).
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
"""Type of the parts of an and-or tree: each part is another and-or tree or, in the planner, a subgoal."""


@dataclass(frozen=True, slots=True)
class AndOrTreeLiteral:
    """An and-or tree that consists of one ground condition, without any choice."""

    literal: Literal


@dataclass(frozen=True, slots=True)
class AndNode(Generic[T]):
    """An and-or tree whose parts must all be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class OrNode(Generic[T]):
    """An and-or tree with alternative parts: one part must be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class ExactCountNode(Generic[T]):
    """An and-or tree with alternative parts: exactly ``count`` parts must be made true."""

    count: int
    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class BipartiteMatchingNode(Generic[T]):
    """A node of an and-or tree whose subtrees stand in a table, such as one subtree for each pair of objects.

    The node is true if ``count`` cells of the table are true, no two of them in one row or column. A cell
    that is None cannot be chosen.
    """

    count: int
    cells: tuple[tuple[T | None, ...], ...]


AndOrTree: TypeAlias = (
    "AndOrTreeLiteral | AndNode[AndOrTree] | OrNode[AndOrTree] | ExactCountNode[AndOrTree]"
    " | BipartiteMatchingNode[AndOrTree]"
)


def build_and_or_tree(formula: f.Formula, objects: ObjectsByCategory) -> AndOrTree:
    """Return the and-or tree of a closed formula. Negation is pushed inwards to the conditions.

    ``then`` is treated as a conjunction in a given order. For ``forn`` (exactly n objects) the body must
    become true for n objects, and may also be true for others. For ``forpairs`` each object of the smaller
    category needs its own partner, and the body must become true for the pair; for ``fornpairs``, n pairs are
    enough. These rules follow the package ``bddl`` (``condition_evaluation.py``). No object is paired with
    itself.

    Raises:
        InputError: a variable is not bound; or a part has no finite tree: a temporal operator other than
            ``then``, a negated ``then`` or a negated counting quantifier.
    """
    return _AndOrTreeBuilder(objects).build(formula, {}, True)


class _AndOrTreeBuilder:
    def __init__(self, objects: ObjectsByCategory) -> None:
        self._objects = objects

    def build(self, formula: f.Formula, binding: Mapping[str, str], positive: bool) -> AndOrTree:
        match formula:
            case f.Atom() | f.Occurs() | f.Equals():
                return _build_leaf(formula, binding, positive)
            case f.Not(operand):
                return self.build(operand, binding, not positive)
            case f.And(operands) | f.Or(operands):
                parts = tuple([self.build(operand, binding, positive) for operand in operands])
                return AndNode(parts) if isinstance(formula, f.And) == positive else OrNode(parts)
            case f.Implies(premise, conclusion):
                return self.build(f.Or((f.Not(premise), conclusion)), binding, positive)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                parts = self._build_tree_for_each_value(variable, body, binding, positive)
                return AndNode(parts) if isinstance(formula, f.ForAll) == positive else OrNode(parts)
            case f.Exactly(count, variable, body) if positive:
                return ExactCountNode(count, self._build_tree_for_each_value(variable, body, binding, True))
            case f.ForPairs() if positive:
                return self._build_node_of_pairs_quantifier(formula, binding)
            case f.Then(steps) if positive:
                return AndNode(tuple([self.build(step, binding, True) for step in steps]))
            case _:
                negated = "" if positive else "a negated "
                raise InputError(
                    f"{negated}{type(formula).__name__} can become true in infinitely many ways, "
                    "which cannot be listed: write the formula without it"
                )

    def _build_tree_for_each_value(
        self, variable: f.Variable, body: f.Formula, binding: Mapping[str, str], positive: bool
    ) -> tuple[AndOrTree, ...]:
        values = self._objects(variable.category)
        return tuple([self.build(body, {**binding, variable.name: value}, positive) for value in values])

    def _build_node_of_pairs_quantifier(
        self, formula: f.ForPairs, binding: Mapping[str, str]
    ) -> BipartiteMatchingNode[AndOrTree]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._objects(first.category), self._objects(second.category)

        def build_quantifier_body_tree_for_pair(first_object: str, second_object: str) -> AndOrTree | None:
            if first_object == second_object:
                return None
            return self.build(body, {**binding, first.name: first_object, second.name: second_object}, True)

        count = min(len(rows), len(columns)) if formula.count is None else formula.count
        return BipartiteMatchingNode(
            count, tuple(tuple(build_quantifier_body_tree_for_pair(x, y) for y in columns) for x in rows)
        )


def _build_leaf(
    formula: f.Atom | f.Occurs | f.Equals, binding: Mapping[str, str], positive: bool
) -> AndOrTree:
    match formula:
        case f.Equals(left, right):
            true = resolve_term(left, binding) == resolve_term(right, binding)
            return AndNode(()) if true == positive else OrNode(())
        case f.Atom(predicate, arguments):
            literal: f.Atom | f.Occurs = f.Atom(
                predicate, tuple([resolve_term(t, binding) for t in arguments])
            )
        case f.Occurs(action, arguments):
            literal = f.Occurs(action, tuple([resolve_term(t, binding) for t in arguments]))
    return AndOrTreeLiteral(literal if positive else f.Not(literal))


def resolve_term(term: f.Term, binding: Mapping[str, str]) -> f.Constant:
    """Return the object that a term denotes under a binding of variables.

    Raises:
        InputError: the term is a variable without a value.
    """
    if isinstance(term, f.Constant):
        return term
    if term.name not in binding:
        raise InputError(f"variable {term.name} is not bound: bind it with exists or forall")
    return f.Constant(binding[term.name])


DnfTerm: TypeAlias = tuple[Literal, ...]
"""Ground conditions that make a formula true, in the order of the formula.

A condition may occur more than once, and conditions may contradict each other.
"""


def generate_dnf_terms(formula: f.Formula, objects: ObjectsByCategory) -> Iterator[DnfTerm]:
    """Yield the DNF terms of a closed formula, in the order of the formula's disjuncts and of the objects.

    Two DNF terms may have the same conditions, if the formula has a condition in two disjuncts.

    Raises:
        InputError: the formula has no finite and-or tree (see `build_and_or_tree`).
    """
    return generate_dnf_terms_of_tree(build_and_or_tree(formula, objects))


def count_dnf_terms(formula: f.Formula, objects: ObjectsByCategory) -> int:
    """Count the DNF terms of a closed formula without generating them.

    This takes time polynomial in the number of objects, with two exceptions. Both are quantifiers over pairs
    of objects (``forpairs``). Either some object belongs to both categories, or the body does not have the
    same number of DNF terms for all pairs. These quantifiers take time exponential in the size of the smaller
    category.

    Raises:
        InputError: the formula has no finite and-or tree (see `build_and_or_tree`).
    """
    return count_dnf_terms_of_tree(build_and_or_tree(formula, objects))


def generate_dnf_terms_of_tree(tree: AndOrTree) -> Iterator[DnfTerm]:
    """Yield the DNF terms of an and-or tree, each as a tuple of conditions; later choices vary fastest."""
    match tree:
        case AndOrTreeLiteral(literal):
            yield (literal,)
        case AndNode(parts):
            yield from _combine_dnf_terms_of_parts(parts)
        case OrNode(parts):
            yield from chain.from_iterable(map(generate_dnf_terms_of_tree, parts))
        case ExactCountNode(count, parts):
            if count <= len(parts):  # a huge `count` would fill memory in `combinations`
                yield from chain.from_iterable(map(_combine_dnf_terms_of_parts, combinations(parts, count)))
        case BipartiteMatchingNode(count, cells):
            for pairs in _generate_bipartite_matchings(count, cells):
                yield from _combine_dnf_terms_of_parts(pairs)
        case _:
            assert_never(tree)


def count_dnf_terms_of_tree(tree: AndOrTree) -> int:
    """Count the DNF terms of an and-or tree without generating them."""
    match tree:
        case AndOrTreeLiteral():
            return 1
        case AndNode(parts):
            return prod(map(count_dnf_terms_of_tree, parts))
        case OrNode(parts):
            return sum(map(count_dnf_terms_of_tree, parts))
        case ExactCountNode(count, parts):
            return _sum_products_over_subsets(count, [count_dnf_terms_of_tree(part) for part in parts])
        case BipartiteMatchingNode(count, cells):
            numbers = [
                [0 if cell is None else count_dnf_terms_of_tree(cell) for cell in row] for row in cells
            ]
            return _count_dnf_terms_of_bipartite_matchings(count, numbers)
        case _:
            assert_never(tree)


def _combine_dnf_terms_of_parts(parts: Sequence[AndOrTree]) -> Iterator[DnfTerm]:
    if not parts:
        yield ()
        return
    for head in generate_dnf_terms_of_tree(parts[0]):
        for tail in _combine_dnf_terms_of_parts(parts[1:]):
            yield head + tail


def _generate_bipartite_matchings(
    matching_size: int, trees_by_row: Sequence[Sequence[AndOrTree | None]]
) -> Iterator[list[AndOrTree]]:
    """Yield all sets of ``matching_size`` cells of a table in which no two cells share a row or column.

    The sets are ordered by rows if the table has fewer rows than columns, else by columns.
    """
    lines = (
        trees_by_row
        if len(trees_by_row) < (len(trees_by_row[0]) if trees_by_row else 0)
        else list(zip(*trees_by_row, strict=True))
    )
    across = len(lines[0]) if lines else 0
    if matching_size > min(len(lines), across):  # a huge `count` would fill memory in `combinations`
        return
    for some in combinations(lines, matching_size):
        for others in permutations(range(across), matching_size):
            pairs = [cell for line, i in zip(some, others, strict=True) if (cell := line[i]) is not None]
            if len(pairs) == matching_size:
                yield pairs


def _sum_products_over_subsets(subset_size: int, numbers: Sequence[int]) -> int:
    """Return the sum, over all subsets of ``numbers`` of the given size, of the product of the subset."""
    if subset_size > len(numbers):
        return 0
    sums: list[int] = [1] + [0] * subset_size
    for number in numbers:
        for size in range(subset_size, 0, -1):
            sums[size] += sums[size - 1] * number
    return sums[subset_size]


def _count_dnf_terms_of_bipartite_matchings(
    matching_size: int, term_count_table: Sequence[Sequence[int]]
) -> int:
    """Count the DNF terms of a node with a table of subtrees (`BipartiteMatchingNode`).

    ``term_count_table`` has the number of DNF terms of each cell of the table. The node is true if
    ``matching_size`` cells are true, no two of them in one row or column. Each such set of cells has as many
    DNF terms as the product of the numbers of its cells.
    """
    rows, columns = len(term_count_table), len(term_count_table[0]) if term_count_table else 0
    if matching_size > min(rows, columns):
        return 0
    values = {cell_count for row in term_count_table for cell_count in row}
    if len(values) == 1:
        placements = comb(rows, matching_size) * comb(columns, matching_size) * factorial(matching_size)
        terms_of_matching: int = values.pop() ** matching_size
        return placements * terms_of_matching
    lines = term_count_table if rows > columns else list(zip(*term_count_table, strict=True))
    return _count_dnf_terms_of_matchings_row_by_row(matching_size, lines)


def _count_dnf_terms_of_matchings_row_by_row(
    matching_size: int, term_count_table: Sequence[Sequence[int]]
) -> int:
    """Return the same number as `_count_dnf_terms_of_bipartite_matchings`. Choose cells row by row.

    The number of DNF terms of the cells that are chosen so far is kept for each set of columns with a
    chosen cell.
    """
    sums = {0: 1}
    for line in term_count_table:
        for taken, number in list(sums.items()):
            for column, cell_count in enumerate(line):
                if cell_count and not taken >> column & 1 and taken.bit_count() < matching_size:
                    extended = taken | 1 << column
                    sums[extended] = sums.get(extended, 0) + number * cell_count
    return sum(number for taken, number in sums.items() if taken.bit_count() == matching_size)


SHARED_WEIGHT = 1 << 20
"""Points of a DNF term for each condition that it shares with a model's answer.

Each condition of the term costs 1 point. The term with most points is closest to the answer.
"""


@dataclass(slots=True, eq=False)
class _ScoredDnfTerm:
    """A DNF term of a goal, as a bit mask of conditions, with its score for a model's answer.

    The score grows with the number of conditions that the DNF term shares with the answer. It falls with the
    number of all conditions of the DNF term.
    """

    score: int
    conditions: int


FindDnfTermClosestToAnswer: TypeAlias = Callable[[int], "_ScoredDnfTerm | None"]
"""Function that returns the DNF term of a goal that shares most conditions with an answer.

Its argument is the mask of the answer's conditions. It returns None if the goal has no DNF term.
"""


def make_finder_of_dnf_term_closest_to_answer(
    tree: AndOrTree, get_condition_number: Callable[[Literal], int]
) -> FindDnfTermClosestToAnswer:
    """Return a function that finds the DNF term that shares most conditions with an answer.

    If several DNF terms share equally many, the shortest is chosen, then the first. The score of a
    conjunction is the sum of the scores of its parts. All literals of the conjunction together are one part,
    in which a condition counts once. A condition that occurs in two parts counts twice.

    Args:
        tree: the and-or tree of the goal.
        get_condition_number: returns the number of a condition; equal conditions have equal numbers.
    """
    match tree:
        case AndOrTreeLiteral(literal):
            return _make_dnf_term_finder_for_literals(1 << get_condition_number(literal))
        case AndNode(parts):
            leaves = [
                1 << get_condition_number(part.literal)
                for part in parts
                if isinstance(part, AndOrTreeLiteral)
            ]
            together = _make_dnf_term_finder_for_literals(reduce(or_, leaves, 0))
            others = [
                make_finder_of_dnf_term_closest_to_answer(part, get_condition_number)
                for part in parts
                if not isinstance(part, AndOrTreeLiteral)
            ]
            return _make_dnf_term_finder_for_conjunction((together, *others)) if others else together
        case OrNode(parts):
            return _make_dnf_term_finder_for_disjunction(
                [make_finder_of_dnf_term_closest_to_answer(part, get_condition_number) for part in parts]
            )
        case ExactCountNode(count, parts):
            return _make_dnf_term_finder_for_exact_count(
                count,
                [make_finder_of_dnf_term_closest_to_answer(part, get_condition_number) for part in parts],
            )
        case BipartiteMatchingNode(count, cells):
            return _make_dnf_term_finder_for_bipartite_matching(
                count,
                [
                    [
                        None
                        if cell is None
                        else make_finder_of_dnf_term_closest_to_answer(cell, get_condition_number)
                        for cell in row
                    ]
                    for row in cells
                ],
            )
        case _:
            assert_never(tree)


def _make_dnf_term_finder_for_literals(literal_mask: int) -> FindDnfTermClosestToAnswer:
    size = literal_mask.bit_count()
    return lambda stated: _ScoredDnfTerm(
        (literal_mask & stated).bit_count() * SHARED_WEIGHT - size, literal_mask
    )


def _make_dnf_term_finder_for_conjunction(
    part_finders: Sequence[FindDnfTermClosestToAnswer],
) -> FindDnfTermClosestToAnswer:
    return lambda stated: _conjoin_scored_dnf_terms([find(stated) for find in part_finders])


def _make_dnf_term_finder_for_disjunction(
    part_finders: Sequence[FindDnfTermClosestToAnswer],
) -> FindDnfTermClosestToAnswer:
    if len(part_finders) == 1:
        return part_finders[0]
    return lambda stated: max(filter(None, [find(stated) for find in part_finders]), key=_score, default=None)


def _make_dnf_term_finder_for_exact_count(
    count: int, part_finders: Sequence[FindDnfTermClosestToAnswer]
) -> FindDnfTermClosestToAnswer:
    def find_dnf_term_closest_to_answer(answer_condition_mask: int) -> _ScoredDnfTerm | None:
        overlaps = [overlap for part in part_finders if (overlap := part(answer_condition_mask)) is not None]
        if len(overlaps) < count:
            return None
        return _conjoin_scored_dnf_terms(sorted(overlaps, key=_score, reverse=True)[:count])

    return find_dnf_term_closest_to_answer


def _make_dnf_term_finder_for_bipartite_matching(
    matching_size: int, finder_table: Sequence[Sequence[FindDnfTermClosestToAnswer | None]]
) -> FindDnfTermClosestToAnswer:
    def find_dnf_term_closest_to_answer(answer_condition_mask: int) -> _ScoredDnfTerm | None:
        overlaps = [
            [None if cell is None else cell(answer_condition_mask) for cell in row] for row in finder_table
        ]
        weights = [[None if overlap is None else overlap.score for overlap in row] for row in overlaps]
        cells = find_heaviest_matching(weights, matching_size)
        if cells is None:
            return None
        return _conjoin_scored_dnf_terms([overlaps[row][column] for row, column in cells])

    return find_dnf_term_closest_to_answer


def _conjoin_scored_dnf_terms(parts: Iterable[_ScoredDnfTerm | None]) -> _ScoredDnfTerm | None:
    """Merge one DNF term of each conjunct into one DNF term, and add their scores.

    Return None if a conjunct has no DNF term, because nothing makes it true.
    """
    score = conditions = 0
    for part in parts:
        if part is None:
            return None
        score += part.score
        conditions |= part.conditions
    return _ScoredDnfTerm(score, conditions)


_score = attrgetter("score")
