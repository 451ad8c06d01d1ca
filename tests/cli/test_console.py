"""What is said in lines: whole where it is piped, and between words on a terminal."""

from __future__ import annotations

from io import StringIO

import pytest
from rich.console import Console
from rich.text import Text

from eai.cli import console

PATH = "runs/virtualhome/action_sequencing/eai_noisy"
LINE = f"100 answers, 9 failed; [records] in {PATH}\n  and more"


@pytest.mark.parametrize(
    ("terminal", "lines"),
    [
        (False, LINE.splitlines()),
        (True, ["100 answers, 9 failed;", "[records] in", PATH, "  and more"]),
    ],
    ids=["piped", "terminal"],
)
def test_a_line_is_broken_on_a_terminal_alone_and_never_within_a_path(
    terminal: bool, lines: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    written = StringIO()
    shown = Console(file=written, force_terminal=terminal, width=24, color_system=None)
    monkeypatch.setattr(console, "get_output_console", lambda: shown)
    console.print_result_line(LINE)
    assert [line.rstrip() for line in written.getvalue().splitlines()] == lines


@pytest.mark.parametrize("stream", ["get_output_console", "get_error_console"])
def test_no_text_controls_the_terminal_and_none_is_markup(
    stream: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    shown = getattr(console, stream)()
    shown.print("[/red] \x1b[2J", Text("\x9b31m", style="bold"), highlight=False)
    assert "".join(capsys.readouterr()) == "[/red] \\x1b[2J \\x9b31m\n"


@pytest.mark.parametrize(
    ("terminal", "shown"), [(False, "| a | b |\n|---|---|\n| **c** | `d` |\n"), (True, "c d")]
)
def test_markdown_stands_as_it_is_where_it_is_piped_and_is_set_on_a_terminal(
    terminal: bool, shown: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    written = StringIO()
    screen = Console(file=written, force_terminal=terminal, width=24, color_system=None)
    monkeypatch.setattr(console, "get_output_console", lambda: screen)
    console.print_markdown("| a | b |\n|---|---|\n| **c** | `d` |")
    printed = capsys.readouterr().out + written.getvalue()
    assert shown in (" ".join(printed.split()) if terminal else printed)
