from __future__ import annotations

import io

import pytest
from rich.console import Console

from eai.results.table import NO_NUMBER, Column, Estimate, Table, TextCell
from eai.results.terminal import print_table

TABLE = Table(
    "t",
    "Title",
    "",
    (
        Column("rank", "#", is_number=True),
        "model",
        *[Column(f"n{i}", f"group\nlabel {i}", digits=1, is_number=True) for i in range(9)],
        "words",
    ),
    (
        (1, TextCell("m", notes=(1, 2)), *[Estimate(50.0, 40.0, 60.0, best=True)] * 9, "one two three " * 9),
        (None, TextCell("other", origin="paper"), *[NO_NUMBER] * 9, "short"),
    ),
)


def printed(width: int, *, wide: bool = False) -> list[str]:
    file = io.StringIO()
    print_table(Console(file=file, width=width), TABLE, wide=wide)
    return file.getvalue().splitlines()


@pytest.mark.parametrize("width", [60, 80, 200])
def test_numbers_are_never_cut_and_each_part_repeats_the_names(width: int) -> None:
    lines = printed(width)
    assert lines[0] == "Title"
    assert max(map(len, lines)) <= width
    text = "\n".join(lines)
    assert text.count("50.0") == text.count("±10.0") == 9
    assert text.count("m¹˒²") == text.count("other (paper)") == text.count("#")


def test_texts_are_folded_into_the_space_of_the_last_part() -> None:
    lines = printed(80)
    assert sum("one two three" in line for line in lines) > 1
    assert " ".join(lines).count("words") == 1


def test_a_table_without_rows_says_so() -> None:
    file = io.StringIO()
    print_table(Console(file=file, width=80), Table("t", "Title", "", ("arm", "attempts"), ()))
    assert file.getvalue().splitlines()[:2] == ["Title", "no rows"]


@pytest.mark.parametrize("row", [("word",), (1, "word"), (1, 2), (1,), ("word", 1), ("word", "text")])
def test_every_column_is_printed(row: tuple[str | int, ...]) -> None:
    file = io.StringIO()
    names = tuple([f"column{index}" for index in range(len(row))])
    print_table(Console(file=file, width=80), Table("t", "Title", "", names, (row,)))
    assert file.getvalue().split() == ["Title", *names, file.getvalue().split()[1 + len(row)], *map(str, row)]


def test_a_wide_table_is_in_one_part() -> None:
    assert "\n".join(printed(60, wide=True)).count("#") == 1


def test_a_missing_number_is_a_dash_and_an_empty_cell_is_empty() -> None:
    (row,) = (line.split() for line in printed(200) if "other" in line)
    assert row == ["other", "(paper)", *["-"] * 9, "short"]
