"""Plain formulas: read as the grammars read them, and most formulas are plain."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.errors import ParseError
from eai.logic.formula import Atom, Constant, Formula, Variable
from eai.logic.ltl import Dialect, parse, parse_by_grammar
from eai.logic.ltl_printer import print_ltl
from eai.logic.plain import MAX_BRACKETS, read_plain
from eai.logic.reader import Reading
from eai.logic.signature import Signature
from logic.random_formulas import ACTIONS, PREDICATES, formulas

SIGNATURE = Signature(PREDICATES, ACTIONS, ("cup.1", "sofa"))

OPERANDS = (
    "p",
    "grab",
    "grab(cup.1)",
    "open( cup.1 )",
    "next_to(sofa,cup.2)",
    "f()",
    "open(x)",
    "until(x)",
    "true",
    "x = y",
    "not",
    "not ",
    "not open(sofa)",
    "not (sofa)",
    "notopen(sofa)",
)
BINDERS = ("(", "exists x. (", "forall  y .(", "forn 1 x. (", "forpairs", "exists")
JOINTS = (
    ")",
    "and",
    " or ",
    "then",
    "\nthen ",
    "until",
    "implies",
    "always",
    " ",
    "\x0b",
    ".",
    "\xe9",
    "-",
    "1",
    ",",
)
WORDS = st.one_of(*map(st.sampled_from, (OPERANDS, BINDERS, JOINTS)))


def atom(text: str, position: int, scope: frozenset[str]) -> Formula:
    return Atom(text, (Constant(str(position)), *map(Variable, sorted(scope))))


def by_grammar(text: str, dialect: Dialect) -> Reading | None:
    try:
        return parse_by_grammar(text, SIGNATURE, dialect)
    except ParseError:
        return None


@given(st.lists(WORDS, max_size=9).map("".join), st.sampled_from(Dialect))
@settings(max_examples=600)
def test_plain_texts_mean_what_the_grammars_say(text: str, dialect: Dialect) -> None:
    if read_plain(text, atom) is not None:
        assert parse(text, SIGNATURE, dialect) == by_grammar(text, dialect)


@given(formulas(beyond_paper=False), st.sampled_from(Dialect))
@settings(max_examples=200)
def test_printed_formulas_mean_what_the_grammars_say(formula: Formula, dialect: Dialect) -> None:
    text = print_ltl(formula)
    assert parse(text, SIGNATURE, dialect) == by_grammar(text, dialect)


@pytest.mark.parametrize(
    "text",
    [
        " p ( a.1 , b ) ",
        "p(a) then q(b)and r()or(s(c)then p(a))",
        "exists x. (p(x) or q(x)) then (p(a) and q(b))",
        "forall\ny . ( exists x. (p(x, y)) )",
        "(" * MAX_BRACKETS + "p(a)" + ")" * MAX_BRACKETS,
        "not p(a) and not (q(b) or r()) then not exists x. (not p(x))",
    ],
)
def test_plain(text: str) -> None:
    assert read_plain(text, atom) is not None


@pytest.mark.parametrize(
    "text",
    [
        "",
        "p",
        "notp(a)",
        "not not p(a)",
        "not notp(a)",
        "not(a)",
        "not (a)",
        "not(p(a))",
        "p(a) then",
        "(p(a)",
        "p(a))",
        "p(a) q(b)",
        "p(a) until q(b)",
        "p(a)\x0b",
        "forn 1 x. (p(x))",
        "exists x: cup. (p(x))",
        "exists x. p(x)",
        "(" * (MAX_BRACKETS + 1) + "p(a)" + ")" * (MAX_BRACKETS + 1),
    ],
)
def test_left_to_the_grammars(text: str) -> None:
    assert read_plain(text, atom) is None


def test_primitives_come_with_their_places_and_variables() -> None:
    shown: list[tuple[str, int, frozenset[str]]] = []

    def primitive(text: str, position: int, scope: frozenset[str]) -> Formula:
        shown.append((text, position, scope))
        return Atom("p")

    read_plain("exists x. ( p(x) ) then q(a)", primitive)
    assert shown == [("p(x)", 12, frozenset({"x"})), ("q(a)", 24, frozenset())]
