"""``eai analyze annotations``: how good annotations are, by people who rated them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.analysis.annotations import PAPER, histogram_table, quality, quality_table, read_ratings
from eai.analysis.table import write_tables
from eai.cli.console import counted, output
from eai.report import plot_ratings


def rate_annotations(
    ratings: Annotated[
        Path, typer.Argument(help="A CSV file with the columns task, rater, attribute, score (1 to 5).")
    ],
    out: Annotated[Path, typer.Option(help="The folder for tables and plots.")] = Path("annotations"),
    plots: Annotated[bool, typer.Option(help="Draw histograms (needs the extra 'plots').")] = True,
) -> None:
    """Say how people rated annotations: means, how far ratings of a task differ, Krippendorff's alpha.

    Example: eai analyze annotations ratings.csv --out annotations
    """
    given = read_ratings(ratings)
    found = quality(given)
    tables = (quality_table(found), histogram_table(found))
    write_tables(out, "annotations", tables, [PAPER])
    if plots:
        plot_ratings.save(found, out / "annotations")
    for each in found:
        alpha = "none" if each.alpha is None else f"{each.alpha:.2f}"
        mse = "none" if each.weighted_mse is None else f"{each.weighted_mse:.2f}"
        output().print(
            f"{each.attribute}: mean {each.mean:.2f}, {counted(each.ratings, 'rating')} of "
            f"{counted(each.tasks, 'task')}, {each.repeated} rated more than once "
            f"(weighted MSE {mse}, alpha {alpha})",
            markup=False,
            highlight=False,
            soft_wrap=True,
        )
    output().print(f"written to {out}", soft_wrap=True, highlight=False, markup=False)
