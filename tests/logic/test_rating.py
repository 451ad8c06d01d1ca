"""Frontiers: the most good conditions for every size of an option."""

from __future__ import annotations

import pytest

from eai.logic.choice import Literal, ground
from eai.logic.formula import Atom
from eai.logic.ltl import parse
from eai.logic.rating import Frontier, alternatives, combined, ratings
from logic.activities import universe


def good(literal: Literal) -> bool:
    """Conditions on the object 0 of a category are good."""
    return isinstance(literal, Atom) and all(term.name.endswith("0") for term in literal.arguments)


@pytest.mark.parametrize(
    ("text", "frontier"),
    [
        ("p(a0)", {1: 1}),
        ("not p(a0)", {1: 0}),
        ("p(a0) and p(a1)", {2: 1}),
        ("p(a0) and (p(a0) or p(a1))", {1: 1, 2: 1}),
        ("p(a0) or p(a1) and q(a1)", {1: 1, 2: 0}),
        ("exists x: a. (p(x))", {1: 1}),
        ("forall x: a. (p(x))", {3: 1}),
        ("forn 2 x: a. (p(x))", {2: 1}),
        ("forn 1 x: a. (p(x) or q(x) and r(x))", {1: 1, 2: 2}),
        ("forn 4 x: a. (p(x))", {}),
        ("forpairs x: a, y: b. (in(x, y))", {2: 1}),
        ("forpairs x: a, y: b. (p(x) and q(y))", {4: 2}),
        ("forpairs x: a, y: b. (in(x, y) or on(x, y) and by(x, y))", {2: 1, 3: 2, 4: 2}),
        ("fornpairs 3 x: a, y: b. (in(x, y))", {}),
        ("true", {0: 0}),
        ("false", {}),
    ],
)
def test_ratings(text: str, frontier: Frontier) -> None:
    assert ratings(ground(parse(text).formula, universe(a=3, b=2)), good) == frontier


def test_combining_and_choosing() -> None:
    assert combined({1: 1, 2: 0}, {1: 0, 3: 3}) == {2: 1, 3: 0, 4: 4, 5: 3}
    assert alternatives([(1, 0), (2, 1), (1, 1)]) == {1: 1, 2: 1}
