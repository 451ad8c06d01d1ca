from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.pddl.offence import Offence, PddlError
from eai.pddl.sexpr import MAX_DEPTH, Group, SExpr, Symbol, read_group

WORDS = st.text("abcdefgh_-:", min_size=1, max_size=6)
TREES = st.recursive(WORDS, lambda parts: st.lists(parts, max_size=4).map(lambda p: f"({' '.join(p)})"))


def show(expression: SExpr) -> str:
    if isinstance(expression, Symbol):
        return expression.text
    return f"({' '.join(show(item) for item in expression.items)})"


@given(st.lists(TREES, max_size=4))
def test_what_is_shown_is_read_back(texts: list[str]) -> None:
    assert [show(expression) for expression in read_group(f"({' '.join(texts)})").items] == texts


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("(AND (On ?X))", "(and (on ?x))"),
        ("(on?char ?obj)", "(on ?char ?obj)"),
        ("; (a\n(b) ; ((\n", "(b)"),
        ("()", "()"),
        ("(\ta\r\n b )", "(a b)"),
    ],
)
def test_tolerates(text: str, shown: str) -> None:
    assert show(read_group(text)) == shown


def test_several_groups_in_a_row_keep_their_places() -> None:
    first, second = read_group("((a) (b\n c))").items
    assert isinstance(first, Group)
    assert isinstance(second, Group)
    assert (first.offset, first.end, second.offset, second.end) == (1, 4, 5, 11)
    word = second.items[1]
    assert isinstance(word, Symbol)
    assert (word.text, word.offset) == ("c", 9)


def test_reading_one_group_leaves_the_rest() -> None:
    text = "prose (a) (b"
    assert show(read_group(text, text.index("("))) == "(a)"


@pytest.mark.parametrize(
    ("text", "offence", "line", "column"),
    [
        ("(a\n (b)", Offence.UNBALANCED, 1, 1),
        ("\n  )", Offence.UNBALANCED, 2, 3),
        ("(" * (MAX_DEPTH + 1), Offence.MALFORMED, 1, MAX_DEPTH + 1),
    ],
)
def test_names_the_offence_and_its_place(text: str, offence: Offence, line: int, column: int) -> None:
    with pytest.raises(PddlError) as raised:
        read_group(text)
    assert (raised.value.offence, raised.value.line, raised.value.column) == (offence, line, column)


@pytest.mark.parametrize("text", ["", "  ; nothing", "word (a)"])
def test_a_group_is_asked_for(text: str) -> None:
    with pytest.raises(PddlError, match="a parenthesised list"):
        read_group(text)


def test_the_deepest_nesting_that_is_read_can_be_shown() -> None:
    text = "(" * MAX_DEPTH + ")" * MAX_DEPTH
    assert show(read_group(text)) == text
