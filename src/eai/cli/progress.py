"""Show the progress of downloads and runs: a bar on a terminal, a few lines elsewhere.

An interrupt prints how to resume.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from functools import wraps
from typing import TYPE_CHECKING

from rich.console import Console
from typing_extensions import ParamSpec

from eai.base.errors import InterruptError
from eai.base.store import FetchStage, ReportProgress
from eai.cli.console import errors

if TYPE_CHECKING:
    from eai.results.batch import ProgressCallback
    from eai.run.journal import ProgressWatch

PATIENCE = 5
"""Minimum seconds between two lines of progress without a terminal."""

LONGEST_SILENCE = 60
"""Maximum seconds without a line of progress, once some work is done."""

LINES = 10
"""Maximum number of progress lines of a run without a terminal, apart from slow runs."""

BESIDE_THE_TITLE = 42
"""Columns of a progress line next to its title: bar, count, rate, time left, failures."""

P = ParamSpec("P")


def resumable(command: Callable[P, None]) -> Callable[P, None]:
    """Return a command that prints how to resume it if it is interrupted."""

    @wraps(command)
    def interruptible(*arguments: P.args, **options: P.kwargs) -> None:
        try:
            command(*arguments, **options)
        except KeyboardInterrupt:
            raise InterruptError("interrupted; the same command resumes from here") from None

    return interruptible


@contextmanager
def data_progress() -> Iterator[ReportProgress]:
    """Show the progress of each step of obtaining the data set, with downloads in megabytes."""
    watches: dict[str, ProgressWatch] = {}
    with ExitStack() as shown:

        def report(stage: FetchStage, subject: str, done: int, total: int) -> None:
            title = f"{stage} {subject}"
            size, unit = (1_000_000, " MB") if stage == "fetching" else (1, "")
            if title not in watches:
                shown.close()
                watches[title] = shown.enter_context(_watching(title, unit=unit))
            watches[title](done // size, 0, total // size)

        yield report


def run_progress(title: str, *, quiet: bool) -> AbstractContextManager[ProgressWatch | None]:
    """Show the progress of a run on standard error, and remove the bar at the end."""
    return nullcontext() if quiet else _watching(title)


@contextmanager
def scoring_progress(title: str, total: int, *, quiet: bool) -> Iterator[ProgressCallback]:
    """Show the progress of scoring. Without a terminal, lines begin after a few seconds."""
    if quiet:
        yield lambda scored: None
        return
    with _watching(title, PATIENCE) as watch:
        yield lambda scored: watch(scored, 0, total)


def _watching(title: str, first: float = 0, unit: str = "") -> AbstractContextManager[ProgressWatch]:
    """Show progress by a bar on a terminal, or by lines in other output."""
    console = errors()
    return _bar(title, console) if console.is_terminal else nullcontext(_lines(title, console, first, unit))


@contextmanager
def _bar(title: str, console: Console) -> Iterator[ProgressWatch]:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[failed]}", style="red"),
    )
    room = console.width - BESIDE_THE_TITLE
    title = (
        title if len(title) <= room else f"…{title[1 - room :]}"
    )  # a narrower column would cut counts and times off
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, rate="", failed="")

        def watch(answered: int, failed: int, total: int) -> None:
            speed = bar.tasks[0].speed
            bar.update(
                task,
                total=total or None,
                completed=answered + failed,
                rate="" if speed is None else f"{speed:.1f}/s",
                failed=f"{failed} failed" if failed else "",
            )

        yield watch


def _lines(title: str, console: Console, first: float, unit: str) -> ProgressWatch:
    """Return a function that prints a line for each tenth of the work, with a minimum time between lines.

    If work is slow, it prints lines more often, with the estimated time left.
    """
    began = time.monotonic()
    shown, due, overdue = -1, began + first, began + LONGEST_SILENCE

    def watch(answered: int, failed: int, total: int) -> None:
        nonlocal shown, due, overdue
        done, now = answered + failed, time.monotonic()
        tenth = done * LINES // total if total else LINES
        last = done == total and shown >= 0
        if (tenth != shown and (last or now >= due)) or now >= overdue:
            shown, due, overdue = tenth, now + PATIENCE, now + LONGEST_SILENCE
            failures = f", {failed} failed" if failed else ""
            left = (now - began) / done * (total - done) if done else 0
            about = f", about {round(left / 60)} min left" if left >= LONGEST_SILENCE else ""
            count = f": {done}/{total}{unit}" if total else ""
            console.print(f"{title}{count}{failures}{about}", markup=False, highlight=False, soft_wrap=True)

    return watch
