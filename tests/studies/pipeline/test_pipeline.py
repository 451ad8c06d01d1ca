"""Tables of pipelines, on made-up runs and on the paper's own answers."""

from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.verdict import ConfusionCounts
from eai.results.record import Record
from eai.results.table import Cell, Estimate, Table
from eai.studies.pipeline.analysis import (
    _classify_correctness_of_stated_goals,
    _RunsWithTrueAndInterpretedGoals,
    merge_run_pairs,
)
from experiments import experiment
from studies.report.samples import RIGHT, WRONG, action_run

COUNTS = (ConfusionCounts(2, 0, 0), ConfusionCounts(2, 1, 0), ConfusionCounts(1, 1, 1), None)


def piped(plain: list[Record]) -> list[Record]:
    """Return four tasks: solved with right goals, with others too, with one missing, without stage 1."""
    made = []
    for number, record in enumerate(plain):
        counts = COUNTS[number % 4]
        verdict = record.verdict if record.verdict.excluded else RIGHT if number % 4 == 0 else WRONG
        stated = {"goal_counts": counts, "stage_1_unknown": ["sofaa"] * (number % 4 == 1)}
        varied = replace(record, verdict=verdict, experiment=experiment(goals_from="first"))
        made.append(varied if counts is None else replace(varied, summaries={"pipeline": stated}))
    return made


def of(model: str = "first") -> _RunsWithTrueAndInterpretedGoals:
    plain = action_run(model)
    return _RunsWithTrueAndInterpretedGoals(plain, piped(plain), {}, {}, {})


def column(table: Table, name: str) -> dict[Cell, Cell]:
    place = table.column_names.index(name)
    return {row[0]: row[place] for row in table.rows}


def counts(table: Table, name: str) -> dict[Cell, object]:
    return {
        key: cell.numerator if isinstance(cell, Estimate) else cell
        for key, cell in column(table, name).items()
    }


def test_tasks_of_a_pipeline_are_grouped_by_the_rightness_of_stated_goals() -> None:
    _, goals, stage_1 = of().make_tables()
    assert counts(goals, "tasks") == {
        "exactly right": 3,
        "all, and others": 3,
        "some missing": 3,
        "no answer": 2,
        "all": 11,
    }
    solved = {"exactly right": 1, "all, and others": 1, "some missing": 1, "no answer": 1, "all": 4}
    assert counts(goals, "modular") == solved
    assert counts(goals, "pipeline") == {**dict.fromkeys(solved, 0), "exactly right": 3, "all": 3}
    assert counts(goals, "only modular") == {**solved, "exactly right": 0, "all": 3}
    assert counts(goals, "only pipeline") == {**dict.fromkeys(solved, 0), "exactly right": 2, "all": 2}
    assert "perfect stage 2" not in goals.column_names
    assert counts(stage_1, "tasks") == {
        "no answer": 2,
        "unreadable, so that no goals were stated": 0,
        "names what does not exist": 3,
        "has ill-formed entries": 0,
    }


def test_modular_and_pipeline_rates_have_intervals_and_the_papers_figures() -> None:
    plain = action_run()
    stages, *_ = _RunsWithTrueAndInterpretedGoals(
        plain, piped(plain), {}, {}, {"task_success": (50.0, 40.0)}
    ).make_tables()
    row = next(row for row in stages.rows if row[0] == "task_success")
    _, modular, pipeline, difference, p_value, *paper = row
    assert isinstance(modular, Estimate)
    assert isinstance(pipeline, Estimate)
    assert isinstance(difference, Estimate)
    assert (modular.numerator, pipeline.numerator, modular.denominator) == (4, 3, 11)
    assert difference.value == pytest.approx(-100 / 11)
    assert difference.low is not None
    assert difference.low < -100 / 11
    assert isinstance(p_value, float)
    assert paper == [50.0, 40.0]


def test_tables_show_a_perfect_second_stage_and_the_missing_conditions() -> None:
    plain = action_run()
    asked = [("ON", False), ("not OPEN", True), ("INSIDE", True)]
    *_, goals, _, missed = _RunsWithTrueAndInterpretedGoals(
        plain, piped(plain), {"0_1": True, "1_1": True}, {"0_1": asked}, {}
    ).make_tables()
    assert counts(goals, "perfect stage 2") == {
        "exactly right": 1,
        "all, and others": 1,
        "some missing": 0,
        "no answer": 0,
        "all": 2,
    }
    assert counts(missed, "missing") == {"INSIDE": 1, "not OPEN": 1, "ON": 0}
    assert counts(missed, "tasks") == {"INSIDE": 1, "not OPEN": 1, "ON": 0}
    assert counts(missed, "pipeline solves") == {"INSIDE": 1, "not OPEN": 1, "ON": 0}


@pytest.mark.parametrize("models", [("first", "second"), ("first", "first")])
def test_pooled_pipelines_count_each_answer_as_a_task(models: tuple[str, str]) -> None:
    """The rows add up, also those of one model with goals of two."""
    both = [of(model) for model in models]
    _, together, _ = merge_run_pairs(both).make_tables()
    apart = [counts(each.make_tables()[1], "pipeline") for each in both]
    assert counts(together, "pipeline") == {key: apart[0][key] + apart[1][key] for key in apart[0]}  # type: ignore[operator]
    assert counts(together, "tasks")["all"] == 22


@pytest.mark.parametrize(
    ("counts", "kind"),
    [
        (ConfusionCounts(3, 0, 0), "exactly right"),
        (ConfusionCounts(3, 2, 0), "all, and others"),
        (ConfusionCounts(3, 2, 1), "some missing"),
    ],
)
def test_stated_goals_are_counted_as_right_wrong_and_missed(counts: ConfusionCounts, kind: str) -> None:
    record = replace(action_run("m")[0], summaries={"pipeline": {"goal_counts": counts}})
    assert _classify_correctness_of_stated_goals(record) == kind


def test_tasks_without_an_answer_to_the_first_stage_count_as_failed() -> None:
    """They are all unanswered, but the run has other answers, so their success is 0 of 2."""
    plain = action_run()
    unasked = [
        record if record.summaries else replace(record, unanswered="no goals") for record in piped(plain)
    ]
    _, goals, _ = _RunsWithTrueAndInterpretedGoals(plain, unasked, {}, {}, {}).make_tables()
    assert column(goals, "pipeline")["no answer"] == Estimate(0.0, 0.0, pytest.approx(97.9, abs=0.1), 0, 2)
    difference = column(goals, "difference")["no answer"]
    assert isinstance(difference, Estimate)
    assert difference.value == -50


def test_a_pipeline_without_answers_has_counts_but_no_rates() -> None:
    plain = action_run()
    unasked = [replace(record, unanswered="no goals", summaries={}) for record in piped(plain)]
    _, goals, stage_1 = _RunsWithTrueAndInterpretedGoals(plain, unasked, {}, {}, {}).make_tables()
    assert counts(goals, "tasks") == {"no answer": 11, "all": 11}
    assert counts(stage_1, "tasks")["no answer"] == 11
    assert column(stage_1, "pipeline")["no answer"] == Estimate(None, numerator=0, denominator=0)
