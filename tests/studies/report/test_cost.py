"""The cost of answers, in a report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from typer.testing import CliRunner

from eai.abilities.attempt import AnswerUsage
from eai.cli import app
from eai.results.record import AnswerOrigin, Record
from studies.report.samples import action_run, write_runs

RUNNER = CliRunner(env={"COLUMNS": "100"})
PRICES = """\
date = 2026-11-01
source = "a page"
models."maker/second" = { input = 2, output = 10 }
"""


def asked(model: str, usage: AnswerUsage, protocol: str = "strict") -> list[Record]:
    origin = AnswerOrigin(usage=usage)
    return [replace(each, origin=origin, model=model) for each in action_run("first", protocol)]


def written(folder: Path, *runs: list[Record], **options: str) -> tuple[str, Path]:
    out = folder / "out"
    words = [word for name, value in options.items() for word in (f"--{name}", value)]
    records = write_runs(folder / "runs", runs)
    command = ["report", str(records), "--out", str(out), "--no-prompts", "--no-plots", "--paper", *words]
    result = RUNNER.invoke(app, command)
    assert result.exit_code == 0, result.output
    return (out / "report.md").read_text(encoding="utf-8").partition("## What the answers cost")[2], out


def test_answers_have_their_recorded_or_listed_price_and_count_once(tmp_path: Path) -> None:
    prices = tmp_path / "prices.toml"
    prices.write_text(PRICES)
    own = asked("first", AnswerUsage(1000, 100, 50, 0.25))
    again = asked("first", AnswerUsage(1000, 100, 50, 0.25), "eai-1.0.5")
    listed = asked("maker_second", AnswerUsage(1000, 100))
    unknown = asked("third", AnswerUsage(500, 50))
    section, out = written(tmp_path, own, again, listed, unknown, prices=str(prices))
    rows = [line for line in section.splitlines() if line.startswith("| ")][2:6]
    suite = "VirtualHome, action sequencing"
    assert rows == [
        rf"| first | {suite} | 12 | 12,000 | 1,200 | 600 | 1,100 | 3.00 | 250.00 |",
        rf"| maker\_second | {suite} | 12 | 12,000 | 1,200 |  | 1,100 | 0.04 | 3.00 |",
        rf"| third | {suite} | 12 | 6,000 | 600 |  | 550 |  |  |",
        r"| together |  | 36 | 30,000 | 3,000 | 600 | 917 | ≥ 3.04 | ≥ 84.33 |",
    ]
    assert "the prices of 2026-11-01 by a page" in section
    assert "| 84,960 | 192,280,000 in and out |  |  | 2,263 | 1,540.70 | 18.13 |" in section
    columns, *lines = (out / "cost.csv").read_text().splitlines()
    assert columns.endswith(",answers_without_price")
    assert [line.rpartition(",")[2] for line in lines] == ["0", "0", "12", "12"]


def test_the_cost_of_a_success_includes_failed_answers(tmp_path: Path) -> None:
    never = [
        replace(each, verdict=replace(each.verdict, success=False))
        for each in asked("never", AnswerUsage(9, 1))
    ]
    section, _ = written(tmp_path, asked("first", AnswerUsage(1000, 100, cost=0.25, seconds=2)), never)
    of_success = section.partition("| model | suite | tokens | dollars | seconds |")[2].splitlines()
    first, below, last = of_success[2:5]
    assert first.startswith("| first | VirtualHome, action sequencing | 3025 | 0.69 | 5.50 |")
    assert below.startswith("| *95 %* |")
    assert last == "| never | VirtualHome, action sequencing | ≥ 110 |  |  |"


def test_runs_with_several_epochs_have_a_section(tmp_path: Path) -> None:
    epochs = [asked(f"first.epoch_{number}", AnswerUsage(1, 1)) for number in (1, 2)]
    written(tmp_path, asked("first", AnswerUsage(1, 1)), *epochs)
    report = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
    section = report.partition("## Several answers to each task")[2].partition("\n## ")[0]
    rows = [line.split(" | ")[1:] for line in section.splitlines() if "| first" in line]
    share = rows[0][2]
    assert rows == [["2", "1", share, f"{share} |"], ["2", "2", share, f"{share} |"]]


def test_without_token_counts_there_is_no_section_on_cost(tmp_path: Path) -> None:
    section, out = written(tmp_path, action_run("first"))
    assert section == ""
    assert not (out / "cost.csv").exists()
