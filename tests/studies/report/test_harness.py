"""One model in two harnesses: a column of tables, and two runs to compare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from agents.switches import SWITCHES, WON
from eai.abilities.experiment import Experiment
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING, REACT, TEXT, AgentSetting
from eai.benchmarks.suite import open_suite
from eai.cli.table import print_results
from eai.results.batch import score_run
from eai.results.options import ScoringOptions
from eai.results.record import Record
from eai.results.responses import Response, ResponseFile
from eai.results.runs import read_runs
from eai.results.table import TextCell
from eai.results.totals import RunTotals
from eai.studies.report.rankings import make_rankings
from eai.studies.report.run_summary import select_runs_with_standard_rules_and_no_study, summarize_run
from processes import eai
from record_files import write_records

SUITE = open_suite(SWITCHES, ACTING)


def records(harness: str, commands: Sequence[str]) -> list[Record]:
    """The records of a model that has no answer to the second task."""
    play = EpisodeFactory(SWITCHES, AgentSetting(harness=harness)).begin_episode(SUITE.tasks["both"])
    for command in commands:
        play.play_command(command)
    answers = ResponseFile("model", (Response("both", play.write_as_json_text("stopped")),))
    return score_run(SUITE, answers, {"greet": "it crashed"}, ScoringOptions())


@pytest.fixture
def folders(tmp_path: Path) -> list[Path]:
    """The records of both."""
    for harness, commands in ((REACT, [*WON, "DONE"]), (TEXT, ["DONE"])):
        write_records(tmp_path / harness / "records.jsonl", records(harness, commands))
    return [tmp_path / harness for harness in (REACT, TEXT)]


def test_a_task_without_an_answer_belongs_to_the_harness_of_its_run() -> None:
    assert [record.experiment for record in records(TEXT, ["DONE"])] == [
        Experiment(harness="text"),
        Experiment(harness="text"),
    ]


def test_tables_show_the_harness_and_effort_of_a_model(folders: Sequence[Path]) -> None:
    runs = [summarize_run(run) for run in read_runs(folders)]
    (table,) = make_rankings(select_runs_with_standard_rules_and_no_study(runs), with_paper=False)
    headings = [column.name for column in table.make_table().columns][:4]
    assert headings == ["rank", "model", "harness", "answered"]
    rows = [(row[1].text, row[2]) for row in table.make_table().rows if isinstance(row[1], TextCell)]
    assert rows == [("model", "react"), ("model", "text")]
    tried = replace(runs[0], key=runs[0].key._replace(experiment=Experiment(harness="react", effort="high")))
    (both,) = make_rankings([*runs, tried], with_paper=False)
    assert [column.name for column in both.make_table().columns][:5] == [*headings[:3], "effort", "answered"]


def test_two_harnesses_of_a_model_are_compared(folders: Sequence[Path]) -> None:
    done = eai("compare", *folders)
    assert done.status == 0, done.err
    assert "A model, harness-react" in done.out
    assert "B model, harness-text" in done.out
    assert "success only in model, harness-react (1): both" in done.out


def test_the_terminal_shows_the_harness(capsys: pytest.CaptureFixture[str]) -> None:
    found = {harness: RunTotals.from_records(records(harness, ["DONE"])) for harness in (REACT, TEXT)}
    print_results(found, wide=True)
    printed = capsys.readouterr().out
    assert "react, react" in printed
    assert "within" in printed
    assert "1.5x" in printed
    print_results({"model": found["react"]}, wide=False)
    printed = capsys.readouterr().out
    assert "switches, acting, protocol strict: model, react, 1/5 answered" in printed
    assert "within 1.5x" in printed
