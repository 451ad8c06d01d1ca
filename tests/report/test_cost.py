"""The cost of answers, in a report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from typer.testing import CliRunner

from eai.abilities.record import Origin, Record, Usage
from eai.cli import app
from report.samples import action_run, write_runs

RUNNER = CliRunner(env={"COLUMNS": "100"})
PRICES = """\
date = 2026-11-01
source = "a page"
models."maker/second" = { input = 2, output = 10 }
"""


def asked(model: str, usage: Usage, protocol: str = "strict") -> list[Record]:
    origin = Origin(usage=usage)
    return [replace(each, origin=origin, model=model) for each in action_run("first", protocol)]


def written(folder: Path, *runs: list[Record], **options: str) -> tuple[str, Path]:
    out = folder / "out"
    words = [word for name, value in options.items() for word in (f"--{name}", value)]
    records = write_runs(folder / "runs", runs)
    command = ["report", str(records), "--out", str(out), "--no-prompts", "--no-plots", "--paper", *words]
    result = RUNNER.invoke(app, command)
    assert result.exit_code == 0, result.output
    return (out / "report.md").read_text(encoding="utf-8").partition("## What the answers cost")[2], out


def test_runs_are_priced_as_they_were_asked_or_by_a_list_and_paid_for_once(tmp_path: Path) -> None:
    prices = tmp_path / "prices.toml"
    prices.write_text(PRICES)
    own = asked("first", Usage(1000, 100, 50, 0.25))
    again = asked("first", Usage(1000, 100, 50, 0.25), "eai-1.0.5")
    listed = asked("maker_second", Usage(1000, 100))
    unknown = asked("third", Usage(500, 50))
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


def test_answers_that_do_not_say_what_they_took_have_no_section(tmp_path: Path) -> None:
    section, out = written(tmp_path, action_run("first"))
    assert section == ""
    assert not (out / "cost.csv").exists()
