"""``eai analyze annotations``: how good annotations are, by people who rated them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.verdict import Json
from eai.cli.analyzed import Figures, draw_figures
from eai.cli.console import counted, tell
from eai.cli.options import AsJson
from eai.results.table_files import write_tables
from eai.studies.ratings import plots as plot_ratings
from eai.studies.ratings.analysis import PAPER, Quality, histogram_table, quality, quality_table, read_ratings


def rate_annotations(
    ratings: Annotated[
        Path, typer.Argument(help="A CSV file with the columns task, rater, attribute, score (1 to 5).")
    ],
    out: Annotated[Path, typer.Option(help="The folder for tables and plots.")] = Path("annotations"),
    plots: Annotated[bool, typer.Option(help="Draw histograms (needs the extra 'plots').")] = True,
    as_json: AsJson = False,
) -> None:
    """Say how people rated annotations: means, how far ratings of a task differ, Krippendorff's alpha.

    Example: eai analyze annotations ratings.csv --out annotations
    """
    given = read_ratings(ratings)
    found = quality(given)
    tables = (quality_table(found), histogram_table(found))
    write_tables(out, "annotations", tables, [PAPER])
    if plots:
        draw_figures(_figures(found), out)
    made: list[Json] = []
    for each in found:
        measured = {"mean": each.mean, "weighted_mse": each.weighted_mse, "alpha": each.alpha}
        counts = {"ratings": each.ratings, "tasks": each.tasks, "repeated": each.repeated}
        made.append({"attribute": each.attribute, **counts, **measured})
    value: Json = {"folder": str(out), "attributes": made}
    tell(*map(_told, found), f"written to {out}", value=value, as_json=as_json)


def _figures(found: Sequence[Quality]) -> Figures:
    yield "annotations", plot_ratings.draw(found)


def _told(each: Quality) -> str:
    alpha = "none" if each.alpha is None else f"{each.alpha:.2f}"
    mse = "none" if each.weighted_mse is None else f"{each.weighted_mse:.2f}"
    ratings, tasks = counted(each.ratings, "rating"), counted(each.tasks, "task")
    repeated = f"{each.repeated} rated more than once (weighted MSE {mse}, alpha {alpha})"
    return f"{each.attribute}: mean {each.mean:.2f}, {ratings} of {tasks}, {repeated}"
