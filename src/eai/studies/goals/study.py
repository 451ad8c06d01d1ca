"""Goals: which ones goal interpretation finds, misses and makes up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.studies.study import Analysis, Figures, Study, of_suite

if TYPE_CHECKING:
    from eai.results.table import Table
    from eai.studies.records import Records


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    from eai.studies.goals.analysis import goal_tables

    found = goal_tables(records.tables().atoms)
    yield Analysis(found, _figures(found))


def _figures(found: Sequence[Table]) -> Figures:
    from eai.results.plots import draw_matrix, draw_names, rows_of

    by_predicate, reasons = found[:2]
    for suite, rows in rows_of(by_predicate).items():
        for score in ("precision", "recall"):
            yield of_suite(suite, score, draw_names(rows, "predicate", score, score))
    for suite, rows in rows_of(reasons).items():
        yield of_suite(suite, "reasons", draw_matrix(rows, ("reason",), "share", "percent of wrong goals"))


GOALS = Study(
    "goals",
    "Goal interpretation by predicate: found, missed and made up, and where wrong goals come from.",
    analyze=_analyze,
    together=True,
)
