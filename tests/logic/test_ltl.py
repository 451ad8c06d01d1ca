"""The LTL syntax: accepted texts, their formulas, and parse errors."""

from __future__ import annotations

from itertools import combinations
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.base.errors import ParseError
from eai.logic.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Atom,
    Constant,
    Equals,
    Eventually,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Next,
    Not,
    Or,
    Then,
    Until,
    Variable,
)
from eai.logic.ltl import Dialect, parse, read_formula
from eai.logic.ltl_printer import format_ltl
from eai.logic.signature import FormulaSignature
from logic.random_formulas import ACTIONS, PREDICATES, formulas
from sweeps import examples

SIGNATURE = FormulaSignature(PREDICATES, ACTIONS)
P, Q, R, S = (Atom(name, (Constant("a"),)) for name in "pqrs")


def read(text: str, dialect: Dialect = "ltlf") -> Formula:
    return parse(text, dialect=dialect)


def failure_of(text: str, dialect: Dialect) -> ParseError | None:
    try:
        read_formula(text, SIGNATURE, dialect)
    except ParseError as error:
        return error
    return None


@given(formulas(beyond_paper=False))
@settings(max_examples=examples(120))
def test_the_dialects_agree_on_the_papers_formulas(formula: Formula) -> None:
    text = format_ltl(formula).replace("notable", "able")
    assert read(text, "release") == read(text, "ltlf")


@given(st.text(alphabet=" ()pxy.,32nothefrlaid\n-_é=:", max_size=40), st.sampled_from(get_args(Dialect)))
@settings(max_examples=examples(120))
def test_any_text_is_a_formula_or_a_parse_error_inside_the_text(text: str, dialect: Dialect) -> None:
    failure = failure_of(text, dialect)
    if failure is not None:
        lines = text.split("\n")
        assert 1 <= failure.line <= len(lines)
        assert 1 <= failure.column <= len(lines[failure.line - 1]) + 1
        assert failure.expected


@pytest.mark.parametrize("dialect", get_args(Dialect))
def test_words_bind_in_the_documented_order(dialect: Dialect) -> None:
    text = "p(a) then q(a) or r(a) and not s(a) then p(a)"
    assert read(text, dialect) == Then((P, Or((Q, And((R, Not(S))))), P))
    assert read("(p(a) then q(a)) or r(a)", dialect) == Or((Then((P, Q)), R))


INFIXES = ("then", "implies", "or", "and", "until")
"""Infix words from loosest to tightest."""


@pytest.mark.parametrize(("loose", "tight"), list(combinations(INFIXES, 2)))
def test_an_operand_between_two_words_belongs_to_the_tighter_one(loose: str, tight: str) -> None:
    assert read(f"p(a) {loose} q(a) {tight} r(a)") == read(f"p(a) {loose} (q(a) {tight} r(a))")
    assert read(f"p(a) {tight} q(a) {loose} r(a)") == read(f"(p(a) {tight} q(a)) {loose} r(a)")


def test_words_beyond_the_paper_bind_in_the_documented_order() -> None:
    assert read("p(a) then q(a) implies r(a) or s(a)") == Then((P, Implies(Q, Or((R, S)))))
    assert read("p(a) and q(a) until next r(a)") == And((P, Until(Q, Next(R))))
    assert read("p(a) implies q(a) implies r(a)") == Implies(P, Implies(Q, R))
    assert read("eventually p(a) or true and false") == Or((Eventually(P), And((TRUE, FALSE))))


@pytest.mark.parametrize("text", ["forn 2. v. (open(v))", "forn 2 v. (open(v))"])
def test_both_spellings_of_forn_are_read(text: str) -> None:
    assert read(text) == Exactly(2, Variable("v"), Atom("open", (Variable("v"),)))


@pytest.mark.parametrize("dialect", get_args(Dialect))
def test_a_count_has_up_to_nine_digits(dialect: Dialect) -> None:
    most = Exactly(999_999_999, Variable("v"), Atom("open", (Variable("v"),)))
    assert read("forn 999999999. v. (open(v))", dialect) == most


def test_the_release_dialect_reads_one_spelling_of_forn() -> None:
    assert read("forn 2. v. (open(v))", "release") == read("forn 2 v. (open(v))")
    with pytest.raises(ParseError, match=r"column 8: expected '\.'"):
        parse("forn 2 v. (open(v))", dialect="release")


def test_pairings_and_categories_are_read() -> None:
    body = Atom("in", (Variable("x"), Variable("y")))
    first, second = Variable("x", "candle.n.01"), Variable("y")
    assert read("forpairs x: candle.n.01, y. (in(x, y))") == ForPairs(first, second, body)
    assert read("fornpairs 2. x: candle.n.01, y. (in(x, y))") == ForPairs(first, second, body, 2)


@pytest.mark.parametrize("dialect", get_args(Dialect))
def test_object_names_may_have_an_id(dialect: Dialect) -> None:
    names = ("sofa.352", "sofa", "-x")
    assert read("in(sofa.352, sofa, -x)", dialect) == Atom("in", tuple(map(Constant, names)))
    assert read("sleep( )", dialect) == Atom("sleep")


@pytest.mark.parametrize(
    ("text", "release", "here"),
    [
        ("notp(a)", Not(P), Atom("notp", (Constant("a"),))),
        ("not(a)", Atom("not", (Constant("a"),)), Atom("not", (Constant("a"),))),
        ("not(p(a))", Not(P), Not(P)),
        ("not2(a)", Atom("not2", (Constant("a"),)), Atom("not2", (Constant("a"),))),
        ("forallx(a)", Atom("forallx", (Constant("a"),)), Atom("forallx", (Constant("a"),))),
        ("p(a)thenq(a)", Then((P, Q)), Then((P, Q))),
        ("next(a)", Atom("next", (Constant("a"),)), Atom("next", (Constant("a"),))),
    ],
)
def test_words_are_not_reserved(text: str, release: Formula, here: Formula) -> None:
    assert read(text, "release") == release
    assert read(text, "ltlf") == here


@pytest.mark.parametrize("text", ["next p(a)", "p(a) until q(a)", "p(a) implies q(a)", "a = a", "true"])
def test_the_release_dialect_rejects_formulas_beyond_the_paper(text: str) -> None:
    with pytest.raises(ParseError):
        parse(text, dialect="release")


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("not (true)", Not(TRUE)),
        ("not(false)", Not(FALSE)),
        ("always ( false )", Always(FALSE)),
        ("next (true)", Next(TRUE)),
        ("eventually(true) and p(a)", And((Eventually(TRUE), P))),
        ("not (not (true))", Not(Not(TRUE))),
        ("not ((true))", Not(TRUE)),
        ("forall x. (always (true))", ForAll(Variable("x"), Always(TRUE))),
        ("not(true, a)", Atom("not", (Constant("true"), Constant("a")))),
        ("not(true_north)", Atom("not", (Constant("true_north"),))),
        ("forall(true)", Atom("forall", (Constant("true"),))),
    ],
)
def test_a_constant_may_stand_in_brackets_after_a_prefix(text: str, formula: Formula) -> None:
    assert read(text, "ltlf") == formula
    assert parse(format_ltl(formula)) == formula


def test_the_release_dialect_has_no_constants() -> None:
    assert read("not (true)", "release") == Atom("not", (Constant("true"),))


def test_a_name_bound_by_a_quantifier_is_a_variable() -> None:
    x = Variable("x")
    formula = read("forall x. (p(x) and exists x. (q(x, y))) and p(x)")
    inner = And((Atom("p", (x,)), Exists(x, Atom("q", (x, Constant("y"))))))
    assert formula == And((ForAll(x, inner), Atom("p", (Constant("x"),))))
    assert read("exists x. (x = y)") == Exists(x, Equals(x, Constant("y")))


@pytest.mark.parametrize(
    ("text", "misuses"),
    [
        ("cup = cup", []),
        ("cup = pot", [("unknown_object", "pot", "=", 7)]),
        ("pot = pan", [("unknown_object", "pot", "=", 1), ("unknown_object", "pan", "=", 7)]),
        ("forall x. (x = cup or x = pot)", [("unknown_object", "pot", "=", 27)]),
    ],
)
def test_an_equation_of_an_unknown_object_is_a_misuse(
    text: str, misuses: list[tuple[str, str, str, int]]
) -> None:
    signature = FormulaSignature({}, {}, frozenset({"cup"}))
    _, reported = read_formula(text, signature, dialect="ltlf")
    assert [(misuse.kind, misuse.name, misuse.primitive, misuse.column) for misuse in reported] == misuses


def test_names_are_checked_after_the_whole_text_is_parsed() -> None:
    with pytest.raises(ParseError):
        read_formula("nonsense(a) and (", SIGNATURE)


@pytest.mark.parametrize(
    ("text", "line", "column", "expected"),
    [
        ("", 1, 1, "a predicate or action, a name, 'not', a quantifier or '('"),
        ("open(x y)", 1, 8, "')' or ','"),
        ("open(x) open(y)", 1, 9, "'and', 'or', 'then' or the end"),
        ("forall x (open(x))", 1, 10, "'.'"),
        ("open(x) and\n\topen(x", 2, 8, "')' or ','"),
        ("(open(x)", 1, 9, "')'"),
        ("éclair(x)", 1, 1, "a predicate or action, a name, 'not', a quantifier or '('"),
        ("forn 1234567890. x. (open(x))", 1, 6, "a number of at most 9 digits"),
    ],
)
def test_a_parse_error_has_a_position_and_the_expected_text(
    text: str, line: int, column: int, expected: str
) -> None:
    with pytest.raises(ParseError) as caught:
        parse(text, dialect="release")
    assert (caught.value.line, caught.value.column, caught.value.expected) == (line, column, expected)


ANOTHER = "'and', 'or', 'then', 'until', 'implies'"


@pytest.mark.parametrize(
    ("text", "column", "expected"),
    [
        ("open", 5, "'(' or '='"),
        ("open(x) !", 9, f"{ANOTHER} or the end"),
        ("(open(x) !", 10, "')', 'and', 'or', 'then', 'until' or 'implies'"),
        ("open(x))", 8, "the end"),
        ("open(x) and", 12, "a predicate or action, a name, 'not', a quantifier or '('"),
        ("open(,", 6, "a name or ')'"),
        ("in(x,)", 6, "a name"),
        ("a.1", 4, "'='"),
        ("a = ", 5, "a name"),
        ("forn x. (open(x))", 6, "a number"),
        ("forn 2 (open(x))", 8, "a name or '.'"),
        ("forn 2. (open(x))", 9, "a name"),
        ("forall x; (open(x))", 9, "'.' or ':'"),
        ("forall x: . (open(x))", 11, "a category"),
        ("forall x: cup (open(x))", 15, "'.'"),
        ("forall x. open(x)", 11, "'('"),
        ("forpairs x. (open(x))", 11, "',' or ':'"),
        ("forpairs x, . (open(x))", 13, "a name"),
        ("fornpairs 2 x: cup. (open(x))", 19, "','"),
    ],
)
def test_a_parse_error_beyond_the_paper_has_a_position_and_the_expected_text(
    text: str, column: int, expected: str
) -> None:
    with pytest.raises(ParseError) as caught:
        parse(text)
    assert (caught.value.line, caught.value.column, caught.value.expected) == (1, column, expected)


def test_non_ascii_letters_may_follow_the_first() -> None:
    assert read("is_süß(kuchen)") == Atom("is_süß", (Constant("kuchen"),))


def test_only_the_release_dialect_needs_an_ascii_letter_first() -> None:
    text = "forall ы: ящик. (над(ы, ёж.2) or ы = стол)"
    here = ForAll(
        Variable("ы", "ящик"),
        Or((Atom("над", (Variable("ы"), Constant("ёж.2"))), Equals(Variable("ы"), Constant("стол")))),
    )
    assert read(text) == here
    for text in ("над(x)", "on(ёж)", "forall ы. (on(ы))"):
        assert failure_of(text, "ltlf") is None
        assert failure_of(text, "release") is not None
