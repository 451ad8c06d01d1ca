"""The option that shares most with what is said, against all options one by one."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.logic.choice import AllOf, AnyOf, Choice, Choose, Leaf, Literal, Pairing, ground
from eai.logic.formula import Atom, Constant
from eai.logic.ltl import parse
from eai.logic.options import choice_options
from eai.logic.overlap import best_overlap
from logic.activities import universe


class Numbers:
    """Numbers literals as they come."""

    def __init__(self) -> None:
        self.of: dict[Literal, int] = {}

    def __call__(self, literal: Literal) -> int:
        return self.of.setdefault(literal, len(self.of))

    def mask(self, is_in: Callable[[Literal], bool]) -> int:
        return sum(1 << number for literal, number in self.of.items() if is_in(literal))


def on_first(literal: Literal) -> bool:
    """What is said: all about the objects numbered 0."""
    return isinstance(literal, Atom) and all(term.name.endswith("0") for term in literal.arguments)


@pytest.mark.parametrize(
    ("text", "shared", "size"),
    [
        ("p(a0)", 1, 1),
        ("not p(a0)", 0, 1),
        ("p(a0) and p(a1)", 1, 2),
        ("p(a1) or p(a0)", 1, 1),
        ("p(a1) and q(a1) or p(a2)", 0, 1),
        ("p(a0) and q(a1) or p(a0)", 1, 1),
        ("p(a1) or p(a0) and q(a0) and q(a1)", 2, 3),
        ("exists x: a. (p(x))", 1, 1),
        ("forall x: a. (p(x))", 1, 3),
        ("forall x: a. (p(x) or q(x) and r(x))", 2, 4),
        ("forn 2 x: a. (p(x))", 1, 2),
        ("forn 1 x: a. (p(x) or q(x) and r(x))", 2, 2),
        ("forpairs x: a, y: b. (in(x, y))", 1, 2),
        ("forpairs x: a, y: b. (p(x) and q(y))", 2, 4),
        ("fornpairs 1 x: a, y: b. (p(x) and q(y))", 2, 2),
        ("true", 0, 0),
    ],
)
def test_the_best_option(text: str, shared: int, size: int) -> None:
    numbers = Numbers()
    find = best_overlap(ground(parse(text).formula, universe(a=3, b=2).objects), numbers)
    said = numbers.mask(on_first)
    best = find(said)
    assert best is not None
    assert ((best.conditions & said).bit_count(), best.conditions.bit_count()) == (shared, size)


@pytest.mark.parametrize(
    "text",
    [
        "false",
        "p(a0) and false",
        "forn 4 x: a. (p(x))",
        "fornpairs 3 x: a, y: b. (in(x, y))",
        "exists x: c. (p(x))",
    ],
)
def test_what_nothing_can_make_true_has_no_option(text: str) -> None:
    assert best_overlap(ground(parse(text).formula, universe(a=3, b=2).objects), Numbers())(0) is None


def choices(leaves: st.SearchStrategy[Choice]) -> st.SearchStrategy[Choice]:
    parts = st.lists(leaves, max_size=3).map(tuple)
    return (
        parts.map(AllOf)
        | parts.map(AnyOf)
        | st.builds(Choose, st.integers(0, 2), parts)
        | st.tuples(st.integers(0, 2), st.lists(leaves, min_size=4, max_size=4)).map(
            lambda drawn: Pairing(drawn[0], (tuple(drawn[1][:2]), tuple(drawn[1][2:])))
        )
    )


CHOICES = st.recursive(
    st.integers(0, 6).map(lambda n: Leaf(Atom("p", (Constant(str(n)),)))), choices, max_leaves=8
)


@given(CHOICES, st.sets(st.integers(0, 6)))
def test_of_all_options_none_shares_more_and_of_those_none_is_shorter(choice: Choice, said: set[int]) -> None:
    seen: dict[int, Literal] = {}

    def apart(literal: Literal) -> int:
        """Conditions are told apart by their place, so that none stands in two parts."""
        seen[len(seen)] = literal
        return len(seen) - 1

    def is_said(literal: Literal) -> bool:
        return isinstance(literal, Atom) and int(literal.arguments[0].name) in said

    find = best_overlap(choice, apart)
    best = find(sum(1 << place for place, literal in seen.items() if is_said(literal)))
    rated = [(sum(map(is_said, option)), -len(option)) for option in choice_options(choice)]
    if best is None:
        assert rated == []
        return
    chosen = [seen[place] for place in range(len(seen)) if best.conditions >> place & 1]
    assert (sum(map(is_said, chosen)), -len(chosen)) == max(rated)
    assert sorted(map(str, chosen)) in [sorted(map(str, option)) for option in choice_options(choice)]


def test_goals_with_astronomically_many_options_take_no_time() -> None:
    numbers = Numbers()
    text = "forpairs x: a, y: b. (in(x, y)) and forall x: a. (exists y: b. (on(x, y)))"
    find = best_overlap(ground(parse(text).formula, universe(a=12, b=12).objects), numbers)
    best = find(numbers.mask(on_first))
    assert best is not None
    assert best.conditions.bit_count() == 24
