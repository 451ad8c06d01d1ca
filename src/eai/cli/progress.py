"""Show the progress of downloads and runs: a bar with the time left on a terminal, few lines elsewhere.

An interrupt prints how to resume.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from datetime import timedelta
from functools import partial, wraps
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Protocol, TypeAlias

from rich.console import Console
from typing_extensions import ParamSpec

from eai.base.errors import UserInterruptError
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
"""Number of equal parts of the work. Without a terminal, a progress line is due after each part."""

PARTS_BEFORE_FIRST_ESTIMATE = 100
"""Without a terminal, a progress line with the time left is due after this number of finished parts."""

WIDTH_WITHOUT_TITLE = 42
"""Width of a progress line without its title, in characters: bar, count, rate and time left."""

_UNKNOWN_TIME = "-:--:--"
"""Text of a progress bar in place of the time left, before a part is finished."""

P = ParamSpec("P")

REFUSED_COUNT_WIDTH = 20
"""Width of the number of refused tasks in a progress line of `eai generate`, in characters."""

GenerationProgressCallback: TypeAlias = Callable[[int, int], None]
"""Function that is called with two numbers: of generated tasks, and of generated tasks that were refused."""


class _WorkProgressCallback(Protocol):
    """Function that shows how much of some local work, such as scoring, is finished."""

    def __call__(self, done: int, total: int, refused: int | None = None) -> None:
        """Show how much of the work is finished.

        Args:
            done: number of finished parts of the work, such as scored answers.
            total: number of all parts.
            refused: number of generated tasks that were refused; None for work that refuses none.
        """


def make_command_print_how_to_resume(command: Callable[P, None]) -> Callable[P, None]:
    """Return a command that prints how to resume it if it is interrupted."""

    @wraps(command)
    def run_command_and_explain_interrupt(*arguments: P.args, **options: P.kwargs) -> None:
        try:
            command(*arguments, **options)
        except KeyboardInterrupt:
            raise UserInterruptError("interrupted; the same command resumes from here") from None

    return run_command_and_explain_interrupt


@contextmanager
def show_data_progress() -> Iterator[ReportProgress]:
    """Show the progress of each step of obtaining the data set, with downloads in megabytes."""
    watches: dict[str, _WorkProgressCallback] = {}
    with ExitStack() as shown:

        def report_progress(stage: FetchStage, subject: str, done: int, total: int) -> None:
            title = f"{stage} {subject}"
            size, unit = (1_000_000, " MB") if stage == "fetching" else (1, "")
            if title not in watches:
                shown.close()
                watches[title] = shown.enter_context(_WorkProgress(unit=unit).show(title))
            watches[title](done // size, total // size)

        yield report_progress


def show_run_progress(title: str, *, quiet: bool) -> AbstractContextManager[ProgressWatch | None]:
    """Show the progress of a run on standard error: a line that changes on a terminal, else lines.

    The line tells the answers, the seconds since the last answer, the speed and the time left. On a terminal
    it disappears when the run ends. The first failure has a line of its own, because all later answers may
    fail, too. With ``quiet``, nothing is shown, and the context manager yields None.
    """
    if quiet:
        return nullcontext()
    console = get_error_console()
    return _show_live_line(title, console) if console.is_terminal else _print_progress_lines(title, console)


@contextmanager
def show_scoring_progress(title: str, total: int, *, quiet: bool) -> Iterator[ProgressCallback]:
    """Show the progress of scoring on standard error: a bar on a terminal, else lines.

    The first line comes after `PATIENCE` seconds.
    """
    if quiet:
        yield lambda scored: None
        return
    with _WorkProgress(PATIENCE).show(title) as watch:
        yield lambda scored: watch(scored, total)


def make_scoring_progress_display(
    total: int, kept: int, *, quiet: bool
) -> Callable[[str], AbstractContextManager[ProgressCallback]]:
    """Return a function that shows the progress of scoring one of several files, below a title for this file.

    Number of answers and time left count all files together. The callback takes the number of
    newly scored answers.

    Args:
        total: number of answers in all files.
        kept: number of answers that an interrupted command has scored already.
        quiet: show nothing.
    """
    progress, done = _WorkProgress(PATIENCE, finished_before=kept), kept

    @contextmanager
    def show_progress_of_file(title: str) -> Iterator[ProgressCallback]:
        with progress.show(title) as watch:

            def add_to_answer_count(number: int) -> None:
                nonlocal done
                done += number
                watch(done, total)

            add_to_answer_count(0)
            yield add_to_answer_count

    return (lambda title: nullcontext(lambda number: None)) if quiet else show_progress_of_file


@contextmanager
def show_generation_progress(title: str, total: int, *, quiet: bool) -> Iterator[GenerationProgressCallback]:
    """Show how many tasks are generated, how fast, and how many generated tasks were refused."""
    if quiet:
        yield lambda made, refused: None
        return
    width = WIDTH_WITHOUT_TITLE + REFUSED_COUNT_WIDTH
    with _WorkProgress(PATIENCE, width_without_title=width).show(title) as watch:
        yield lambda made, refused: watch(made, total, refused)


class _WorkProgress:
    """Progress of local work under one title, or under several titles one after the other.

    The time left is estimated from the mean speed since this object was created.

    Args:
        first_delay: minimum seconds before the first line, if the output is no terminal.
        unit: text after the numbers of parts, such as `` MB``.
        width_without_title: width of a progress bar without its title, in characters.
        finished_before: number of parts that an interrupted command finished; they do not count in the mean
            speed.
    """

    def __init__(
        self,
        first_delay: float = 0,
        unit: str = "",
        width_without_title: int = WIDTH_WITHOUT_TITLE,
        finished_before: int = 0,
    ) -> None:
        self._console = get_error_console()
        self._lines = _RateLimitedLinePrinter(self._console, first_delay)
        self._began = time.monotonic()
        self._unit, self._width_without_title = unit, width_without_title
        self._finished_before = finished_before

    def show(self, title: str) -> AbstractContextManager[_WorkProgressCallback]:
        """Show the progress by a bar on a terminal, or by lines in other output."""
        if self._console.is_terminal:
            return self._show_bar(title)
        return nullcontext(partial(self._print_line_if_due, title))

    def _estimate_seconds_left(self, done: int, total: int) -> float | None:
        """Return the seconds for the remaining parts, or None if no part is finished or none remains."""
        new = done - self._finished_before
        return (time.monotonic() - self._began) / new * (total - done) if new > 0 and done < total else None

    @contextmanager
    def _show_bar(self, title: str) -> Iterator[_WorkProgressCallback]:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TextColumn("{task.fields[left]}"),
        )
        # with a longer title, the terminal would cut counts and times off
        title = _cut_off_start(title, self._console.width - self._width_without_title)
        with Progress(*columns, console=self._console, transient=True) as bar:
            task = bar.add_task(title, total=None, rate="", left=_UNKNOWN_TIME)

            def update_bar(done: int, total: int, refused: int | None = None) -> None:
                speed = bar.tasks[0].speed
                parts = [] if refused is None else [f"{refused} refused"]
                parts += [] if speed is None else [f"{speed:.1f}/s"]
                seconds = self._estimate_seconds_left(done, total)
                left = _UNKNOWN_TIME if seconds is None else str(timedelta(seconds=round(seconds)))
                bar.update(task, total=total or None, completed=done, rate=", ".join(parts), left=left)

            yield update_bar

    def _print_line_if_due(self, title: str, done: int, total: int, refused: int | None = None) -> None:
        seconds = time.monotonic() - self._began
        pace = "" if refused is None or not seconds else f", {refused} refused, {done / seconds:.1f}/s"
        left = self._estimate_seconds_left(done, total)
        has_enough = done - self._finished_before >= min(PARTS_BEFORE_FIRST_ESTIMATE, total // LINES)
        is_shown = left is not None and (has_enough or left >= LONGEST_SILENCE)
        about = f", about {_format_seconds(left or 0)} left" if is_shown else ""
        count = f": {done}/{total}{self._unit}" if total else ""
        self._lines.print_line_if_due(f"{title}{count}{pace}{about}", done, total)


def _cut_off_start(text: str, width: int) -> str:
    return text if len(text) <= width else f"…{text[len(text) - width + 1 :]}" if width > 1 else ""


class _RunProgressInWords:
    """Progress of a run in words: answers, seconds since the last answer, tokens a second, and time left."""

    def __init__(self) -> None:
        self._began = self._changed = time.monotonic()
        self._done_before: int | None = None
        self.done = self.failed = self.total = self._tokens = 0

    def update(self, answered: int, failed: int, total: int, tokens: int) -> None:
        """Set the numbers of answered, failed and all tasks, and of output tokens in this run."""
        done = answered + failed
        if done != self.done:
            self._changed = time.monotonic()
        self.done, self.failed, self.total, self._tokens = done, failed, total, tokens
        if self._done_before is None:  # earlier answers of a resumed run do not count for the time left
            self._done_before, self._began = done, self._changed

    def describe_run_progress(self) -> str:
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

    pace = _RunProgressInWords()

    def draw_line() -> Text:
        progress = pace.describe_run_progress()
        return Text(f"{_cut_off_start(title, console.width - len(progress) - 2)}  {progress}", no_wrap=True)

    def update(answered: int, failed: int, total: int, tokens: int, failure: str) -> None:
        _print_first_failure(console, title, pace, failure)
        pace.update(answered, failed, total, tokens)

    with Live(console=console, transient=True, get_renderable=draw_line):
        yield update


def _print_first_failure(console: Console, title: str, pace: _RunProgressInWords, failure: str) -> None:
    if failure and not pace.failed:
        line = f"{title}: the first failure: {failure}"
        console.print(line, markup=False, highlight=False, soft_wrap=not console.is_terminal)


@contextmanager
def _print_progress_lines(title: str, console: Console) -> Iterator[ProgressWatch]:
    """Print a line for each tenth of a run, and a line after each minute without a line."""
    pace, lines, over = _RunProgressInWords(), _RateLimitedLinePrinter(console), Event()

    def print_progress_if_due() -> None:
        lines.print_line_if_due(f"{title}: {pace.describe_run_progress()}", pace.done, pace.total)

    def update_answering_pace(answered: int, failed: int, total: int, tokens: int, failure: str) -> None:
        _print_first_failure(console, title, pace, failure)
        pace.update(answered, failed, total, tokens)
        print_progress_if_due()

    def print_progress_when_due_until_over() -> None:
        while not over.wait(min(1, LONGEST_SILENCE)):
            print_progress_if_due()

    timer = Thread(target=print_progress_when_due_until_over, daemon=True)
    timer.start()
    try:
        yield update_answering_pace
    finally:
        over.set()
        timer.join()


class _RateLimitedLinePrinter:
    """Prints a progress line after each tenth of the work.

    It also prints a line after the first `PARTS_BEFORE_FIRST_ESTIMATE` parts, and after
    `LONGEST_SILENCE` seconds without a line. Lines are at least `PATIENCE` seconds apart; only the last
    line of the work need not wait.

    Args:
        console: where the lines are printed.
        first: minimum seconds before the first line.
    """

    def __init__(self, console: Console, first: float = 0) -> None:
        now = time.monotonic()
        self._console = console
        self._step, self._due, self._overdue = -1, now + first, now + LONGEST_SILENCE
        self._lock = Lock()

    def print_line_if_due(self, line: str, done: int, total: int) -> None:
        """Print a line about the work done so far, if enough time or work has passed since the last line."""
        with self._lock:
            now = time.monotonic()
            step = done * LINES // total if total else LINES
            step += done >= min(PARTS_BEFORE_FIRST_ESTIMATE, total // LINES)
            is_last = done == total and self._step >= 0
            if (step != self._step and (is_last or now >= self._due)) or now >= self._overdue:
                self._step, self._due, self._overdue = step, now + PATIENCE, now + LONGEST_SILENCE
                self._console.print(line, markup=False, highlight=False, soft_wrap=True)
