"""Annotations: how good they are, by people who rated them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, cast

from eai.abilities.options import Options
from eai.errors import InputError
from eai.studies.study import Analysis, Figures, Study

if TYPE_CHECKING:
    from eai.abilities.verdict import Json
    from eai.results.table import Table
    from eai.studies.records import Records


_TOLD = ("attribute", "ratings", "tasks", "repeated", "mean", "weighted_mse", "alpha")


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    """The file is no record, but a CSV file with the columns task, rater, attribute, score (1 to 5)."""
    from eai.studies.annotation.analysis import PAPER, rating_tables, read_ratings

    if len(records.paths) > 1:
        raise InputError("expected one CSV file of ratings")
    tables = rating_tables(read_ratings(records.paths[0]))
    rows = tables[0].by_name()
    attributes: list[Json] = [{name: cast("Json", row[name]) for name in _TOLD} for row in rows]
    yield Analysis(tables, _figures(tables), [PAPER], shown=tables[:1], facts={"attributes": attributes})


def _figures(tables: Sequence[Table]) -> Figures:
    from eai.studies.annotation import plots

    yield "annotations", plots.draw(tables)


ANNOTATIONS = Study(
    "annotations",
    "Ratings of annotations by people, in a CSV file: means, how far raters differ, Krippendorff's alpha.",
    analyze=_analyze,
)
