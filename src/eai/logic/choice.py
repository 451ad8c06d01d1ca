"""The choices that are left when a formula is to be made true: its ground and-or tree.

The tree is polynomial in the number of objects, while the number of ways to choose is exponential. Options
are listed, counted and rated on it. An option is a list of ground conditions that makes the formula true: of
"every candle in a basket of its own" it says which candle and which basket. Options are produced one by one,
and counted without being produced; the one that shares most with an answer is found without listing them.
There conditions are numbered, and sets of them are bit masks (bit i = condition i).
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
from eai.logic.matching import heaviest_matching

Literal: TypeAlias = f.Atom | f.Occurs | f.Not
"""A ground atom, an action with its objects, or the negation of one of them."""


ObjectsByCategory: TypeAlias = Callable[[str | None], Sequence[str]]
"""The objects that variables range over: those of a category, each once, in a fixed order; of None all."""


T = TypeVar("T")
"""A part of a choice: a choice again, or a condition that may leave more to choose."""


@dataclass(frozen=True, slots=True)
class LiteralChoice:
    """A condition that is to hold; nothing to choose."""

    literal: Literal


@dataclass(frozen=True, slots=True)
class AllOf(Generic[T]):
    """Every part is to be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class AnyOf(Generic[T]):
    """One part is to be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class Choose(Generic[T]):
    """``count`` different parts are to be made true."""

    count: int
    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class Pairing(Generic[T]):
    """``count`` cells are to be made true, no two in one row or column; None marks what is no pair."""

    count: int
    cells: tuple[tuple[T | None, ...], ...]


Choice: TypeAlias = "LiteralChoice | AllOf[Choice] | AnyOf[Choice] | Choose[Choice] | Pairing[Choice]"


def ground(formula: f.Formula, objects: ObjectsByCategory) -> Choice:
    """The choices that a closed formula leaves; negation is pushed inwards to the conditions.

    ``then`` is read as a conjunction in a given order. For ``forn`` exactly that many instances are chosen
    and nothing is said about the others; a pairing takes as many pairs as the smaller category has objects
    (both as in bddl, ``condition_evaluation.py``), and no object is paired with itself.

    Raises:
        InputError: a variable is not bound; or a part leaves no finite choice of conditions: a temporal
            operator other than ``then``, a negated ``then`` or a negated counting quantifier.
    """
    return _Grounding(objects).ground(formula, {}, True)


class _Grounding:
    def __init__(self, objects: ObjectsByCategory) -> None:
        self._objects = objects

    def ground(self, formula: f.Formula, binding: Mapping[str, str], positive: bool) -> Choice:
        match formula:
            case f.Atom() | f.Occurs() | f.Equals():
                return _condition(formula, binding, positive)
            case f.Not(operand):
                return self.ground(operand, binding, not positive)
            case f.And(operands) | f.Or(operands):
                parts = tuple([self.ground(operand, binding, positive) for operand in operands])
                return AllOf(parts) if isinstance(formula, f.And) == positive else AnyOf(parts)
            case f.Implies(premise, conclusion):
                return self.ground(f.Or((f.Not(premise), conclusion)), binding, positive)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                parts = self._instances(variable, body, binding, positive)
                return AllOf(parts) if isinstance(formula, f.ForAll) == positive else AnyOf(parts)
            case f.Exactly(count, variable, body) if positive:
                return Choose(count, self._instances(variable, body, binding, True))
            case f.ForPairs() if positive:
                return self._pairing(formula, binding)
            case f.Then(steps) if positive:
                return AllOf(tuple([self.ground(step, binding, True) for step in steps]))
            case _:
                negated = "" if positive else "a negated "
                raise InputError(f"{negated}{type(formula).__name__} leaves no finite choice of conditions")

    def _instances(
        self, variable: f.Variable, body: f.Formula, binding: Mapping[str, str], positive: bool
    ) -> tuple[Choice, ...]:
        values = self._objects(variable.category)
        return tuple([self.ground(body, {**binding, variable.name: value}, positive) for value in values])

    def _pairing(self, formula: f.ForPairs, binding: Mapping[str, str]) -> Pairing[Choice]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._objects(first.category), self._objects(second.category)

        def cell(x: str, y: str) -> Choice | None:
            return None if x == y else self.ground(body, {**binding, first.name: x, second.name: y}, True)

        count = min(len(rows), len(columns)) if formula.count is None else formula.count
        return Pairing(count, tuple(tuple(cell(x, y) for y in columns) for x in rows))


def _condition(formula: f.Atom | f.Occurs | f.Equals, binding: Mapping[str, str], positive: bool) -> Choice:
    match formula:
        case f.Equals(left, right):
            true = value_of(left, binding) == value_of(right, binding)
            return AllOf(()) if true == positive else AnyOf(())
        case f.Atom(predicate, arguments):
            literal: f.Atom | f.Occurs = f.Atom(predicate, tuple([value_of(t, binding) for t in arguments]))
        case f.Occurs(action, arguments):
            literal = f.Occurs(action, tuple([value_of(t, binding) for t in arguments]))
    return LiteralChoice(literal if positive else f.Not(literal))


def value_of(term: f.Term, binding: Mapping[str, str]) -> f.Constant:
    """The object that a term denotes when variables have these values.

    Raises:
        InputError: it is a variable without a value.
    """
    if isinstance(term, f.Constant):
        return term
    if term.name not in binding:
        raise InputError(f"variable {term.name} is not bound by a quantifier")
    return f.Constant(binding[term.name])


Option: TypeAlias = tuple[Literal, ...]
"""Ground conditions in the order of the formula; they may repeat and even contradict each other."""


def options(formula: f.Formula, objects: ObjectsByCategory) -> Iterator[Option]:
    """The options of a closed formula, lazily, in the order of its disjuncts and of the objects.

    Two options may have the same conditions, when a condition stands in two disjuncts.

    Raises:
        InputError: the formula has no finite options (see `ground`).
    """
    return choice_options(ground(formula, objects))


def count_options(formula: f.Formula, objects: ObjectsByCategory) -> int:
    """How many options `options` gives, without producing them.

    Takes time polynomial in the number of objects, except for pairings in which an object may stand on both
    sides or whose pairs differ in their numbers of options: those are exponential in the smaller side.

    Raises:
        InputError: the formula has no finite options (see `ground`).
    """
    return count_choice_options(ground(formula, objects))


def choice_options(choice: Choice) -> Iterator[Option]:
    """All ways to choose, each as its list of conditions; later choices vary fastest."""
    match choice:
        case LiteralChoice(literal):
            yield (literal,)
        case AllOf(parts):
            yield from _product(parts)
        case AnyOf(parts):
            yield from chain.from_iterable(map(choice_options, parts))
        case Choose(count, parts):
            if count <= len(parts):  # `combinations` reserves a place for each of `count` parts at once
                yield from chain.from_iterable(map(_product, combinations(parts, count)))
        case Pairing(count, cells):
            for pairs in _pairings(count, cells):
                yield from _product(pairs)
        case _:
            assert_never(choice)


def count_choice_options(choice: Choice) -> int:
    """How many options `choice_options` gives, without producing them."""
    match choice:
        case LiteralChoice():
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
    lines = cells if len(cells) < (len(cells[0]) if cells else 0) else list(zip(*cells, strict=True))
    across = len(lines[0]) if lines else 0
    if count > min(len(lines), across):  # as in `choice_options`
        return
    for some in combinations(lines, count):
        for others in permutations(range(across), count):
            pairs = [cell for line, i in zip(some, others, strict=True) if (cell := line[i]) is not None]
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


SHARED_WEIGHT = 1 << 20
"""The weight of a condition that is shared against the conditions that are not, of which each counts 1."""


@dataclass(slots=True, eq=False)
class _Overlap:
    """One option: the more it shares with what is said, and the shorter it is, the better its score."""

    score: int
    conditions: int


BestOverlap: TypeAlias = Callable[[int], "_Overlap | None"]
"""Gives the best option for the conditions that are said; None if there are no options."""


def best_overlap(choice: Choice, number: Callable[[Literal], int]) -> BestOverlap:
    """A function that finds the option that shares most conditions with what is said.

    Of several the shortest is taken, of several of those the first. Parts that are chosen together are rated
    each by itself: a condition that stands in two of them counts in both.

    Args:
        choice: the goal's options.
        number: the number of each condition; equal conditions have equal numbers.
    """
    match choice:
        case LiteralChoice(literal):
            return _conditions(1 << number(literal))
        case AllOf(parts):
            leaves = [1 << number(part.literal) for part in parts if isinstance(part, LiteralChoice)]
            together = _conditions(reduce(or_, leaves, 0))
            others = [best_overlap(part, number) for part in parts if not isinstance(part, LiteralChoice)]
            return _all_of((together, *others)) if others else together
        case AnyOf(parts):
            return _any_of([best_overlap(part, number) for part in parts])
        case Choose(count, parts):
            return _some_of(count, [best_overlap(part, number) for part in parts])
        case Pairing(count, cells):
            return _paired(
                count,
                [[None if cell is None else best_overlap(cell, number) for cell in row] for row in cells],
            )
        case _:
            assert_never(choice)


def _conditions(mask: int) -> BestOverlap:
    size = mask.bit_count()
    return lambda said: _Overlap((mask & said).bit_count() * SHARED_WEIGHT - size, mask)


def _all_of(parts: Sequence[BestOverlap]) -> BestOverlap:
    return lambda said: _together([part(said) for part in parts])


def _any_of(parts: Sequence[BestOverlap]) -> BestOverlap:
    if len(parts) == 1:
        return parts[0]
    return lambda said: max(filter(None, [part(said) for part in parts]), key=_score, default=None)


def _some_of(count: int, parts: Sequence[BestOverlap]) -> BestOverlap:
    def best(said: int) -> _Overlap | None:
        found = [each for part in parts if (each := part(said)) is not None]
        if len(found) < count:
            return None
        return _together(sorted(found, key=_score, reverse=True)[:count])

    return best


def _paired(count: int, table: Sequence[Sequence[BestOverlap | None]]) -> BestOverlap:
    def best(said: int) -> _Overlap | None:
        found = [[None if cell is None else cell(said) for cell in row] for row in table]
        weights = [[None if each is None else each.score for each in row] for row in found]
        cells = heaviest_matching(weights, count)
        return None if cells is None else _together([found[row][column] for row, column in cells])

    return best


def _together(parts: Iterable[_Overlap | None]) -> _Overlap | None:
    """Options of several parts as one; None if a part has none."""
    score = conditions = 0
    for part in parts:
        if part is None:
            return None
        score += part.score
        conditions |= part.conditions
    return _Overlap(score, conditions)


_score = attrgetter("score")
