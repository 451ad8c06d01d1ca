from __future__ import annotations

import io

import pytest
from rich.console import Console

from eai.cli.progress import scoring_progress


@pytest.mark.parametrize("width", [60, 80, 150])
def test_a_narrow_terminal_cuts_the_title_and_no_count(width: int) -> None:
    screen = Console(file=io.StringIO(), width=width, force_terminal=True, color_system=None)
    title = "scoring behavior action_sequencing claude-3-5-sonnet-20240620"
    with scoring_progress(title, 100, quiet=False, console=screen) as told:
        told(100)
    printed = screen.file.getvalue()  # type: ignore[attr-defined]
    assert "100/100" in printed
    assert "0620 " in printed
    assert (title in printed) is (width == 150)
