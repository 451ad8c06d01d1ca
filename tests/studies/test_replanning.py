"""Gains of further attempts, on made-up trials with known outcomes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from abilities.test_trial import BOTH, BOX, LAMP, SHED, SUITE, TORCH, plan, scorer
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.trial import MultiAttemptTrial
from eai.base.errors import InputError
from eai.cli import app
from eai.results.epochs import _write_attempt_files
from eai.results.record import Record
from eai.results.responses import read_responses
from eai.results.summary import compute_rates_by_attempt, drop_later_attempts
from eai.results.table import Estimate
from eai.results.trials import make_trial_record
from eai.studies.records import StudyRecords
from eai.studies.replanning.study import (
    _analyze_replanning,
    _ReplanningAnalysisOptions,
    estimate_success_by_attempt,
    group_runs_by_replanning_options,
    make_remarks_on_missing_runs,
    make_replanning_tables,
)
from record_files import write_records
from studies.told import told_tables

EXPLAINED = ReplanningOptions(2, feedback="explained")
NONE = replace(EXPLAINED, feedback="none")
RIGHT, EARLY, MISSED, UNREADABLE = plan(*BOTH), plan(LAMP, TORCH), plan(SHED, BOX, TORCH), "no plan"


def run_of(options: ReplanningOptions, answers: Sequence[Sequence[str]]) -> list[Record]:
    """A run of one task under many names, each with its answers."""
    records = []
    for number, given in enumerate(answers):
        trial = MultiAttemptTrial(scorer(), options)
        for text in given:
            trial.try_answer(text)
        record = make_trial_record(SUITE, options, "m", "both", tuple(trial.attempts))
        records.append(replace(record, task_id=f"{number}", task=None))
    return records


TOLD = run_of(EXPLAINED, [[RIGHT], [EARLY, RIGHT], [EARLY, EARLY, RIGHT], [MISSED, UNREADABLE, MISSED]])
UNTOLD = run_of(NONE, [[RIGHT], [EARLY, EARLY, EARLY], [EARLY, MISSED, MISSED], [MISSED, MISSED, RIGHT]])


def numerators(estimates: Sequence[Estimate]) -> list[float | None]:
    return [estimate.numerator for estimate in estimates]


def test_the_answers_of_each_attempt_are_read_from_a_file(tmp_path: Path) -> None:
    _write_attempt_files(tmp_path, "m", TOLD)
    written = [read_responses(tmp_path / f"m_attempt_{number}_outputs.json", "0123") for number in (1, 2, 3)]
    asked = [[each.task_id for each in file.responses] for file in written]
    assert asked == [["0", "1", "2", "3"], ["1", "2", "3"], ["2", "3"]]
    assert [each.text for each in written[1].responses] == [RIGHT, EARLY, UNREADABLE]
    assert len(list(tmp_path.iterdir())) == 3


def test_success_by_the_number_of_attempts_never_falls() -> None:
    untold, told = group_runs_by_replanning_options([TOLD, UNTOLD])  # the control comes first
    assert (untold.label_of_chosen_options, told.label_of_chosen_options) == (
        "replans-2-restart-none",
        "replans-2-restart-explained",
    )
    assert numerators(estimate_success_by_attempt(told)) == [1, 2, 3]
    assert numerators(estimate_success_by_attempt(untold)) == [1, 1, 2]
    assert [each["task_success"].numerator for each in compute_rates_by_attempt(TOLD)] == [1, 2, 3]
    assert [len(drop_later_attempts(record, 2).attempts) for record in TOLD] == [1, 2, 2, 2]


def test_arms_with_feedback_are_compared_with_arms_without() -> None:
    _, worth, _ = make_replanning_tables(group_runs_by_replanning_options([TOLD, UNTOLD]))
    differences = [row[-1] for row in worth.rows]
    assert [each.value for each in differences if isinstance(each, Estimate)] == [0, 25, 25]
    assert make_remarks_on_missing_runs(group_runs_by_replanning_options([TOLD, UNTOLD])) == []
    (alone,) = make_remarks_on_missing_runs(group_runs_by_replanning_options([TOLD]))
    assert alone.startswith("No runs without feedback stand beside replans-2-restart-explained")
    assert make_replanning_tables(group_runs_by_replanning_options([TOLD]))[1].rows == ()


def test_runs_of_a_group_are_in_the_order_of_their_seeds() -> None:
    seeded = [run_of(replace(NONE, slip=0.1, slip_seed=seed), [[RIGHT]]) for seed in (10, 2, -1)]
    (group,) = group_runs_by_replanning_options(seeded)
    assert list(group.runs) == [-1, 2, 10]


def test_outcomes_are_counted_by_the_first_failure() -> None:
    *_, mended = make_replanning_tables(group_runs_by_replanning_options([TOLD, UNTOLD]))
    counts = {
        row[:2]: (row[2], row[3].numerator if isinstance(row[3], Estimate) else None, *row[4:])
        for row in mended.rows
    }
    told, untold = "replans-2-restart-explained", "replans-2-restart-none"
    assert counts == {
        (untold, "goal missed"): (1, 1, 0, 0),
        (untold, "missing step"): (2, 0, 1, 1),
        (told, "goal missed"): (1, 0, 1, 0),
        (told, "missing step"): (2, 2, 0, 0),
    }


def test_several_seeds_form_one_arm_with_tasks_as_units() -> None:
    slipping = ReplanningOptions(1, "continue", "state", slip=0.2)
    one, two = (run_of(replace(slipping, slip_seed=seed), [[plan(*BOTH)]]) for seed in (1, 2))
    (group,) = group_runs_by_replanning_options([one, two])
    assert list(group.runs) == [1, 2]
    assert len(group.list_records_up_to_attempt(1)) == 2
    assert {case.name for case in group.list_task_contributions_to_metric("task_success", 2)} == {"0"}
    assert "One seed of slips" in "".join(
        make_remarks_on_missing_runs(group_runs_by_replanning_options([one]))
    )


def test_the_command_writes_tables_notes_and_a_plot(tmp_path: Path) -> None:
    for name, records in (("told", TOLD), ("untold", UNTOLD)):
        (tmp_path / "runs" / name).mkdir(parents=True)
        virtualhome = [replace(record, domain="virtualhome") for record in records]
        write_records(tmp_path / "runs" / name / "records.jsonl", virtualhome)
    out = tmp_path / "out"
    command = ["analyze", "replanning", str(tmp_path / "runs"), "--out"]
    result = CliRunner().invoke(app, [*command, str(out)])
    assert result.exit_code == 0, result.output
    told = CliRunner().invoke(app, [*command, str(tmp_path / "again"), "--no-plots", "--json"])
    assert [row["task success"] for row in told_tables(told.stdout)["paper"]] == ["65.2", "77.4"]
    written = json.loads((out / "replanning.json").read_text(encoding="utf-8"))
    assert [row["task success"] for row in written["tables"]["paper"]["rows"]] == [65.2, 77.4]
    assert any("of protocol strict, the paper's figures are not" in each for each in written["remarks"])
    drawn = (out / "success_by_attempt.svg").read_text("utf-8")
    assert all(text in drawn for text in ("VirtualHome action sequencing, strict, m", ", n = 4"))
    assert (out / "mended.csv").exists()


def test_plain_records_are_refused_by_the_analysis_of_replanning(tmp_path: Path) -> None:
    write_records(tmp_path / "records.jsonl", [replace(TOLD[0], experiment=None)])
    with pytest.raises(InputError, match="found no records of runs with further attempts"):
        list(_analyze_replanning(StudyRecords((tmp_path,)), _ReplanningAnalysisOptions()))
