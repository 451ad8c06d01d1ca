"""Write a report into a folder: tables for readers and for programs.

For programs there is one JSON file, and one CSV file with a line for each number.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from eai.abilities.declaration import MetricColumn
from eai.base.errors import InputError, did_you_mean
from eai.base.files import write_files_atomically
from eai.base.json_value import Json
from eai.results import latex
from eai.results.cost import PriceList
from eai.results.table import Plain
from eai.results.table_files import format_csv
from eai.studies.report.cost import format_cost_csv, write_cost_section
from eai.studies.report.document import make_report_markdown
from eai.studies.report.rankings import (
    RankedModel,
    RankedScore,
    Ranking,
    compute_ranks,
    make_experiment_rankings,
    make_rankings_of_secondary_paper_tables,
    mark_best,
)
from eai.studies.report.run_summary import RunSummary, select_runs_with_standard_rules_and_no_study


def write_report_and_count_tables(
    folder: Path,
    runs: Sequence[RunSummary],
    tables: Sequence[Ranking],
    format_latex: Callable[[Sequence[Ranking]], str],
    *,
    with_paper: bool,
    prices: PriceList | None = None,
) -> int:
    """Write ``report.md``, ``report.tex`` with ``tables.tex``, ``tables.json`` and ``tables.csv``.

    Experiments (runs with study options) have separate tables. If the paper's models are included, further
    tables of the paper are added. If records have token counts, ``cost.csv`` is written too.

    Args:
        folder: folder of the files.
        runs: all runs, including experiments.
        tables: the tables of the plain runs.
        format_latex: function that returns all tables as LaTeX (`format_tables_latex`).
        with_paper: whether the paper's models appear beside ours.
        prices: prices of tokens, for answers without a recorded cost.

    Returns:
        the number of tables written.
    """
    plain = select_runs_with_standard_rules_and_no_study(runs)
    tried = make_experiment_rankings(runs)
    others = make_rankings_of_secondary_paper_tables(plain) if with_paper else []
    written = [*tables, *tried, *others]
    cost = "\n".join(write_cost_section(runs, prices, with_paper_cost=with_paper))
    contents = {
        "report.md": make_report_markdown(runs, tables, tried, others, cost, with_paper=with_paper),
        "tables.tex": format_latex(written),
        "report.tex": (resources.files("eai.studies.report") / "report.tex").read_text(encoding="utf-8"),
        "tables.json": format_rankings_json(written),
        "tables.csv": format_rankings_csv(written),
    }
    if (paid := format_cost_csv(runs, prices)) is not None:
        contents["cost.csv"] = paid
    write_files_atomically({folder / name: text for name, text in contents.items()})
    return len(written)


def format_tables_latex(
    tables: Sequence[Ranking], models: Collection[str], columns: Collection[str], *, intervals: bool
) -> str:
    """Return the selected columns and models of tables as LaTeX; empty tables are left out.

    Long tables are broken at the ends of pages.

    Args:
        tables: the tables.
        models: names of the printed models; all models if empty.
        columns: headings of columns or of groups of columns, upper or lower case; all columns if empty.
        intervals: whether intervals are printed below the numbers.

    Raises:
        InputError: no table has a model or column with the name.
    """
    wanted = [name.casefold() for name in columns]
    _check_names("--models", models, {row.model for table in tables for row in table.rows})
    headings = {
        heading
        for table in tables
        for column in table.columns
        for heading in _get_casefolded_group_and_label(column)
    }
    _check_names("--columns", wanted, headings)
    narrowed = (_select_models_and_columns(table, models, wanted) for table in tables)
    return "\n".join(
        _format_ranking_latex(table, intervals=intervals) for table in narrowed if table is not None
    )


def _select_models_and_columns(
    table: Ranking, models: Collection[str], headings: Collection[str]
) -> Ranking | None:
    wanted = set(headings)
    columns = {
        column: notes
        for column, notes in table.columns.items()
        if not wanted or wanted & _get_casefolded_group_and_label(column)
    }
    rows = [
        replace(row, scores={column: row.scores[column] for column in columns})
        for row in table.rows
        if not models or row.model in models
    ]
    if not columns or not rows:
        return None
    used = {note for notes in (*columns.values(), *(row.all_notes for row in rows)) for note in notes}
    ranks = compute_ranks([None if row.rank is None else -row.rank for row in rows])
    rows = [replace(row, rank=rank) for row, rank in zip(rows, ranks, strict=True)]
    notes = tuple(note for note in table.notes if note in used)
    return replace(table, columns=columns, rows=tuple(mark_best(rows)), notes=notes)


def _get_casefolded_group_and_label(column: MetricColumn) -> set[str]:
    return {column.group.casefold(), column.label.casefold()}


def _check_names(option: str, names: Collection[str], choices: Collection[str]) -> None:
    for name in names:
        if name not in choices:
            raise InputError(f"{option}: no table has {name!r}{did_you_mean(name, sorted(choices))}")


def _format_ranking_latex(table: Ranking, *, intervals: bool) -> str:
    label = ":".join((table.name, _to_latex_label(table.domain), _to_latex_label(table.protocol.value)))
    return latex.format_latex_table(table.make_table(), label=label, intervals=intervals)


def _to_latex_label(text: str) -> str:
    return "".join(c if c.isascii() and c.isalnum() else "-" for c in text)


def format_rankings_json(tables: Sequence[Ranking]) -> str:
    """Return all tables as JSON. Each number has its numerator and denominator; percentages are unrounded."""
    content: list[Json] = [
        {
            "name": table.name,
            "title": table.title,
            "protocol": table.protocol.value,
            "domain": table.domain,
            "unit": "percent",
            "rows": [_row_to_json(table, row) for row in table.rows],
            "notes": list(table.notes),
        }
        for table in tables
    ]
    return json.dumps({"tables": content}, indent=1, ensure_ascii=False) + "\n"


_COLUMNS = (
    *("table", "protocol", "domain", "model", "source", "rank", "ability", "metric"),
    *("percent", "numerator", "denominator", "low", "high", "low_by_task", "high_by_task"),
    *("design_effect", "effective_tasks", "answered", "tasks"),
)


def format_rankings_csv(tables: Sequence[Ranking]) -> str:
    """Return the numbers of all tables as CSV, one number per line, with a header line.

    Tables without numbers give only the header line.
    """
    lines = (
        _make_csv_line(table, row, column, score)
        for table in tables
        for row in table.rows
        for column, score in row.scores.items()
        if score.value is not None
    )
    return format_csv(_COLUMNS, ([line[name] for name in _COLUMNS] for line in lines))


def _make_csv_line(
    table: Ranking, row: RankedModel, column: MetricColumn, score: RankedScore
) -> dict[str, Plain]:
    return {
        "table": table.name,
        "protocol": table.protocol.value,
        "domain": table.domain,
        "model": row.model,
        "source": row.source,
        "rank": row.rank,
        "ability": column.ability.value if column.ability else "all",
        "metric": column.metric,
        **dict(_flatten_numbers(_make_score_fields(score))),
        "answered": score.coverage.answered if score.coverage else None,
        "tasks": score.coverage.tasks if score.coverage else None,
    }


def _flatten_numbers(numbers: Mapping[str, Any]) -> Iterator[tuple[str, Plain]]:
    """Yield the values of a CSV line by column, with an interval split into its two bounds."""
    for name, value in numbers.items():
        if name.startswith("interval"):
            low, high = value or (None, None)
            yield name.replace("interval", "low"), low
            yield name.replace("interval", "high"), high
        else:
            yield name, value


def _make_score_fields(score: RankedScore) -> dict[str, Any]:
    """Return the JSON fields of a score: percent, fraction and interval; None for an unknown value."""
    sure = score.certainty
    return {
        "percent": score.value,
        "numerator": score.numerator,
        "denominator": score.denominator,
        "interval": list(sure.interval) if sure else None,
        "interval_by_task": list(sure.by_task) if sure else None,
        "design_effect": sure.design_effect if sure else None,
        "effective_tasks": sure.effective_task_count if sure else None,
    }


def _row_to_json(table: Ranking, row: RankedModel) -> Json:
    return {
        "model": row.model,
        "source": row.source,
        "rank": row.rank,
        "coverage": None if row.coverage is None else row.coverage.to_json(),
        "notes": list(table.find_footnote_numbers(row.notes)),
        "cells": [
            {
                "ability": column.ability.value if column.ability else None,
                "metric": column.metric,
                **_make_score_fields(score),
                "best": score.best,
                "notes": [
                    *table.find_footnote_numbers(score.texts),
                    *table.find_footnote_numbers(table.columns[column]),
                ],
            }
            for column, score in row.scores.items()
        ],
    }
