from __future__ import annotations

import io

import pytest
from rich.console import Console

from eai.abilities.declaration import the_four
from eai.cli.table import Result, heading, print_rates
from eai.results.coverage import Coverage
from eai.results.rate import Rate

METRICS = [metric for declared in the_four().values() for metric in declared.terminal]
LONG = ("claude-3-5-sonnet-20240620", "a-provider_with-a-long-name/meta-llama-3.1-405b-instruct-turbo")


def printed(width: int, *, models: tuple[str, ...] = LONG, wide: bool = False) -> str:
    rates = {metric: Rate(10_000 + place, 10_000) for place, metric in enumerate(METRICS)}
    results = {model: Result(rates, Coverage(342, 342, tasks=342)) for model in models}
    file = io.StringIO()
    print_rates(Console(file=file, width=width), "title", METRICS, results, wide=wide)
    return file.getvalue()


@pytest.mark.parametrize("width", [60, 80, 150])
def test_no_number_is_cut_and_no_line_too_long(width: int) -> None:
    lines = printed(width).splitlines()
    assert max(map(len, lines)) <= width
    assert "…" not in "".join(lines)
    assert sum(line.count("100.") for line in lines) == 2 * len(METRICS)


def test_a_wide_table_is_one() -> None:
    text = printed(80, wide=True)
    assert text.count("answered") == 1
    assert text.count("100.") == 2 * len(METRICS)
    assert LONG[1] in text


def test_one_model_has_a_row_a_metric_with_what_it_is_made_of() -> None:
    lines = printed(60, models=("m",)).splitlines()
    assert lines[0] == "title: m, 342/342 answered"
    assert any(line.split() == ["state,", "precision", "100.0", "10000", "/", "10000"] for line in lines)


def test_a_column_without_any_number_is_left_out() -> None:
    file = io.StringIO()
    rates = {"task_success": Rate(1, 2), "parsing": Rate(0, 0)}
    results = {model: Result(rates, Coverage(2, 2, tasks=2)) for model in ("a", "b")}
    print_rates(Console(file=file, width=80), "title", list(rates), results)
    assert "parsing" not in file.getvalue()


def test_headings_are_short() -> None:
    assert heading("task_success") == "task\nsuccess"
    assert heading("non_spatial_relations.planner_success") == "non\nspatial\nrelations\nplanner"
    assert heading("overall.f1") == "overall\nF1"
