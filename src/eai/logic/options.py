"""The ground options of a goal: the lists of ground conditions any of which makes it true.

Goals may speak of objects in general ("every candle in a basket of its own"); an option says which
candle and which basket. Options are produced one by one, and counted without being produced.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, combinations, permutations
from math import comb, factorial, prod
from typing import TypeAlias

from typing_extensions import assert_never

from eai.logic.choice import AllOf, AnyOf, Choice, Choose, Leaf, Literal, Objects, Pairing, ground
from eai.logic.formula import Formula

Option: TypeAlias = tuple[Literal, ...]
"""Ground conditions in the order of the formula; they may repeat and even contradict each other."""


def options(formula: Formula, objects: Objects) -> Iterator[Option]:
    """The options of a closed formula, lazily, in the order of its disjuncts and of the objects.

    Two options may have the same conditions, when a condition stands in two disjuncts.

    Raises:
        InputError: the formula has no finite options (see `choice.ground`).
    """
    return choice_options(ground(formula, objects))


def count_options(formula: Formula, objects: Objects) -> int:
    """How many options `options` gives, without producing them.

    Takes time polynomial in the number of objects, except for pairings in which an object may stand on both
    sides or whose pairs differ in their numbers of options: those are exponential in the smaller side.

    Raises:
        InputError: the formula has no finite options (see `choice.ground`).
    """
    return count_choice_options(ground(formula, objects))


def choice_options(choice: Choice) -> Iterator[Option]:
    """All ways to choose, each as its list of conditions; later choices vary fastest."""
    match choice:
        case Leaf(literal):
            yield (literal,)
        case AllOf(parts):
            yield from _product(parts)
        case AnyOf(parts):
            yield from chain.from_iterable(map(choice_options, parts))
        case Choose(count, parts):
            for chosen in combinations(parts, count) if count <= len(parts) else ():
                yield from _product(chosen)
        case Pairing(count, cells):
            for pairs in _pairings(count, cells):
                yield from _product(pairs)
        case _:
            assert_never(choice)


def count_choice_options(choice: Choice) -> int:
    """How many options `choice_options` gives, without producing them."""
    match choice:
        case Leaf():
            return 1
        case AllOf(parts):
            return prod(map(count_choice_options, parts))
        case AnyOf(parts):
            return sum(map(count_choice_options, parts))
        case Choose(count, parts):
            return _elementary(count, [count_choice_options(part) for part in parts])
        case Pairing(count, cells):
            numbers = [[0 if cell is None else count_choice_options(cell) for cell in row] for row in cells]
            return _matchings(count, numbers)
        case _:
            assert_never(choice)


def _product(parts: Sequence[Choice]) -> Iterator[Option]:
    if not parts:
        yield ()
        return
    for head in choice_options(parts[0]):
        for tail in _product(parts[1:]):
            yield head + tail


def _pairings(count: int, cells: Sequence[Sequence[Choice | None]]) -> Iterator[list[Choice]]:
    """All sets of ``count`` cells without a common row or column; the smaller side keeps its order."""
    rows, columns = len(cells), len(cells[0]) if cells else 0
    if count > min(rows, columns):
        return
    if rows < columns:
        places: Iterable[list[tuple[int, int]]] = (
            list(zip(some, others, strict=True))
            for some in combinations(range(rows), count)
            for others in permutations(range(columns), count)
        )
    else:
        places = (
            list(zip(others, some, strict=True))
            for some in combinations(range(columns), count)
            for others in permutations(range(rows), count)
        )
    for place in places:
        pairs = [cell for cell in (cells[i][j] for i, j in place) if cell is not None]
        if len(pairs) == count:
            yield pairs


def _elementary(count: int, numbers: Sequence[int]) -> int:
    """The sum of the products of all ``count``-element subsets."""
    if count > len(numbers):
        return 0
    sums: list[int] = [1] + [0] * count
    for number in numbers:
        for size in range(count, 0, -1):
            sums[size] += sums[size - 1] * number
    return sums[count]


def _matchings(count: int, weights: Sequence[Sequence[int]]) -> int:
    """The sum over all matchings of ``count`` cells of the products of their weights."""
    rows, columns = len(weights), len(weights[0]) if weights else 0
    if count > min(rows, columns):
        return 0
    values = {weight for row in weights for weight in row}
    if len(values) == 1:
        placements = comb(rows, count) * comb(columns, count) * factorial(count)
        return placements * prod([values.pop()] * count)
    lines = weights if rows > columns else list(zip(*weights, strict=True))
    return _matchings_by_subsets(count, lines)


def _matchings_by_subsets(count: int, lines: Sequence[Sequence[int]]) -> int:
    """The same, line by line: of the lines before only matters which places across are taken."""
    sums = {0: 1}
    for line in lines:
        for taken, number in list(sums.items()):
            for place, weight in enumerate(line):
                if weight and not taken >> place & 1 and taken.bit_count() < count:
                    wider = taken | 1 << place
                    sums[wider] = sums.get(wider, 0) + number * weight
    return sum(number for taken, number in sums.items() if taken.bit_count() == count)
