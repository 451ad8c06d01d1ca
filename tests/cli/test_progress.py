from __future__ import annotations

import io

import pytest
from rich.console import Console

from eai.cli import progress
from eai.cli.progress import PATIENCE, data_progress, run_progress, scoring_progress


@pytest.mark.parametrize("width", [60, 80, 150])
def test_a_narrow_terminal_cuts_the_title_and_no_count(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Console(file=io.StringIO(), width=width, force_terminal=True, color_system=None)
    monkeypatch.setattr(progress, "errors", lambda: screen)
    title = "scoring behavior action_sequencing claude-3-5-sonnet-20240620"
    with scoring_progress(title, 100, quiet=False) as told:
        told(100)
    printed = screen.file.getvalue()  # type: ignore[attr-defined]
    assert "100/100" in printed
    assert "0620 " in printed
    assert (title in printed) is (width == 150)


def test_without_a_terminal_fetching_and_converting_begin_with_a_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    screen = Console(file=io.StringIO(), width=80)
    monkeypatch.setattr(progress, "errors", lambda: screen)
    with data_progress() as report:
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


def test_without_a_terminal_lines_are_some_seconds_apart(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    times = iter([0.0, 0, 1, PATIENCE, PATIENCE + 1, PATIENCE + 2])  # its beginning, then each answer
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(times))
    screen = Console(file=io.StringIO(), width=80)
    monkeypatch.setattr(progress, "errors", lambda: screen)
    with run_progress("run", quiet=False) as watch:
        assert watch is not None
        for answered in (0, 10, 20, 30, 40):
            watch(answered, 0, 40)
    shown = screen.file.getvalue().splitlines()  # type: ignore[attr-defined]
    assert shown == ["run: 0/40", "run: 20/40", "run: 40/40"]


def test_each_step_of_fetching_has_a_bar_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Console(file=io.StringIO(), width=80, force_terminal=True, color_system=None)
    monkeypatch.setattr(progress, "errors", lambda: screen)
    with data_progress() as report:
        report("waiting for", "another process", 0, 0)
        report("fetching", "tasks.zip", 27_000_000, 27_000_000)
        report("converting", "tasks", 1, 342)
    printed = screen.file.getvalue()  # type: ignore[attr-defined]
    titles = ("waiting for another process", "fetching tasks.zip", "converting tasks")
    assert [title for title in titles if title not in printed] == []
    assert "27/27" in printed
    assert "1/342" in printed
