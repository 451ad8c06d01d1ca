from __future__ import annotations

import csv
import io
import json
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from eai.abilities.verdict import PlanVerdict
from eai.cli import app
from eai.results.latex import escape_latex as latex_escaped
from studies.report.samples import HOSTILE, action_run, all_runs, write_runs
from sweeps import sweep

RUNNER = CliRunner()
TABLE_FILES = ("report.md", "report.tex", "tables.tex", "tables.json", "tables.csv", "explorer.html")


def write_report(folder: Path, runs: Path, *options: str) -> Path:
    result = RUNNER.invoke(app, ["report", str(runs), "--out", str(folder), "--no-prompts", *options])
    assert result.exit_code == 0, result.output
    return folder


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    return write_runs(tmp_path / "runs", all_runs())


def test_equal_records_give_equal_reports(tmp_path: Path, runs: Path) -> None:
    one = write_report(tmp_path / "one", runs, "--paper", "--no-plots")
    other = write_report(tmp_path / "other", runs, "--paper", "--no-plots")
    assert sorted(path.name for path in one.iterdir()) == sorted(TABLE_FILES)
    for name in TABLE_FILES:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name


def test_csv_and_json_have_the_same_numbers(tmp_path: Path, runs: Path) -> None:
    folder = write_report(tmp_path / "out", runs, "--paper", "--no-plots")
    lines = list(csv.DictReader(io.StringIO((folder / "tables.csv").read_text(encoding="utf-8"))))
    tables = json.loads((folder / "tables.json").read_text(encoding="utf-8"))["tables"]
    cells = [c for t in tables for row in t["rows"] for c in row["cells"] if c["percent"] is not None]
    assert [float(line["percent"]) for line in lines] == [cell["percent"] for cell in cells]
    strict = next(line for line in lines if line["metric"] == "task_success" and line["model"] == "first")
    assert (strict["numerator"], strict["denominator"]) == ("4", "11")
    assert float(strict["low"]) < float(strict["percent"]) < float(strict["high"])


def test_csv_has_its_header_even_without_numbers(tmp_path: Path, runs: Path) -> None:
    left_out = PlanVerdict(excluded="left out")
    excluded = [replace(record, verdict=left_out, explanation=None) for record in action_run()]
    alone = write_report(tmp_path / "out", write_runs(tmp_path / "excluded", [excluded]), "--no-plots")
    header = (write_report(tmp_path / "other", runs, "--no-plots") / "tables.csv").read_text().splitlines()[0]
    assert (alone / "tables.csv").read_text(encoding="utf-8") == f"{header}\n"
    assert header.startswith("table,protocol,domain,model,source,rank,ability,metric,percent,numerator,")


def test_markdown_has_success_by_length_of_plan_and_goals_by_predicate(tmp_path: Path) -> None:
    runs = write_runs(tmp_path / "runs", [action_run(), action_run("second")])
    page = (write_report(tmp_path / "out", runs, "--no-plots") / "report.md").read_text(encoding="utf-8")
    lines = page.partition("## By length of plan and kind of goal: VirtualHome")[2].splitlines()
    assert [line for line in lines if line.startswith(("| tasks or", "| plan of"))] == [
        "| tasks or goals | first | second |",
        "| plan of 1 to 3 steps | 100.0 (1/1) | 0.0 (0/1) |",
        "| plan of 4 to 8 steps | 0.0 (0/2) | 50.0 (1/2) |",
        "| plan of 9 to 16 steps | 50.0 (2/4) | 25.0 (1/4) |",
        "| plan of 17 to 32 steps | 25.0 (1/4) | 50.0 (2/4) |",
    ]
    assert [line for line in lines if line.startswith("| goals on")]


def test_markdown_has_both_protocols_outcomes_and_exclusions(tmp_path: Path, runs: Path) -> None:
    page = (write_report(tmp_path / "out", runs, "--no-plots") / "report.md").read_text(encoding="utf-8")
    for words in ("## Both protocols", "## Outcomes of answers", "protocol eai-1.0.5", "drops this task"):
        assert words in page
    assert "(paper)" not in page


def test_the_papers_other_tables_are_in_each_file(tmp_path: Path, runs: Path) -> None:
    folder = write_report(tmp_path / "out", runs, "--paper", "--no-plots")
    page = (folder / "report.md").read_text(encoding="utf-8")
    assert page.count("## What the paper reports besides") == 1
    for name in ("report.md", "tables.tex", "tables.json", "tables.csv"):
        assert "Human Annotation" in (folder / name).read_text(encoding="utf-8"), name
    alone = write_report(tmp_path / "alone", runs, "--no-plots")
    assert "besides" not in (alone / "report.md").read_text(encoding="utf-8")
    assert "paper_human" not in (alone / "tables.csv").read_text(encoding="utf-8")


def test_every_row_of_a_table_has_as_many_cells_as_its_heading(tmp_path: Path, runs: Path) -> None:
    page = (write_report(tmp_path / "out", runs, "--paper", "--no-plots") / "report.md").read_text("utf-8")
    tables = [block.splitlines() for block in page.split("\n\n") if block.startswith("| ")]
    assert len(tables) > 10
    for table in tables:
        assert len({line.count(" | ") for line in table}) == 1, table[0]


def test_markup_in_names_stays_text(tmp_path: Path) -> None:
    hostile = HOSTILE.replace("\ud800", "")
    records = [replace(item, model=hostile) for item in action_run()]
    folder = write_report(tmp_path / "out", write_runs(tmp_path / "runs", [records]))
    page = (folder / "report.md").read_text(encoding="utf-8")
    assert "<script>" not in page.replace("\\<script\\>", "")
    assert "\\end{table} |" not in (folder / "tables.tex").read_text(encoding="utf-8")
    assert "\\textbackslash{}end\\{table\\}" in (folder / "tables.tex").read_text(encoding="utf-8")


def test_latex_escapes_special_characters() -> None:
    assert latex_escaped("50 % & _x_ \\ 猫") == r"50 \% \& \_x\_ \textbackslash{} ?"


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no pdflatex on this machine")
def test_latex_compiles(tmp_path: Path, runs: Path) -> None:
    folder = write_report(tmp_path / "out", runs, "--paper", "--no-plots")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "report.tex"]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout[-2000:]
    assert (folder / "report.pdf").stat().st_size > 10_000


def test_latex_is_balanced(tmp_path: Path, runs: Path) -> None:
    text = (write_report(tmp_path / "out", runs, "--paper", "--no-plots") / "tables.tex").read_text("utf-8")
    for rule in ("toprule", "midrule", "bottomrule"):
        assert text.count(f"\\{rule}") == text.count("\\begin{tabular}") == text.count("\\end{tabular}")
    assert text.count("\\begin{table}") == text.count("\\end{table}") >= 7
    plain = text.replace("\\{", "").replace("\\}", "")
    assert plain.count("{") == plain.count("}")


def test_latex_shows_only_the_selected_models_and_columns(tmp_path: Path, runs: Path) -> None:
    only = ("--models", "first, GPT-4o", "--columns", "success", "--no-intervals")
    text = (write_report(tmp_path / "out", runs, "--paper", "--no-plots", *only) / "tables.tex").read_text(
        "utf-8"
    )
    assert "first &" in text
    assert "GPT-4o" in text
    assert "second &" not in text
    assert "Execution" in text
    assert "Hallucination" not in text
    assert "intervals" not in text
    assert "scriptsize" not in text
    marks = {int(n) for found in re.findall(r"textsuperscript\{([\d,]+)\}", text) for n in found.split(",")}
    assert marks == set(range(1, len(marks) + 1))
    whole = json.loads((tmp_path / "out" / "tables.json").read_text(encoding="utf-8"))
    assert {"second", "first"} <= {row["model"] for table in whole["tables"] for row in table["rows"]}


def test_latex_names_the_ranking_column_even_if_it_is_not_shown(tmp_path: Path, runs: Path) -> None:
    folder = write_report(tmp_path / "out", runs, "--no-plots", "--columns", "execution")
    text = (folder / "tables.tex").read_text("utf-8")
    (caption,) = re.findall(r"caption\{(Action sequencing, VirtualHome, protocol strict.*)\}", text)
    assert "ranked by Task;" in caption
    assert "Task &" not in text


@pytest.mark.parametrize(("option", "name"), [("--models", "fist"), ("--columns", "sucess")])
def test_an_unknown_model_or_column_is_refused_with_a_suggestion(
    tmp_path: Path, runs: Path, option: str, name: str
) -> None:
    result = RUNNER.invoke(
        app, ["report", str(runs), "--out", str(tmp_path / "out"), "--no-plots", option, name]
    )
    assert re.search(
        rf"{option}: no table has '{name}'; did you mean (first|success)\?", str(result.exception)
    )


def test_a_long_table_continues_on_the_next_page(tmp_path: Path) -> None:
    runs = write_runs(tmp_path / "runs", [action_run(f"model{number}") for number in range(30)])
    text = (write_report(tmp_path / "out", runs, "--no-plots") / "tables.tex").read_text("utf-8")
    (first, *others) = [part for part in text.split("\\begin{table}") if "caption{Action sequencing" in part]
    assert len(others) == 1
    assert "(continued)" in others[0]
    assert "(continued)" not in first
    assert sum(part.count("model") for part in (first, *others)) >= 30
    assert len(set(re.findall(r"label\{(.*?)\}", text))) == text.count("label{")


@sweep
def test_plots_are_reproducible(tmp_path: Path, runs: Path) -> None:
    pytest.importorskip("matplotlib")
    one, other = (
        write_report(tmp_path / name, runs, "--formats", "pdf,svg,png") / "plots" for name in ("one", "other")
    )
    names = sorted(path.name for path in one.iterdir())
    for kind in ("outcomes", "flow", "difficulty", "actions", "predicates"):
        assert any(name.startswith(kind) and name.endswith(".svg") for name in names), kind
    assert {Path(name).suffix for name in names} == {".svg", ".png", ".pdf"}
    for name in names:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    page = (tmp_path / "one" / "report.md").read_text(encoding="utf-8")
    assert all(f"plots/{name}" in page for name in names if name.endswith(".svg"))


def test_each_plot_is_a_file_shown_after_the_tables(tmp_path: Path, runs: Path) -> None:
    pytest.importorskip("matplotlib")
    without, folder = (
        write_report(tmp_path / name, runs, *more) for name, more in (("a", ["--no-plots"]), ("b", []))
    )
    names = [path.name for path in (folder / "plots").iterdir()]
    assert {Path(name).suffix for name in names} == {".svg"}
    tables, _, shown = (folder / "report.md").read_text("utf-8").partition("\n## Plots\n")
    assert tables == (without / "report.md").read_text("utf-8")
    assert sorted(re.findall(r"\(plots/(.+)\)", shown)) == sorted(names)


def test_an_unknown_format_is_refused_before_files_are_written(tmp_path: Path, runs: Path) -> None:
    result = RUNNER.invoke(app, ["report", str(runs), "--out", str(tmp_path / "out"), "--formats", "svg,bmp"])
    assert "--formats: expected some of svg, png, pdf, not 'svg,bmp'" in str(result.exception)
    assert not (tmp_path / "out").exists()


def test_unusable_input_gives_an_error_of_one_line(tmp_path: Path) -> None:
    result = RUNNER.invoke(app, ["report", str(tmp_path / "none"), "--out", str(tmp_path / "out")])
    assert "no such file or folder" in str(result.exception)
    assert not (tmp_path / "out").exists()


def test_without_matplotlib_a_report_lacks_only_plots(
    tmp_path: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    folder = write_report(tmp_path / "out", runs)
    assert not (folder / "plots").exists()
    assert {path.name for path in folder.iterdir()} == set(TABLE_FILES)
