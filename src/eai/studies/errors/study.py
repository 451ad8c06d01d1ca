"""Errors: what goes wrong, and which precondition is overlooked."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from pydantic import Field

from eai.abilities.declaration import AnswerOutcome
from eai.abilities.options import Options
from eai.errors import InputError
from eai.results.plots import (
    COLUMN,
    INK,
    MUTED,
    OUTCOME_COLORS,
    cases_of,
    clipped,
    draw_band,
    draw_matrix,
    draw_names,
    rows_of,
    sheet,
    value_of,
)
from eai.results.table import Cell, Table
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, of_suite

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class _Choices(Options):
    """How errors are sorted.

    Attributes:
        examples: How many answers to name of each kind.
        explorer: An explorer.html by eai report, to which examples link.
    """

    examples: int = Field(default=3, ge=0)
    explorer: Path | None = None


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    from eai.studies.errors.analysis import error_tables

    explorer = _address(chosen.explorer, records.folder)
    tables = records.tables(features=False)
    found = error_tables(tables.answers, tables.clauses, examples=chosen.examples, explorer=explorer)
    yield Analysis(found, _figures(found))


def _address(explorer: Path | None, folder: Path) -> str | None:
    """The address of an explorer as seen from a folder.

    Raises:
        InputError: there is none.
    """
    if explorer is None:
        return None
    if not explorer.is_file():
        raise InputError(f"explorer={explorer}: no such file; eai report writes explorer.html")
    return quote(Path(os.path.relpath(explorer, folder)).as_posix())


def _figures(found: Sequence[Table]) -> Figures:
    leaves, why = found[:2]
    for suite, rows in rows_of(leaves).items():
        yield of_suite(suite, "flow", draw(rows))
        levels = ("stage", "kind", "detail")
        yield of_suite(suite, "leaves", draw_matrix(rows, levels, "answers", "percent of answers"))
    for suite, rows in rows_of(why).items():
        yield of_suite(suite, "why", draw_names(rows, "check", "share", "share of runtime errors"))


_GAP = 4.0
"""Percent between stages, and between what leaves of different stages are labelled with."""

_SMALLEST = 0.5
"""Percent below which a leaf is a band without a name."""

_LINE = 5.6
"""Percent that a line of text takes."""

_COLORS: Mapping[str, str] = {
    "success": OUTCOME_COLORS[AnswerOutcome.SUCCESS],
    "grammar": OUTCOME_COLORS[AnswerOutcome.PARSING],
    "runtime": OUTCOME_COLORS[AnswerOutcome.MISSING_STEP],
    "goal": OUTCOME_COLORS[AnswerOutcome.GOAL_MISSED],
}


def draw(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """Draw the outcomes of all models' answers, or of the only one's; None if there are none.

    Args:
        rows: those of a suite in the table of leaves.
    """
    first = rows[0]["model"] if rows else None
    cells = {_leaf(row): row["answers"] for row in rows if row["model"] == first}
    shares = {leaf: value_of(cell) for leaf, cell in cells.items()}
    shares = {leaf: share for leaf, share in shares.items() if share > 0}
    if not shares:
        return None
    stages = list(dict.fromkeys(stage for stage, _ in shares))
    named = [leaf for leaf, share in shares.items() if share >= _SMALLEST]
    figure = sheet(COLUMN, 1.2 + 0.13 * len(named))
    panel = figure.subplots()
    panel.set_axis_off()
    answers = max(map(cases_of, cells.values()))
    panel.set_title(f"{clipped(str(first))}, percent of {answers:,} answers", fontsize=7.5)
    top, stage_top, text_top = 100.0, 100.0 + _GAP * (len(stages) - 1) / 2, 104.0
    for stage in stages:
        leaves = {leaf: share for leaf, share in shares.items() if leaf[0] == stage}
        whole, color = sum(leaves.values()), _COLORS.get(stage, MUTED)
        draw_band(panel, 0, (top - whole, stage_top - whole, whole), color)
        at = stage_top
        for leaf, share in leaves.items():
            middle = at - share / 2
            panel.fill_between([1, 1.12], at - share, at, facecolor=color, edgecolor="white", linewidth=0.5)
            if share >= _SMALLEST:
                name = leaf[1] or stage.replace("_", " ")
                text_top = min(middle, text_top - _LINE)
                panel.plot([1.12, 1.2], [middle, text_top], color=MUTED, linewidth=0.6)
                panel.text(1.22, text_top, f"{name} {share:.1f}", fontsize=6.5, va="center", color=INK)
            at -= share
        top -= whole
        stage_top -= whole + _GAP
    panel.set_xlim(-0.02, 2.2)
    panel.set_ylim(min(stage_top, text_top) - _GAP, 104 + _GAP)
    return figure


def _leaf(row: Mapping[str, Cell]) -> tuple[str, str]:
    parts = [str(row[level]).replace("_", " ") for level in ("kind", "detail") if row[level]]
    return str(row["stage"]), ": ".join(parts)


ERRORS = Study(
    "errors",
    "Errors by the paper's taxonomy, and which check failed how often.",
    choices=_Choices,
    analyze=_analyze,
    together=True,
)
