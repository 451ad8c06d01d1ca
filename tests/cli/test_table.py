from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import replace

import pytest
from rich.console import Console

from eai.abilities.declaration import load_declarations_of_paper_abilities
from eai.cli.table import format_heading, make_rates_table
from eai.results.terminal import print_table
from eai.results.totals import RunTotals
from results.verdicts import SUCCEEDED, record

METRICS = list(
    dict.fromkeys(
        metric
        for declared in load_declarations_of_paper_abilities().values()
        for metric in declared.terminal_metrics
    )
)
LONG = ("claude-3-5-sonnet-20240620", "a-provider_with-a-long-name/meta-llama-3.1-405b-instruct-turbo")


def of_tasks(number: int, sums: Mapping[str, tuple[int, int]]) -> RunTotals:
    totals = RunTotals.from_records(
        replace(record(str(i), SUCCEEDED), suite_size=number) for i in range(number)
    )
    return replace(totals, sums_by_metric={**sums})


def printed(width: int, *, models: tuple[str, ...] = LONG, wide: bool = False) -> str:
    sums = {metric: (10_000 + place, 10_000) for place, metric in enumerate(METRICS)}
    results = dict.fromkeys(models, of_tasks(342, sums))
    file = io.StringIO()
    print_table(Console(file=file, width=width), make_rates_table("title", METRICS, results), wide=wide)
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
    assert [line.split()[-4:] for line in lines].count(["100.0", "10000", "/", "10000"]) == 1


def test_a_column_without_any_number_is_left_out() -> None:
    file = io.StringIO()
    sums = {"task_success": (1, 2), "parsing": (0, 0)}
    results = dict.fromkeys(("a", "b"), of_tasks(2, sums))
    print_table(Console(file=file, width=80), make_rates_table("title", list(sums), results))
    assert "parsing" not in file.getvalue()


def test_headings_are_short() -> None:
    assert format_heading("task_success") == "task\nsuccess"
    assert format_heading("non_spatial_relations.planner_success") == "non\nspatial\nrelations\nplanner"
    assert format_heading("overall.f1") == "overall\nF1"
