"""What the commands share: consoles, progress bars, tables of rates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.planners import available
from eai.benchmarks.suite import Suite
from eai.data.progress import Progress as Step
from eai.data.progress import Report, Stage
from eai.errors import EaiError
from eai.metrics.coverage import Coverage
from eai.metrics.rate import Rate
from eai.pddl.planning import PlannerChoice

DOMAIN_HELP = (
    "A benchmark: virtualhome, behavior, another one by its name, module:object, pddl:FILE,DIR, "
    "or task files, FILE.jsonl or DIR/."
)
"""What ``--domain`` takes."""

MISSING_HELP = "Leave tasks without an answer out of all rates; the run is then not ranked."
"""What ``--allow-missing`` does."""

BUILT_IN_ALONE = (
    "Fast Downward is not installed: the built-in search judges operators alone, and what it cannot decide "
    "counts as not solved. For both: pip install 'embodied-agent-interface[planner]'"
)
"""What there is to say where the authority on operators is missing."""

_COLUMN_WIDTH = 18
"""What a model's column is granted before its name is folded, frame included."""

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


@dataclass(frozen=True, slots=True)
class Result:
    """What a table shows of one model: its rates, and how much of the suite they are of."""

    rates: Mapping[str, Rate]
    coverage: Coverage


def print_rates(title: str, metrics: Sequence[str], results: Mapping[str, Result]) -> None:
    """Print rates in percent with one decimal: a row a metric, a column a model; as many as fit a table.

    The first row says how many tasks are answered; what is remarkable about that follows on standard error.
    """
    console = output()
    models, labels = list(results), [metric.replace("_", " ").replace(".", ", ") for metric in metrics]
    room = console.width - max(map(len, labels), default=0)
    per_table = max(1, room // _COLUMN_WIDTH)
    for start in range(0, len(models), per_table):
        shown = models[start : start + per_table]
        console.print(Text(title, style="italic"), soft_wrap=True)
        table = Table()
        table.add_column("percent", no_wrap=True)
        for model in shown:
            table.add_column(model, justify="right", overflow="fold")
        table.add_row("answered tasks", *(str(results[model].coverage) for model in shown), end_section=True)
        for label, metric in zip(labels, metrics, strict=True):
            table.add_row(label, *(_percent(results[model].rates[metric]) for model in shown))
        console.print(table)
    for model, result in results.items():
        print_remark(model, result.coverage)


def print_remark(name: str, coverage: Coverage) -> None:
    """Say on standard error what is remarkable about how much of a suite is answered."""
    if coverage.remark is not None:
        errors().print(f"{name}: {coverage.remark}", markup=False, highlight=False, soft_wrap=True)


def note_planner(suites: Sequence[Suite]) -> None:
    """Say on standard error, once, if operators are judged without Fast Downward because it is not there."""
    judging = [suite for suite in suites if suite.ability is Ability.TRANSITION_MODELING]
    asked = {suite.source.planner for suite in judging}
    if PlannerChoice.AUTO in asked and available(PlannerChoice.AUTO) is PlannerChoice.BUILT_IN:
        errors().print(BUILT_IN_ALONE, markup=False, highlight=False, soft_wrap=True)


def without_inspect(error: ImportError) -> EaiError:
    """What to say where a command needs Inspect and it is not installed."""
    hint = "pip install 'embodied-agent-interface[run]'"
    return EaiError(f"model runs and their logs need inspect-ai ({error.name} is missing): {hint}")


def counted(number: int, noun: str) -> str:
    """A number of things: ``1 task``, ``1,000 tasks``."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"


def dollars(amount: float) -> str:
    """An amount of money, to the cent from a dollar on and finer below."""
    return f"${amount:.2f}" if amount >= 1 else f"${amount:.4f}"


def _percent(rate: Rate) -> str:
    return "-" if rate.percent is None else f"{rate.percent:.1f}"
