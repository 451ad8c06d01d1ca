"""``eai report``: from records to tables, plots and the explorer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.cli.console import output
from eai.errors import InputError
from eai.metrics.bootstrap import Bootstrap
from eai.report.digest import digest
from eai.report.plots import draw_plots
from eai.report.runs import read_runs
from eai.report.writer import make_tables, write_tables

PLOTS = "plots"


def report(
    records: Annotated[
        list[Path], typer.Argument(help="Files of records, or folders with records.jsonl somewhere below.")
    ],
    out: Annotated[Path, typer.Option(help="Where the report goes.")],
    paper: Annotated[bool, typer.Option("--paper", help="Show the paper's models beside the runs.")] = False,
    plots: Annotated[bool, typer.Option(help="Draw plots (needs the extra 'plots').")] = True,
) -> None:
    """Write tables (Markdown, LaTeX, CSV, JSON), plots and the HTML explorer.

    Example: eai report scores --out report --paper
    """
    bootstrap = Bootstrap()
    digests = sorted((digest(run, bootstrap) for run in read_runs(records)), key=lambda item: item.key.order)
    try:
        out.mkdir(parents=True, exist_ok=True)
        drawn = draw_plots(digests, out / PLOTS) if plots else []
        tables = make_tables(digests, bootstrap, with_paper=paper)
        write_tables(out, digests, tables, drawn, with_paper=paper)
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror})") from error
    output().print(f"{len(digests)} runs, {len(tables)} tables, {len(drawn)} plots: {out}", highlight=False)
