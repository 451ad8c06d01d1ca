"""``eai report``: from records to tables, plots and the explorer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.protocol import Ability, Domain
from eai.benchmarks import gold_operators
from eai.benchmarks.packs import published_packs
from eai.benchmarks.published_prompts import official_prompts
from eai.cli.console import errors, output
from eai.cli.data import DataFolder, store
from eai.data import dataset
from eai.data.store import Store
from eai.errors import DataError, EaiError, InputError
from eai.metrics.bootstrap import Bootstrap
from eai.report.document import Plot
from eai.report.explorer import explorer_html
from eai.report.explorer_data import Background, ExplorerData
from eai.report.plots import draw_plots
from eai.report.run_summary import RunSummary, summary_of
from eai.report.runs import read_runs
from eai.report.writer import make_tables, write_tables

PLOTS = "plots"
EXPLORER = "explorer.html"


def report(
    records: Annotated[
        list[Path], typer.Argument(help="Files of records, or folders with records.jsonl somewhere below.")
    ],
    out: Annotated[Path, typer.Option(help="Where the report goes.")],
    paper: Annotated[bool, typer.Option("--paper", help="Show the paper's models beside the runs.")] = False,
    plots: Annotated[bool, typer.Option(help="Draw plots (needs the extra 'plots').")] = True,
    prompts: Annotated[
        bool, typer.Option(help="Put prompts and the data set's operators into the explorer.")
    ] = True,
    data: DataFolder = None,
) -> None:
    """Write tables (Markdown, LaTeX, CSV, JSON), plots and the HTML explorer.

    Example: eai report scores --out report --paper
    """
    bootstrap = Bootstrap()
    explorer = ExplorerData(background(store(data)) if prompts else Background())
    runs = []
    for run in read_runs(records):
        runs.append(summary_of(run, bootstrap))
        explorer.add(run)
    runs.sort(key=lambda item: item.key.order)
    tables = make_tables(runs, bootstrap, with_paper=paper)
    try:
        out.mkdir(parents=True, exist_ok=True)
        drawn = _draw(runs, out / PLOTS) if plots else []
        written = write_tables(out, runs, tables, drawn, with_paper=paper)
        (out / EXPLORER).write_text(explorer_html(explorer.to_json()), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror})") from error
    message = f"{len(runs)} runs, {written} tables, {len(drawn)} plots; open {out / EXPLORER}"
    output().print(message, soft_wrap=True, highlight=False)


def _draw(runs: Sequence[RunSummary], folder: Path) -> list[Plot]:
    """The plots, or none and a remark where matplotlib is not installed."""
    try:
        return draw_plots(runs, folder)
    except EaiError as error:
        errors().print(f"no plots: {error}", markup=False, highlight=False, soft_wrap=True)
        return []


def background(source: Store) -> Background:
    """What the user's data set says of the tasks; nothing is fetched for it."""
    if any(status.problem for status in dataset.info(source, packs=published_packs())):
        return Background()
    gold = {
        Domain.VIRTUALHOME.value: gold_operators.open_virtualhome(source),
        Domain.BEHAVIOR.value: gold_operators.open_behavior(source),
    }
    return Background(
        prompts={
            (domain.value, ability.value): _prompts(domain, ability, source)
            for domain in Domain
            for ability in Ability
        },
        operators={
            domain: {
                name: operator.pddl
                for task in list(tasks.values())[:1]
                for name, operator in task.domain.operators.items()
            }
            for domain, tasks in gold.items()
        },
    )


def _prompts(domain: Domain, ability: Ability, source: Store) -> dict[str, str]:
    try:
        found = official_prompts(domain, ability, source)
    except DataError:
        return {}
    return {
        task_id: f"{prompt.system}\n\n{prompt.user}" if prompt.system else prompt.user
        for task_id, prompt in found.items()
    }
