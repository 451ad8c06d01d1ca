"""``eai analyze cofactors``: what success depends on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.cli.analyzed import Figures, Plots, Records, of_suite, say, tables_of, with_extra, write_analysis
from eai.cli.options import AsJson
from eai.cli.store import DataFolder
from eai.results import plot_analyses
from eai.results.suites import Measure
from eai.results.table import Table
from eai.studies.cofactors import plots as plot_cofactors
from eai.studies.cofactors.analysis import cofactor_tables


def cofactors(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results.")],
    bins: Annotated[
        int, typer.Option(min=1, help="How many lengths of annotated plans stand together.")
    ] = 10,
    measure: Annotated[Measure, typer.Option(help="What features of tasks are set against.")] = Measure.SCORE,
    plots: Plots = True,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Set success against what tasks are like, and say what is left of each feature beside the others.

    Example: eai analyze cofactors scores --out cofactors
    """
    tables = tables_of(records, data)
    with with_extra():
        found = cofactor_tables(tables, width=bins, measure=measure)
    written = write_analysis("cofactors", found, figures(found, measure), out, plots=plots)
    say(written, as_json=as_json)


def figures(found: list[Table], measure: Measure) -> Figures:
    """The plots of the analysis."""
    adjusted, _, curves, by_action, by_predicate = found
    label = f"{measure.value}, percent"
    for suite, rows in plot_analyses.rows_of(curves).items():
        yield of_suite(suite, "curves", plot_cofactors.draw_curves(rows, label))
    for suite, rows in plot_analyses.rows_of(adjusted).items():
        yield of_suite(suite, "adjusted", plot_cofactors.draw_effects(rows))
    for suite, rows in plot_analyses.rows_of(by_action).items():
        figure = plot_analyses.draw_names(rows, "action", "executed", "executed of the steps tried")
        yield of_suite(suite, "by_action", figure)
    for suite, rows in plot_analyses.rows_of(by_predicate).items():
        figure = plot_analyses.draw_names(
            rows, "predicate", "reached", "reached of the goals that mention it"
        )
        yield of_suite(suite, "by_predicate", figure)
