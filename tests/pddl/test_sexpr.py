from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.pddl.offence import Offence, PddlError
from eai.pddl.sexpr import MAX_DEPTH, Group, SExpr, Symbol, read_all, read_group, show

WORDS = st.text("abcdefgh_-:", min_size=1, max_size=6)
TREES = st.recursive(WORDS, lambda parts: st.lists(parts, max_size=4).map(lambda p: f"({' '.join(p)})"))


@given(st.lists(TREES, max_size=4))
def test_what_is_shown_is_read_back(texts: list[str]) -> None:
    assert [show(expression) for expression in read_all(" ".join(texts))] == texts


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
    assert [show(expression) for expression in read_all(text)] == [shown]


def test_several_groups_in_a_row_keep_their_places() -> None:
    first, second = read_all("(a) word".replace("word", "(b\n c)"))
    assert isinstance(first, Group)
    assert isinstance(second, Group)
    assert (first.offset, first.end, second.offset, second.end) == (0, 3, 4, 10)
    word = second.items[1]
    assert isinstance(word, Symbol)
    assert (word.text, word.offset) == ("c", 8)


def test_reading_one_group_leaves_the_rest() -> None:
    text = "prose (a) (b"
    assert show(read_group(text, text.index("("))) == "(a)"


@pytest.mark.parametrize(
    ("text", "offence", "line", "column"),
    [
        ("(a\n (b)", Offence.UNBALANCED, 1, 1),
        ("(a)\n  )", Offence.UNBALANCED, 2, 3),
        ("(" * (MAX_DEPTH + 1), Offence.MALFORMED, 1, MAX_DEPTH + 1),
    ],
)
def test_names_the_offence_and_its_place(text: str, offence: Offence, line: int, column: int) -> None:
    with pytest.raises(PddlError) as raised:
        read_all(text)
    assert (raised.value.offence, raised.value.line, raised.value.column) == (offence, line, column)


@pytest.mark.parametrize("text", ["", "  ; nothing", "word (a)"])
def test_a_group_is_asked_for(text: str) -> None:
    with pytest.raises(PddlError, match="a parenthesised list"):
        read_group(text)


def test_the_deepest_nesting_that_is_read_can_be_shown() -> None:
    text = "(" * MAX_DEPTH + ")" * MAX_DEPTH
    found: tuple[SExpr, ...] = read_all(text)
    assert show(found[0]) == text
