"""Tests that results mark answers that were cut off at a length limit."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from command_line import Command
from eai.abilities.declaration import get_declaration
from eai.base.store import DataPackStore
from eai.cli.console import get_output_console
from eai.cli.explain import print_record
from eai.cli.table import make_rates_table
from eai.results.record import AnswerOrigin, Record
from eai.results.terminal import print_table
from eai.results.tidy import TidyTables
from eai.results.totals import RunTotals
from eai.tasks.source import Source
from explorer_pages import read_explorer
from record_files import write_records
from studies.report.samples import action_run


def cut_run() -> list[Record]:
    """Return records: the first answer was cut off, and the second answer was not."""
    first, second, *others = action_run()
    cut = replace(first, origin=AnswerOrigin(stop_reason="max_tokens", truncated=True))
    return [cut, replace(second, origin=AnswerOrigin(stop_reason="stop", truncated=False)), *others]


def test_the_first_line_of_an_explanation_says_that_an_answer_was_cut_off(
    capsys: pytest.CaptureFixture[str],
) -> None:
    cut, whole, *_ = cut_run()
    print_record(get_output_console(), cut)
    assert capsys.readouterr().out.splitlines()[0] == "cut off: the answer ended at a length limit"
    print_record(get_output_console(), whole)
    assert "cut off" not in capsys.readouterr().out


def test_tables_count_cut_answers(capsys: pytest.CaptureFixture[str]) -> None:
    totals, whole = RunTotals.from_records(cut_run()), RunTotals.from_records(action_run())
    assert (totals.coverage.cut_off, whole.coverage.cut_off) == (1, 0)
    assert "cut_off" not in whole.coverage.to_json()
    assert "1 of" in str(replace(totals.coverage, tasks=totals.coverage.asked).remark_on_missing_answers)
    metrics = get_declaration(action_run()[0].ability).terminal_metrics
    print_table(
        get_output_console(), make_rates_table("Plans", metrics, {"one": totals, "two": whole}), wide=True
    )
    assert re.search(r"\bcut\b", capsys.readouterr().out)
    print_table(
        get_output_console(), make_rates_table("Plans", metrics, {"one": whole, "two": whole}), wide=True
    )
    assert not re.search(r"\bcut\b", capsys.readouterr().out)


def test_a_column_of_the_tidy_table_names_cut_answers() -> None:
    tables = TidyTables(Source(DataPackStore()), features=False)
    tables.add_records(cut_run())
    assert [line.cut_off for line in tables.answers][:3] == [True, False, None]


def test_a_report_has_a_column_and_the_explorer_marks_the_answer(eai: Command, tmp_path: Path) -> None:
    write_records(tmp_path / "runs" / "records.jsonl", cut_run())
    assert eai("report", tmp_path / "runs", "--out", tmp_path / "report").status == 0
    assert "| cut off |" in (tmp_path / "report" / "report.md").read_text()
    content = read_explorer((tmp_path / "report" / "explorer.html").read_text(encoding="utf-8"))
    assert [answer.get("z", 0) for answer in content["runs"][0]["answers"]].count(1) == 1
