"""Signatures: checks of the names in a formula."""

from __future__ import annotations

import pytest

from eai.logic.formula import (
    And,
    Atom,
    Constant,
    Occurs,
)
from eai.logic.ltl import MAX_CACHED_ATOMS_AND_ACTIONS, read_formula
from eai.logic.signature import FormulaSignature, find_line_and_column, join_with_or

P = Atom("p", (Constant("a"),))


def test_misuses_have_a_kind_and_a_position() -> None:
    signature = FormulaSignature({"open": 1, "in": 2, "any": None}, {"grab": 1}, {"cup.1"})
    text = "open(cup.1) and\n opn(cup.1) or in( cup.1 ) then grab(cup.2) and exists x. (any(x, x, y))"
    found = [(o.kind, o.name, o.primitive, o.line, o.column) for o in read_formula(text, signature)[1]]
    assert found == [
        ("unknown_predicate", "opn", "opn", 2, 2),
        ("wrong_arity", "in", "in", 2, 16),
        ("unknown_object", "cup.2", "grab", 2, 38),
        ("unknown_object", "y", "any", 2, 70),
    ]
    assert str(read_formula(text, signature)[1][1]) == "line 2, column 16: in takes 2 arguments, not 1"


def test_a_variable_is_not_an_object_outside_its_quantifier() -> None:
    signature = FormulaSignature({"open": 1}, objects=())
    assert read_formula("forall x. (open(x))", signature)[1] == ()
    (misuse,) = read_formula("forall x. (open(x)) and open(x)", signature)[1]
    assert (misuse.kind, misuse.column) == ("unknown_object", 30)


def test_actions_come_from_the_signature() -> None:
    grab = Occurs("grab", (Constant("a"),))
    assert read_formula("grab(a) and p(a)", FormulaSignature({"p": 1}, {"grab": 1}))[0] == And((grab, P))
    assert read_formula("p(a)", FormulaSignature({"p": 1}, {"p": 2}))[0] == P


def test_cached_primitives_are_valid_at_every_position() -> None:
    signature = FormulaSignature({"open": 1}, {"grab": 1}, {"cup.1"})
    text = "grab(cup.1) then open(cup.1) then open(cup.2) and exists x. (open(x)) and grab(cup.1)"
    first = read_formula(text, signature)
    assert set(signature.parsed) == {"grab(cup.1)", "open(cup.1)"}
    assert read_formula(text, signature) == first
    (misuse,) = read_formula("grab(cup.1) and open(x)", signature)[1]
    assert (misuse.kind, misuse.column) == ("unknown_object", 22)


def test_the_cache_of_primitives_is_bounded() -> None:
    signature = FormulaSignature({"open": 1})
    read_formula(
        " and ".join(f"open(cup.{number})" for number in range(2 * MAX_CACHED_ATOMS_AND_ACTIONS)), signature
    )
    assert len(signature.parsed) == MAX_CACHED_ATOMS_AND_ACTIONS


@pytest.mark.parametrize(
    ("position", "expected"), [(0, (1, 1)), (2, (1, 3)), (3, (2, 1)), (4, (3, 1)), (6, (3, 3))]
)
def test_lines_and_columns_count_from_one(position: int, expected: tuple[int, int]) -> None:
    assert find_line_and_column("ab\n\ncd", position) == expected


def test_a_text_may_begin_with_an_empty_line() -> None:
    assert find_line_and_column("\nab", 2) == (2, 2)


def test_only_newlines_end_lines() -> None:
    assert find_line_and_column("a\fb\x85c\rd", 6) == (1, 7)


@pytest.mark.parametrize(
    ("words", "joined"), [(["a"], "a"), (["a", "c"], "a or c"), (["a", "b", "c"], "a, b or c")]
)
def test_words_are_joined_by_commas_and_or(words: list[str], joined: str) -> None:
    assert join_with_or(words) == joined
