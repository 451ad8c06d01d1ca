from __future__ import annotations

import io
import re
import time
from typing import Any

import pytest
from rich.console import Console

from eai.cli import progress
from eai.cli.progress import (
    LONGEST_SILENCE,
    PATIENCE,
    make_scoring_progress_display,
    show_data_progress,
    show_generation_progress,
    show_run_progress,
    show_scoring_progress,
)
from processes import wait_until


@pytest.mark.parametrize("width", [60, 80, 150])
def test_a_narrow_terminal_cuts_the_title_and_no_count(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Console(file=io.StringIO(), width=width, force_terminal=True, color_system=None)
    monkeypatch.setattr(progress, "get_error_console", lambda: screen)
    title = "scoring behavior action_sequencing claude-3-5-sonnet-20240620"
    with show_scoring_progress(title, 100, quiet=False) as told:
        told(100)
    printed = screen.file.getvalue()  # type: ignore[attr-defined]
    assert "100/100" in printed
    assert "0620 " in printed
    assert (title in printed) is (width == 150)


def test_without_a_terminal_fetching_and_converting_begin_with_a_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    screen = Console(file=io.StringIO(), width=80)
    monkeypatch.setattr(progress, "get_error_console", lambda: screen)
    with show_data_progress() as report:
        report("waiting for", "another process", 0, 0)
        for done in (0, 13_500_000, 27_000_000):
            report("fetching", "tasks.zip", done, 27_000_000)
        report("converting", "tasks", 1, 342)
    assert screen.file.getvalue().splitlines() == [  # type: ignore[attr-defined]
        "waiting for another process",
        "fetching tasks.zip: 0/27 MB",
        "fetching tasks.zip: 27/27 MB",
        "converting tasks: 1/342",
    ]


class Clock:
    """A clock that a test sets."""

    seconds = 100.0

    def __call__(self) -> float:
        return self.seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """The clock of progress."""
    clock = Clock()
    monkeypatch.setattr(progress.time, "monotonic", clock)
    return clock


def make_screen(monkeypatch: pytest.MonkeyPatch, **options: Any) -> io.StringIO:
    """Return the text to which progress is printed."""
    file = io.StringIO()
    monkeypatch.setattr(progress, "get_error_console", lambda: Console(file=file, width=80, **options))
    return file


def test_without_a_terminal_lines_of_a_run_are_some_seconds_apart(
    monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    screen = make_screen(monkeypatch)
    with show_run_progress("run", quiet=False) as watch:
        assert watch is not None
        for answered, clock.seconds in ((0, 100), (10, 101), (20, 101 + PATIENCE), (30, 108), (40, 109)):
            watch(answered, 0, 40, answered * 30, "")
    assert screen.getvalue().splitlines() == [
        "run: 0/40",
        "run: 20/40, 100 tokens/s, about 6 s left",
        "run: 40/40, 133 tokens/s",
    ]


def test_without_a_terminal_a_line_tells_how_long_a_run_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "LONGEST_SILENCE", 0.01)
    screen = make_screen(monkeypatch)
    with show_run_progress("run", quiet=False) as watch:
        assert watch is not None
        watch(0, 0, 40, 0, "")
        assert wait_until(lambda: "run: 0/40, waiting 1 s\n" in screen.getvalue())
    length = len(screen.getvalue())
    time.sleep(0.1)
    assert len(screen.getvalue()) == length, "the run is over"


def test_the_time_left_counts_only_answers_of_this_run(monkeypatch: pytest.MonkeyPatch, clock: Clock) -> None:
    screen = make_screen(monkeypatch)
    with show_run_progress("run", quiet=False) as watch:
        assert watch is not None
        watch(30, 0, 342, 0, "")
        clock.seconds += 120
        watch(31, 1, 342, 12_000, "")
        clock.seconds += LONGEST_SILENCE
        watch(31, 1, 342, 12_000, "")
    assert screen.getvalue().splitlines() == [
        "run: 30/342",
        "run: 32/342, 100 tokens/s, 1 failed, about 5 h 10 min left",
        "run: 32/342, waiting 1 min, 100 tokens/s, 1 failed, about 5 h 9 min left",
    ]


@pytest.mark.parametrize("is_terminal", [False, True])
def test_the_first_failure_of_a_run_is_told_when_it_happens(
    monkeypatch: pytest.MonkeyPatch, is_terminal: bool
) -> None:
    screen = make_screen(monkeypatch, force_terminal=is_terminal, color_system=None)
    with show_run_progress("run", quiet=False) as watch:
        assert watch is not None
        watch(1, 0, 342, 0, "")
        watch(1, 1, 342, 0, "RateLimitError: [slow down]")
        assert "run: the first failure: RateLimitError: [slow down]\n" in screen.getvalue()
        watch(1, 2, 342, 0, "another")
    assert "another" not in screen.getvalue()


def test_on_a_terminal_one_line_of_a_run_changes(monkeypatch: pytest.MonkeyPatch, clock: Clock) -> None:
    screen = make_screen(monkeypatch, force_terminal=True, color_system=None)
    with show_run_progress("virtualhome action_sequencing openai-api/local/small", quiet=False) as watch:
        assert watch is not None
        watch(0, 0, 342, 0, "")
        clock.seconds += 10
        watch(2, 1, 342, 400, "")
        clock.seconds += 41
        assert wait_until(lambda: "waiting 41 s" in screen.getvalue())
    lines = [
        line for line in re.split(r"[\r\n]|\x1b\[\S*?[A-Za-z]", screen.getvalue()) if "waiting 41 s" in line
    ]
    assert lines[-1].rstrip() == (
        "…-api/local/small  3/342, waiting 41 s, 40 tokens/s, 1 failed, about 18 min left"
    )


def test_a_terminal_too_narrow_for_the_title_shows_the_progress(
    monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    screen = make_screen(monkeypatch, force_terminal=True, color_system=None)
    with show_run_progress("virtualhome action_sequencing", quiet=False) as watch:
        assert watch is not None
        watch(0, 0, 342, 0, "")
        clock.seconds += 100_000
        watch(2, 100, 342, 400_000_000, "")
        clock.seconds += 100_000
        assert wait_until(lambda: "  102/342, waiting 27 h 47 min, 4000 tokens/s" in screen.getvalue())
    assert "virtualhome  102" not in screen.getvalue()
    assert "sequencing  102" not in screen.getvalue()


def test_each_step_of_fetching_has_a_bar_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Console(file=io.StringIO(), width=80, force_terminal=True, color_system=None)
    monkeypatch.setattr(progress, "get_error_console", lambda: screen)
    with show_data_progress() as report:
        report("waiting for", "another process", 0, 0)
        report("fetching", "tasks.zip", 27_000_000, 27_000_000)
        report("converting", "tasks", 1, 342)
    printed = screen.file.getvalue()  # type: ignore[attr-defined]
    titles = ("waiting for another process", "fetching tasks.zip", "converting tasks")
    assert [title for title in titles if title not in printed] == []
    assert "27/27" in printed
    assert "1/342" in printed


def test_without_a_terminal_lines_show_what_is_made_and_refused_and_how_fast(
    monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    screen = make_screen(monkeypatch)
    with show_generation_progress("generating behavior", 40, quiet=False) as report:
        for made, refused, clock.seconds in (
            (0, 3, 101),
            (2, 8, 110),
            (2, 9, 169),
            (2, 90, 170),
            (3, 90, 171),
        ):
            report(made, refused)
    assert screen.getvalue().splitlines() == [
        "generating behavior: 2/40, 8 refused, 0.2/s, about 3 min left",
        "generating behavior: 2/40, 90 refused, 0.0/s, about 22 min left",
    ]
    with show_generation_progress("generating behavior", 40, quiet=True) as report:
        report(40, 0)
    assert screen.getvalue().count("\n") == 2


@pytest.mark.parametrize("width", [80, 150])
def test_a_terminal_shows_what_is_made_and_refused(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    screen = io.StringIO()
    console = Console(file=screen, width=width, force_terminal=True, color_system=None)
    monkeypatch.setattr(progress, "get_error_console", lambda: console)
    with show_generation_progress("generating behavior-1k-challenge-2025", 1000, quiet=False) as report:
        report(1, 0)
        report(1000, 12_345)
    assert "1000/1000" in screen.getvalue()
    assert "12345 refused" in screen.getvalue()


def test_without_a_terminal_the_first_hundred_answers_give_the_time_for_all_files(
    monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    screen = make_screen(monkeypatch)
    show_file = make_scoring_progress_display(30_000, 0, quiet=False)
    for title, seconds in (("scoring a", 40), ("scoring b", 20)):
        with show_file(title) as add_answers:
            for _ in range(60):
                clock.seconds += seconds / 60
                add_answers(1)
    assert screen.getvalue().splitlines() == [
        "scoring a: 8/30000, about 5 h 33 min left",
        "scoring b: 100/30000, about 4 h 26 min left",
    ]


def test_kept_answers_take_no_time(monkeypatch: pytest.MonkeyPatch, clock: Clock) -> None:
    screen = make_screen(monkeypatch)
    with make_scoring_progress_display(342, 200, quiet=False)("scoring") as add_answers:
        clock.seconds += 10
        add_answers(2)
    assert screen.getvalue() == "scoring: 202/342, about 12 min left\n"


def test_a_terminal_shows_the_time_left_for_all_files(monkeypatch: pytest.MonkeyPatch, clock: Clock) -> None:
    screen = make_screen(monkeypatch, force_terminal=True, color_system=None)
    show_file = make_scoring_progress_display(300, 0, quiet=False)
    for title in ("scoring behavior goal_interpretation m", "scoring behavior action_sequencing m"):
        with show_file(title) as add_answers:
            clock.seconds += 50
            add_answers(100)
    printed = screen.getvalue()
    assert [words for words in ("100/300", "0:01:40", "200/300", "0:00:50") if words not in printed] == []
    assert all(len(line.rstrip()) <= 80 for line in re.split(r"[\r\n]|\x1b\[\S*?[A-Za-z]", printed))


def test_json_shows_no_progress_of_scoring(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = make_screen(monkeypatch, force_terminal=True)
    with make_scoring_progress_display(1, 0, quiet=True)("scoring") as add_answers:
        add_answers(1)
    assert screen.getvalue() == ""
