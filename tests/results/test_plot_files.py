"""Figures as files."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("matplotlib")

DRAWN = """
import sys
from pathlib import Path
from matplotlib.figure import Figure
from eai.results.plots import styled, write
with styled():
    figure = Figure(figsize=(3, 2), layout="constrained")
    panel = figure.subplots()
    panel.set_title("difficult offices: first flight")
    panel.plot([1, 2], [3, 4])
    print(*(path.name for path in write(figure, Path(sys.argv[1]) / "figure.of.2")))
"""


def drawn(folder: Path) -> list[bytes]:
    command = [sys.executable, "-c", DRAWN, str(folder)]
    names = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    assert names == ["figure.of.2.svg", "figure.of.2.png", "figure.of.2.pdf"]
    return [(folder / name).read_bytes() for name in names]


def test_a_figure_is_written_in_each_format_with_the_same_bytes_every_time(tmp_path: Path) -> None:
    svg, png, pdf = drawn(tmp_path)
    assert svg.startswith(b"<?xml")
    assert png.startswith(b"\x89PNG")
    assert pdf.startswith(b"%PDF")
    assert drawn(tmp_path) == [svg, png, pdf]


def test_a_pdf_embeds_one_font_whatever_letters_stand_beside_each_other(tmp_path: Path) -> None:
    """Joined letters are glyphs of a second font, which readers of the text do not find."""
    assert drawn(tmp_path)[2].count(b"/FontFile2") == 1
