"""Errors: what goes wrong, and which precondition is overlooked."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from eai.abilities.options import Options, option
from eai.errors import InputError
from eai.studies.study import Analysis, Figures, Study, of_suite

if TYPE_CHECKING:
    from eai.results.table import Table
    from eai.studies.records import Records


class _Choices(Options):
    """How errors are sorted."""

    examples: int = option("How many answers to name of each kind.", 3, ge=0)
    explorer: Path | None = option("An explorer.html by eai report, to which examples link.")


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
    from eai.results.plots import draw_matrix, draw_names, rows_of
    from eai.studies.errors import plots

    leaves, why = found[:2]
    for suite, rows in rows_of(leaves).items():
        yield of_suite(suite, "flow", plots.draw(rows))
        levels = ("stage", "kind", "detail")
        yield of_suite(suite, "leaves", draw_matrix(rows, levels, "answers", "percent of answers"))
    for suite, rows in rows_of(why).items():
        yield of_suite(suite, "why", draw_names(rows, "check", "share", "share of runtime errors"))


ERRORS = Study(
    "errors",
    "Errors by the paper's taxonomy, and which check failed how often.",
    choices=_Choices,
    analyze=_analyze,
    together=True,
)
