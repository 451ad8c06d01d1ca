"""What ``eai data stats`` prints and writes: figures beside the paper's, features of tasks, distributions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rich.table import Table

from eai.benchmark.benchmark import Benchmark
from eai.cli.console import output
from eai.data.files import write_whole
from eai.report import plot_distributions
from eai.results.data_set.distributions import distributions
from eai.results.data_set.profiles import profiles_of
from eai.results.data_set.statistics import StatRow, StatTable
from eai.results.table import csv_text
from eai.tasks.source import Source


def print_statistics(counted: StatTable) -> None:
    """Print a table; the paper's column only where the paper has figures of the benchmark."""
    printed = any(row.printed is not None for row in counted.rows)
    table = Table(title=counted.title, title_justify="left")
    table.add_column("figure")
    table.add_column("counted", justify="right", no_wrap=True)
    if printed:
        table.add_column("paper", justify="right", no_wrap=True)
    table.add_column("what is counted")
    for row in counted.rows:
        beside = [_number(row.printed)] if printed else []
        table.add_row(row.label, _number(row.value), *beside, _words(row))
    output().print(table)


def _words(row: StatRow) -> str:
    return f"{row.note}. {row.remark}" if row.remark else row.note


def _number(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:,}" if isinstance(value, int) else f"{value:,.2f}".rstrip("0").rstrip(".")


def write_tasks(benchmark: Benchmark, source: Source, out: Path) -> Path:
    """Write what each task is like, a line a task."""
    rows = [each.to_json() for each in profiles_of(benchmark, source)]
    return _write_csv(out / f"{benchmark.name}-tasks.csv", rows)


def write_distributions(benchmark: Benchmark, source: Source, out: Path) -> list[Path]:
    """Write every value of every distribution with its count, and plots of them."""
    found = distributions(benchmark, source)
    rows: list[Mapping[str, Any]] = [
        {"distribution": each.name, "value": value, "of": each.of, "count": count}
        for each in found
        for value, count in each.counts.items()
    ]
    file = _write_csv(out / f"{benchmark.name}-distributions.csv", rows)
    return [file, *plot_distributions.save(found, benchmark.title or benchmark.name, out / benchmark.name)]


def _write_csv(path: Path, rows: Iterable[Mapping[str, Any]]) -> Path:
    """Write rows with the same fields; raises InputError where that cannot be done."""
    lines = list(rows)
    write_whole({path: csv_text(list(lines[0]) if lines else [], [list(line.values()) for line in lines])})
    return path
