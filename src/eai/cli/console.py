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

_MODELS_PER_TABLE = 4
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
        if tasks:
            bar.stop()


def print_rates(title: str, metrics: Sequence[str], rates: Mapping[str, Mapping[str, Rate]]) -> None:
    """Print rates in percent with one decimal: one row a metric, one column a model, few models a table."""
    models = list(rates)
    for start in range(0, len(models), _MODELS_PER_TABLE):
        shown = models[start : start + _MODELS_PER_TABLE]
        table = Table("percent", title=title, title_justify="left")
        for model in shown:
            table.add_column(model, justify="right", overflow="fold")
        for metric in metrics:
            table.add_row(metric.replace("_", " "), *(_percent(rates[model][metric]) for model in shown))
        output().print(table)


def _percent(rate: Rate) -> str:
    return "-" if rate.percent is None else f"{rate.percent:.1f}"
