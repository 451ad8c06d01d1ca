"""A model on one page."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from eai.abilities.protocol import Protocol
from eai.cli import app
from eai.results.plots import PAGE
from eai.results.runs import read_runs
from eai.studies.report import plot_summary
from eai.studies.report.rankings import Ranking, make_rankings
from eai.studies.report.run_summary import summarize_run
from studies.report.samples import action_run, all_runs, write_runs

pytest.importorskip("matplotlib")


def tables(folder: Path, *, with_paper: bool) -> list[Ranking]:
    runs = [summarize_run(run) for run in read_runs([write_runs(folder, all_runs())])]
    runs.sort(key=lambda item: item.key.sort_key)
    return make_rankings(runs, with_paper=with_paper)


@pytest.mark.parametrize(
    ("protocol", "with_paper", "told"),
    [
        (Protocol.STRICT, False, None),
        (Protocol.STRICT, True, "published answers of the paper's models (18)"),
        (Protocol("eai-1.0.5"), True, "the paper's models, as it prints them (18)"),
    ],
)
def test_a_summary_page_has_each_number_of_the_model_and_a_legend(
    protocol: Protocol, with_paper: bool, told: str | None, tmp_path: Path
) -> None:
    found = tables(tmp_path, with_paper=with_paper)
    assert ("first", protocol) in plot_summary.list_models_and_protocols(found)
    figure = plot_summary.draw_model_summary(found, "first", protocol)
    assert figure is not None
    assert (figure.get_figwidth(), figure.get_suptitle()) == (PAGE, f"first, protocol {protocol.value}")
    texts = {text.get_text() for panel in figure.axes for text in panel.texts}
    row = next(
        row
        for table in found
        for row in table.rows
        if (table.name, table.protocol, row.model) == ("action_sequencing_trajectory", protocol, "first")
    )
    assert {f"{cell.value:.1f}" for cell in [*row.scores.values()][2:] if cell.value is not None} <= texts
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert [name for name in names if name.startswith("VirtualHome, ")] == names[:1]
    assert names[1:][-1:] == ([] if told is None else [told])


def test_a_model_without_numbers_has_no_summary_page(tmp_path: Path) -> None:
    assert (
        plot_summary.draw_model_summary(tables(tmp_path, with_paper=True), "GPT-4o", Protocol("eai-1.0.5"))
        is None
    )


def test_a_report_draws_summary_pages_on_request(tmp_path: Path) -> None:
    records = write_runs(tmp_path / "runs", [action_run("a/first")])
    command = ["report", str(records), "--out", str(tmp_path / "out"), "--no-prompts", "--summary"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "out" / "plots" / "summary-a_first-strict.svg").is_file()
    assert "plots/summary-a_first-strict.svg" in (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
