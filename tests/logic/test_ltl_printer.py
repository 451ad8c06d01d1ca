"""The printer of LTL formulas, and reading its output."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from eai.logic.formula import (
    And,
    Atom,
    Formula,
    Or,
    Then,
)
from eai.logic.ltl import parse, read_formula
from eai.logic.ltl_printer import format_ltl
from eai.logic.signature import FormulaSignature
from logic.random_formulas import ACTIONS, PREDICATES, formulas
from sweeps import examples

SIGNATURE = FormulaSignature(PREDICATES, ACTIONS)


@given(formulas())
@settings(max_examples=examples(120))
def test_reading_a_printed_formula_gives_the_formula(formula: Formula) -> None:
    assert read_formula(format_ltl(formula), SIGNATURE) == (formula, ())


@pytest.mark.parametrize(
    "text",
    [
        "p(a) then q(a) or r(a) and not s(a)",
        "(p(a) then q(a)) then r(a)",
        "(p(a) and q(a)) and r(a)",
        "(p(a) or q(a)) and r(a)",
        "not (p(a) and q(a))",
        "p(a) implies q(a) implies r(a)",
        "(p(a) implies q(a)) implies r(a)",
        "p(a) until q(a) until not r(a)",
        "next (p(a) until q(a))",
        "forn 2. x: cup. (p(x) or exists y. (x = y))",
        "fornpairs 2. x: cup, y. (in(x, y))",
        "true and false",
    ],
)
def test_only_needed_brackets_are_printed(text: str) -> None:
    assert format_ltl(parse(text)) == text


def test_a_connective_with_one_part_is_printed_as_the_part() -> None:
    p, q = Atom("p"), Atom("q")
    assert format_ltl(And((Or((p,)), Then((Or((p, q)),))))) == "p() and (p() or q())"
    assert format_ltl(Then(())) == "true"
