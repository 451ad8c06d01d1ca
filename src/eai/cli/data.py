"""``eai data``: get the data set, say where it is, count it, check it."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from eai.benchmarks.packs import fetch_published, published_packs
from eai.benchmarks.statistics import stats as count
from eai.benchmarks.validation import validate as check
from eai.cli.console import data_progress, output
from eai.data import dataset
from eai.data.store import Store

app = typer.Typer(help="The data set: fetch it, say where it is, count it, check it.", no_args_is_help=True)

DataFolder = Annotated[
    Path | None,
    typer.Option("--data", help="The folder of the store; EAI_DATA_DIR or the user's cache if not given."),
]


def store(folder: Path | None) -> Store:
    """The store in a folder, or in the default one."""
    return Store() if folder is None else Store(folder)


@app.command()
def fetch(
    data: DataFolder = None,
    place: Annotated[
        Path | None,
        typer.Option("--from", help="A downloaded archive, or a folder of them: works offline."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Fetch and convert again.")] = False,
) -> None:
    """Download the pinned archives with your pip or uv, verify and convert them.

    Example: eai data fetch
    """
    with data_progress() as report:
        made = fetch_published(store(data), place=place, force=force, report=report)
    message = f"made {', '.join(made)}" if made else "everything is there already"
    output().print(f"{message} ({store(data).folder})", soft_wrap=True, highlight=False)


@app.command()
def info(data: DataFolder = None) -> None:
    """Say where the data set is and what it was made from.

    Example: eai data info
    """
    table = Table("pack", "size", "made from", "sha256", "state")
    for status in dataset.info(store(data), packs=published_packs()):
        table.add_row(
            status.pack,
            f"{status.size / 1e3:,.0f} kB",
            "\n".join(status.archives),
            (status.sha256 or "-")[:12],
            status.problem or "ready",
        )
    output().print(table)
    output().print(f"folder: {store(data).folder}", soft_wrap=True, highlight=False)


@app.command()
def stats(
    data: DataFolder = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")] = False,
) -> None:
    """Print the paper's Table 2, counted from the data.

    Example: eai data stats
    """
    tables = count(store(data))
    if as_json:
        print(json.dumps([asdict(table) for table in tables], indent=2))
        return
    for counted in tables:
        table = Table("figure", "value", "what is counted", title=counted.domain, title_justify="left")
        for row in counted.rows:
            value = f"{row.value:,}" if isinstance(row.value, int) else f"{row.value:,.2f}"
            table.add_row(row.label, value, row.note)
        output().print(table)


@app.command()
def validate(data: DataFolder = None) -> None:
    """Check every file of the store against its digest, and the tasks against the published counts.

    Example: eai data validate
    """
    findings = check(store(data))
    for finding in findings:
        output().print(f"{finding.place}: {finding.problem}", soft_wrap=True, highlight=False)
    if findings:
        raise typer.Exit(2)
    output().print("the data set is as published")
