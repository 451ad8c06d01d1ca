"""Show the progress of downloads and runs: a bar on a terminal, a few lines elsewhere.

An interrupt prints how to resume.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from functools import wraps
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Protocol, TypeAlias

from rich.console import Console
from typing_extensions import ParamSpec

from eai.base.errors import InterruptError
from eai.base.store import FetchStage, ReportProgress
from eai.cli.console import get_error_console

if TYPE_CHECKING:
    from eai.results.batch import ProgressCallback
    from eai.run.journal import ProgressWatch

PATIENCE = 5
"""Minimum seconds between two lines of progress without a terminal."""

LONGEST_SILENCE = 60
"""Maximum seconds without a line of progress, once some work is done."""

LINES = 10
"""Maximum number of progress lines without a terminal; slow work may have more."""

BESIDE_THE_TITLE = 42
"""Characters that a progress line needs beside its title: for bar, count, rate and time left."""

P = ParamSpec("P")

BESIDE_A_MAKER = 20
"""Further characters of a progress line that shows how many attempts to make a thing were refused."""

MakingCallback: TypeAlias = Callable[[int, int], None]
"""Function that is called with the numbers of things made and of refused attempts to make one."""


class _WorkWatch(Protocol):
    """Function that is called with the numbers of finished parts and of all parts of some local work."""

    def __call__(self, done: int, total: int, refused: int | None = None) -> None:
        """Show the numbers of finished parts, of all parts and, unless None, of refused attempts."""


def make_resumable(command: Callable[P, None]) -> Callable[P, None]:
    """Return a command that prints how to resume it if it is interrupted."""

    @wraps(command)
    def run_interruptible(*arguments: P.args, **options: P.kwargs) -> None:
        try:
            command(*arguments, **options)
        except KeyboardInterrupt:
            raise InterruptError("interrupted; the same command resumes from here") from None

    return run_interruptible


@contextmanager
def show_data_progress() -> Iterator[ReportProgress]:
    """Show the progress of each step of obtaining the data set, with downloads in megabytes."""
    watches: dict[str, _WorkWatch] = {}
    with ExitStack() as shown:

        def report_progress(stage: FetchStage, subject: str, done: int, total: int) -> None:
            title = f"{stage} {subject}"
            size, unit = (1_000_000, " MB") if stage == "fetching" else (1, "")
            if title not in watches:
                shown.close()
                watches[title] = shown.enter_context(_show_work_progress(title, unit=unit))
            watches[title](done // size, total // size)

        yield report_progress


def show_run_progress(title: str, *, quiet: bool) -> AbstractContextManager[ProgressWatch | None]:
    """Show the progress of a run on standard error: a line that changes on a terminal, else lines.

    The line tells the answers, the seconds since the last answer, the speed and the time left.
    """
    if quiet:
        return nullcontext()
    console = get_error_console()
    return _show_live_line(title, console) if console.is_terminal else _print_progress_lines(title, console)


@contextmanager
def show_scoring_progress(title: str, total: int, *, quiet: bool) -> Iterator[ProgressCallback]:
    """Show the progress of scoring. Without a terminal, lines begin after a few seconds."""
    if quiet:
        yield lambda scored: None
        return
    with _show_work_progress(title, PATIENCE) as watch:
        yield lambda scored: watch(scored, total)


@contextmanager
def show_making_progress(title: str, total: int, *, quiet: bool) -> Iterator[MakingCallback]:
    """Show how many things are made, how fast, and how many attempts to make one were refused."""
    if quiet:
        yield lambda made, refused: None
        return
    with _show_work_progress(title, PATIENCE, beside=BESIDE_THE_TITLE + BESIDE_A_MAKER) as watch:
        yield lambda made, refused: watch(made, total, refused)


def _show_work_progress(
    title: str, first: float = 0, unit: str = "", beside: int = BESIDE_THE_TITLE
) -> AbstractContextManager[_WorkWatch]:
    """Show the progress of local work by a bar on a terminal, or by lines in other output."""
    console = get_error_console()
    return (
        _show_progress_bar(title, console, beside)
        if console.is_terminal
        else nullcontext(_make_line_printer(title, console, first, unit))
    )


@contextmanager
def _show_progress_bar(title: str, console: Console, beside: int) -> Iterator[_WorkWatch]:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    # a narrower column would cut counts and times off
    title = _cut_start(title, console.width - beside)
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, rate="")

        def update_bar(done: int, total: int, refused: int | None = None) -> None:
            speed = bar.tasks[0].speed
            parts = [] if refused is None else [f"{refused} refused"]
            parts += [] if speed is None else [f"{speed:.1f}/s"]
            bar.update(task, total=total or None, completed=done, rate=", ".join(parts))

        yield update_bar


def _cut_start(text: str, width: int) -> str:
    return text if len(text) <= width else f"…{text[len(text) - width + 1 :]}" if width > 1 else ""


class _RunPace:
    """Progress of a run in words: answers, seconds since the last answer, tokens a second, and time left."""

    def __init__(self) -> None:
        self._began = self._changed = time.monotonic()
        self._done_before: int | None = None
        self.done = self.failed = self.total = self._tokens = 0

    def update(self, answered: int, failed: int, total: int, tokens: int) -> None:
        """Set the numbers of tasks, and of output tokens in this run."""
        done = answered + failed
        if done != self.done:
            self._changed = time.monotonic()
        self.done, self.failed, self.total, self._tokens = done, failed, total, tokens
        if self._done_before is None:  # answers that an earlier start recorded take no time
            self._done_before, self._began = done, self._changed

    def describe(self) -> str:
        """Return the progress: ``3/342, waiting 41 s, 23 tokens/s, about 12 min left``."""
        waiting, seconds = time.monotonic() - self._changed, self._changed - self._began
        parts = [f"{self.done}/{self.total}"]
        if self.done < self.total and waiting >= 1:
            parts.append(f"waiting {_format_seconds(waiting)}")
        if self._tokens and seconds:
            parts.append(f"{self._tokens / seconds:.0f} tokens/s")
        if self.failed:
            parts.append(f"{self.failed} failed")
        new = self.done - (self._done_before or 0)
        if new and self.done < self.total:
            left = max(0.0, seconds / new * (self.total - self.done) - waiting)
            parts.append(f"about {_format_seconds(left)} left")
        return ", ".join(parts)


def _format_seconds(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


@contextmanager
def _show_live_line(title: str, console: Console) -> Iterator[ProgressWatch]:
    """Show the progress of a run in one line, which is rewritten until the run ends."""
    from rich.live import Live
    from rich.text import Text

    pace = _RunPace()

    def draw_line() -> Text:
        progress = pace.describe()
        return Text(f"{_cut_start(title, console.width - len(progress) - 2)}  {progress}", no_wrap=True)

    with Live(console=console, transient=True, get_renderable=draw_line):
        yield pace.update


@contextmanager
def _print_progress_lines(title: str, console: Console) -> Iterator[ProgressWatch]:
    """Print a line for each tenth of a run, and a line after each minute without a line."""
    pace, lines, over = _RunPace(), _SpacedLinePrinter(console), Event()

    def print_progress_if_due() -> None:
        lines.print_line_if_due(f"{title}: {pace.describe()}", pace.done, pace.total)

    def update_pace(answered: int, failed: int, total: int, tokens: int) -> None:
        pace.update(answered, failed, total, tokens)
        print_progress_if_due()

    def print_at_least_each_minute() -> None:
        while not over.wait(min(1, LONGEST_SILENCE)):
            print_progress_if_due()

    timer = Thread(target=print_at_least_each_minute, daemon=True)
    timer.start()
    try:
        yield update_pace
    finally:
        over.set()
        timer.join()


class _SpacedLinePrinter:
    """Lines for each tenth of some work, with a minimum time between lines, and a line after a long silence.

    Args:
        console: where the lines are printed.
        first: minimum seconds before the first line.
    """

    def __init__(self, console: Console, first: float = 0) -> None:
        now = time.monotonic()
        self._console = console
        self._tenth, self._due, self._overdue = -1, now + first, now + LONGEST_SILENCE
        self._lock = Lock()

    def print_line_if_due(self, line: str, done: int, total: int) -> None:
        """Print a line about the work done so far, if a line is due."""
        with self._lock:
            now = time.monotonic()
            tenth = done * LINES // total if total else LINES
            is_last = done == total and self._tenth >= 0
            if (tenth != self._tenth and (is_last or now >= self._due)) or now >= self._overdue:
                self._tenth, self._due, self._overdue = tenth, now + PATIENCE, now + LONGEST_SILENCE
                self._console.print(line, markup=False, highlight=False, soft_wrap=True)


def _make_line_printer(title: str, console: Console, first: float, unit: str) -> _WorkWatch:
    """Return a function that prints lines about local work, with the estimated time left if it is slow."""
    began, lines = time.monotonic(), _SpacedLinePrinter(console, first)

    def print_if_due(done: int, total: int, refused: int | None = None) -> None:
        seconds = time.monotonic() - began
        left = seconds / done * (total - done) if done else 0
        pace = "" if refused is None or not seconds else f", {refused} refused, {done / seconds:.1f}/s"
        about = f", about {round(left / 60)} min left" if left >= LONGEST_SILENCE else ""
        lines.print_line_if_due(
            f"{title}{f': {done}/{total}{unit}' if total else ''}{pace}{about}", done, total
        )

    return print_if_due
