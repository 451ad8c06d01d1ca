"""Annotations: how good they are, by people who rated them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, cast

from eai.abilities.options import Options
from eai.errors import InputError
from eai.results.plots import ACCENT, INK, clipped, sheet
from eai.studies.study import Analysis, Figures, Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    yield "annotations", draw(tables)


_PANEL = (2.3, 2.0)
_COLUMNS = 3


def draw(tables: Sequence[Table]) -> Figure:
    """Draw the histograms of the tables of the analysis."""
    attributes, scores = (table.by_name() for table in tables)
    columns = min(_COLUMNS, len(attributes))
    rows = -(-len(attributes) // columns)
    figure = sheet(_PANEL[0] * columns, _PANEL[1] * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).flatten()
    for panel, each in zip(panels, attributes, strict=False):
        name = str(each["attribute"])
        counts = {row["score"]: row["ratings"] for row in scores if row["attribute"] == name}
        panel.set_title(clipped(name))
        panel.bar(list(counts), list(counts.values()), width=0.8, color=ACCENT)
        for score, count in counts.items():
            if count:
                panel.annotate(str(count), (score, count), ha="center", va="bottom", fontsize=6.5, color=INK)
        panel.set_xticks(list(counts))
        panel.set_xlabel(f"mean {each['mean']:.2f}, n = {each['ratings']}")
    for panel in panels[::columns]:
        panel.set_ylabel("ratings")
        panel.yaxis.get_major_locator().set_params(integer=True)
    for panel in panels[len(attributes) :]:
        panel.set_visible(False)
    return figure


ANNOTATIONS = Study(
    "annotations",
    "Ratings of annotations by people, in a CSV file: means, how far raters differ, Krippendorff's alpha.",
    analyze=_analyze,
)
