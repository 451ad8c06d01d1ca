"""What the commands share: consoles, progress bars, tables of rates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table

from eai.data.progress import Progress as Step
from eai.data.progress import Report, Stage
from eai.metrics.rate import Rate

_STAGES = {Stage.WAIT: "waiting for", Stage.DOWNLOAD: "fetching", Stage.CONVERT: "converting"}


def output() -> Console:
    """Where results go."""
    return Console()


def errors() -> Console:
    """Where everything else goes."""
    return Console(stderr=True)


@contextmanager
def data_progress() -> Iterator[Report]:
    """A progress bar for obtaining the data set; it appears with the first step."""
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f}%"))
    bar = Progress(*columns, TimeRemainingColumn(), console=errors(), transient=True)
    tasks: dict[tuple[Stage, str], TaskID] = {}

    def report(step: Step) -> None:
        key = (step.stage, step.subject)
        if not tasks:
            bar.start()
        if key not in tasks:
            tasks[key] = bar.add_task(f"{_STAGES[step.stage]} {step.subject}", total=step.total or None)
        bar.update(tasks[key], completed=step.done)

    try:
        yield report
    finally:
        bar.stop()


def rates_table(title: str, columns: Sequence[str], rows: Mapping[str, Mapping[str, Rate]]) -> Table:
    """One row a model, one column a metric, in percent with one decimal."""
    table = Table(title=title, title_justify="left")
    table.add_column("model", no_wrap=True)
    for column in columns:
        table.add_column(column.replace("_", "\n"), justify="right")
    for model, rates in rows.items():
        table.add_row(model, *(_percent(rates[column]) for column in columns))
    return table


def _percent(rate: Rate) -> str:
    return "-" if rate.percent is None else f"{rate.percent:.1f}"
