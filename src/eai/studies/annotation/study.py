"""Annotations: how good they are, by people who rated them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.errors import InputError
from eai.studies.study import Analysis, Figures, Study

if TYPE_CHECKING:
    from eai.abilities.verdict import Json
    from eai.studies.annotation.ratings import Quality
    from eai.studies.records import Records


_MEASURED = ("mean", "weighted_mse", "alpha")


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    """The file is no record, but a CSV file with the columns task, rater, attribute, score (1 to 5)."""
    from eai.studies.annotation.ratings import PAPER, histogram_table, quality, quality_table, read_ratings

    if len(records.paths) > 1:
        raise InputError("expected one CSV file of ratings")
    found = quality(read_ratings(records.paths[0]))
    tables = (quality_table(found), histogram_table(found))
    attributes: list[Json] = [
        {name: getattr(each, name) for name in ("attribute", "ratings", "tasks", "repeated", *_MEASURED)}
        for each in found
    ]
    yield Analysis(tables, _figures(found), [PAPER], shown=tables[:1], facts={"attributes": attributes})


def _figures(found: Sequence[Quality]) -> Figures:
    from eai.studies.annotation import plots

    yield "annotations", plots.draw(found)


ANNOTATIONS = Study(
    "annotations",
    "Ratings of annotations by people, in a CSV file: means, how far raters differ, Krippendorff's alpha.",
    analyze=_analyze,
)
