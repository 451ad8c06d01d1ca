"""Deep and long texts: a formula or an error, never a crash."""

from __future__ import annotations

import pickle

import pytest

from eai.base.errors import InputError, ParseError
from eai.logic.choice import count_dnf_terms, generate_dnf_terms
from eai.logic.formula import (
    Formula,
)
from eai.logic.ltl import Dialect, parse
from eai.logic.ltl_printer import format_ltl
from eai.logic.semantics import explain_truth
from eai.logic.trace import Trace
from eai.logic.traversal import MAX_FORMULA_DEPTH
from logic.activities import universe
from logic.bddl_text import read_condition


def read(text: str, dialect: Dialect = "ltlf") -> Formula:
    return parse(text, dialect=dialect)


DEEP = {
    "negations": "not " * MAX_FORMULA_DEPTH,
    "quantifiers": "exists x. (" * MAX_FORMULA_DEPTH,
    "thousand negations": "not " * 1000,
    "thousand quantifiers": "forall x. (" * 1000,
    "a hundred kilobytes of negations": "not " * 25_000,
}


@pytest.mark.parametrize("prefix", DEEP.values(), ids=DEEP.keys())
def test_too_deep_nesting_is_an_error(prefix: str) -> None:
    with pytest.raises(ParseError, match="at most 100 levels of nesting"):
        parse(prefix + "p(x)" + ")" * prefix.count("("))


@pytest.mark.parametrize(
    ("before", "after", "levels"),
    [
        ("not ", "", 1),
        ("next ", "", 1),
        ("exists x. (p(x) and ", ")", 2),
        ("(p(x) then ", ")", 1),
        ("(p(x) until ", ")", 1),
    ],
)
def test_the_deepest_formulas_can_be_compared_hashed_shown_and_stored(
    before: str, after: str, levels: int
) -> None:
    times = (MAX_FORMULA_DEPTH - 1) // levels
    text = before * times + "p(x)" + after * times
    formula = read(text)
    assert formula == read(text)
    assert hash(formula) == hash(read(text))
    assert repr(formula).count("Atom") >= 1
    assert read(format_ltl(formula)) == formula
    assert pickle.loads(pickle.dumps(formula)) == formula  # noqa: S301


LONG = {
    "conjuncts": " and ".join(["p(x)"] * 12_000),
    "steps": " then ".join(["p(x)"] * 10_000),
    "arguments": f"p({', '.join(['x'] * 33_000)})",
    "brackets": "(" * 50_000 + "p(x)" + ")" * 50_000,
    "one name": "p" * 100_000 + "(x)",
}


@pytest.mark.parametrize("text", LONG.values(), ids=LONG.keys())
def test_long_texts_are_formulas(text: str) -> None:
    assert len(text) > 80_000
    assert read(text) == read(text)


BROKEN = {
    "open brackets": "(" * 100_000,
    "endless arguments": "p(" + "x," * 50_000,
    "names": "p " * 50_000,
    "blank lines": "\n" * 100_000,
}


@pytest.mark.parametrize("text", BROKEN.values(), ids=BROKEN.keys())
def test_long_broken_texts_are_parse_errors(text: str) -> None:
    with pytest.raises(ParseError):
        parse(text)


@pytest.mark.parametrize("text", ["true", "(and)"])
def test_too_deep_constants_are_an_error(text: str) -> None:
    with pytest.raises(ParseError, match="at most 100 levels of nesting"):
        parse("not " * MAX_FORMULA_DEPTH + text) if text == "true" else read_condition(
            "(not " * MAX_FORMULA_DEPTH + text + ")" * MAX_FORMULA_DEPTH
        )


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("not ", ""),
        ("next ", ""),
        ("(p(x) or ", ")"),
        ("exists x: a. (", ")"),
        ("forn 1 x: a. (", ")"),
        ("forpairs x: a, y: b. (", ")"),
        ("(p(x) then ", ")"),
        ("not always ", ""),
    ],
)
def test_the_deepest_formulas_can_be_evaluated_and_expanded(before: str, after: str) -> None:
    times = (MAX_FORMULA_DEPTH - 1) // (2 if before == "not always " else 1)
    formula = read(before * times + "p(x)" + after * times)
    state = universe(a=1, b=1)
    assert explain_truth(formula, Trace([state] * 3)).holds in (True, False)
    try:
        count = count_dnf_terms(formula, state.list_objects)
    except InputError:
        return
    assert count == len(list(generate_dnf_terms(formula, state.list_objects)))
