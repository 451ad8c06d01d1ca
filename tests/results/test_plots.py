"""Plots: their files, sizes and labels."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from eai.results.plots import PAGE, draw_rate_matrix, draw_rates_by_name
from eai.results.table import Cell, Estimate
from eai.studies.cofactors.study import draw_feature_effects
from eai.studies.errors import study as plot_leaves

pytest.importorskip("matplotlib")

DRAWN = """
import sys
from pathlib import Path
from matplotlib.figure import Figure
from eai.results.plots import use_plot_style, write_figure
with use_plot_style():
    figure = Figure(figsize=(3, 2), layout="constrained")
    panel = figure.subplots()
    panel.set_title("difficult offices: first flight")
    panel.plot([1, 2], [3, 4])
    print(*(path.name for path in write_figure(figure, Path(sys.argv[1]) / "figure.of.2")))
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


def test_a_pdf_embeds_only_one_font(tmp_path: Path) -> None:
    """Ligatures are glyphs of a second font, and a text search misses them."""
    assert drawn(tmp_path)[2].count(b"/FontFile2") == 1


pytest.importorskip("matplotlib")

LEAVES = ("success", "missing_step", "affordance")


def row(model: str, leaf: str, estimate: Estimate) -> Mapping[str, Cell]:
    return {"model": model, "leaf": leaf, "rate": estimate}


def matrix(models: int, leaves: int) -> list[Mapping[str, Cell]]:
    half = Estimate(50.0, 40.0, 60.0, 5, 10)
    return [row(f"m{m}", f"leaf {leaf}", half) for m in range(models) for leaf in range(leaves)]


@pytest.mark.parametrize(
    ("models", "leaves", "below"), [(2, 3, "leaf 0"), (18, 11, "m0"), (18, 30, "leaf 0"), (40, 30, "m0")]
)
def test_a_matrix_of_many_models_fits_a_page(models: int, leaves: int, below: str) -> None:
    figure = draw_rate_matrix(matrix(models, leaves), ("leaf",), "rate", "percent")
    assert figure is not None
    assert figure.get_figwidth() <= PAGE
    (panel,) = figure.axes
    labels = [text.get_text() for text in panel.get_yticklabels()]
    assert labels[0] == below
    assert len(panel.get_xticklabels()) * len(labels) == len(figure.texts) - 1 == models * (leaves + 1)


@pytest.mark.parametrize(("cases", "told"), [((10, 10), ["10", "2,745"]), ((10, 9), [])])
def test_a_matrix_ends_with_the_number_of_cases_if_all_rates_share_it(
    cases: tuple[int, int], told: list[str]
) -> None:
    of_first = [row("a", leaf, Estimate(50.0, None, None, 5, n)) for leaf, n in zip("xy", cases, strict=True)]
    of_second = [row("b", leaf, Estimate(20.0, None, None, 549, 2745)) for leaf in "xy"]
    figure = draw_rate_matrix([*of_first, *of_second], ("leaf",), "rate", "percent of answers")
    assert figure is not None
    assert figure.get_suptitle() == "percent of answers"
    (panel,) = figure.axes
    assert [text.get_text() for text in figure.texts[1:]][4:] == told
    assert [text.get_text() for text in panel.get_yticklabels()][2:] == (["n"] if told else [])


def test_plots_of_effects_and_leaves_show_numbers_of_answers() -> None:
    effect = {"feature": "objects", "alone": Estimate(1.0), "together": Estimate(2.0)}
    figure = draw_feature_effects([{**effect, "answers": 2700, "names": 100}])
    assert figure is not None
    assert figure.axes[0].get_xlabel().splitlines()[-1] == "2,700 answers to tasks of 100 names"
    leaf = {"stage": "success", "kind": "", "detail": "", "answers": Estimate(40.0, 30.0, 50.0, 360, 900)}
    figure = plot_leaves.draw_answer_outcomes([{"model": "m", **leaf}])
    assert figure is not None
    assert figure.axes[0].get_title() == "m, percent of 900 answers"


def test_a_number_stands_in_the_row_of_its_name_and_the_column_of_its_model() -> None:
    cells = [row(m, leaf, Estimate(float(10 * x + y + 1), None, None, 1, 9))
             for x, m in enumerate("abcd") for y, leaf in enumerate(LEAVES)]  # fmt: skip
    figure = draw_rate_matrix(cells, ("leaf",), "rate", "percent")
    assert figure is not None
    found = {text.get_position(): text.get_text() for text in figure.texts}
    assert found[2, 3] == "33"  # the model d, affordance
    assert found[0, 1] == "11"


@pytest.mark.parametrize(("rate", "text"), [(0.2, "<1"), (0.5, "<1"), (0.6, "1"), (1.5, "2"), (0.0, "0")])
def test_a_small_rate_is_never_written_as_zero(rate: float, text: str) -> None:
    cells = [row("a", "x", Estimate(rate, None, None, 1, 200))]
    figure = draw_rate_matrix(cells, ("leaf",), "rate", "percent", shows_zero_rates=True)
    assert figure is not None
    assert text in [shown.get_text() for shown in figure.texts]


def test_a_name_without_cases_has_no_line() -> None:
    known = [row("m", "on", Estimate(80.0, 60, 90, 8, 10)), row("m", "off", Estimate(25.0, 9, 50, 1, 4))]
    nothing = row("m", "between", Estimate(None, None, None, 0, 0))
    figure = draw_rates_by_name([*known, nothing], "leaf", "rate", "recall")
    assert figure is not None
    labels = [text.get_text().split() for text in figure.axes[0].get_yticklabels()]
    assert labels == [["on", "10"], ["off", "4"]]
    assert draw_rates_by_name([nothing], "leaf", "rate", "recall") is None


def test_a_long_name_is_wrapped_and_not_cut() -> None:
    check = "there_is_no_soaked_cleaning_tool_detergent_or_running_sink_for"
    rows = [row("m", check, Estimate(80.0, 60, 90, 8, 10)), row("m", "closed", Estimate(20.0, 9, 50, 2, 10))]
    figure = draw_rates_by_name(rows, "leaf", "rate", "share")
    assert figure is not None
    (panel,) = figure.axes
    first, second = (text.get_text() for text in panel.get_yticklabels())
    assert " ".join(first.split()) == f"{check.replace('_', ' ')} 8"
    assert all(len(line) <= 35 for line in first.splitlines())
    high, low = panel.get_yticks()
    assert low - high > 1  # a name of several lines has the room of several
    assert second.split() == ["closed", "2"]
