"""A run without any answer has no rates, and every verdict says whether the answer is right."""

from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.declaration import get_declaration
from eai.abilities.verdict import Verdict
from eai.cli.table import make_rates_table
from eai.results.codec import record_to_json
from eai.results.record import Record
from eai.results.summary import make_contributions_by_metric
from eai.results.terminal import print_table
from eai.results.totals import RunTotals
from studies.report.samples import action_run, goal_run, operator_run, subgoal_run

RUNS = {"actions": action_run, "goals": goal_run, "subgoals": subgoal_run, "operators": operator_run}


def unanswered_run(name: str) -> list[Record]:
    return [
        replace(
            record,
            response="",
            unanswered="the request failed",
            verdict=record.verdict.to_verdict_on_missing_answer(),
        )
        for record in RUNS[name]()
    ]


@pytest.mark.parametrize("name", RUNS)
def test_a_run_without_answers_has_no_rates_and_no_intervals(name: str) -> None:
    records = unanswered_run(name)
    totals = RunTotals.from_records(records)
    assert {rate.percent for rate in totals.rates.values()} == {None}
    assert not any(make_contributions_by_metric(records, records[0].ability).values())
    assert set(make_contributions_by_metric(records, records[0].ability)) == set(totals.rates)
    assert "no answer to any of" in str(
        replace(totals.coverage, tasks=totals.coverage.asked).remark_on_missing_answers
    )


def test_one_answer_is_enough_for_rates() -> None:
    records = [*unanswered_run("actions")[1:], action_run()[0]]
    assert RunTotals.from_records(records).rates["task_success"].denominator > 0


def test_a_terminal_says_that_there_is_no_answer(capsys: pytest.CaptureFixture[str]) -> None:
    from eai.cli.console import get_output_console

    records = unanswered_run("goals")
    totals = RunTotals.from_records(records)
    metrics = get_declaration(records[0].ability).terminal_metrics
    print_table(get_output_console(), make_rates_table("Goals", metrics, {"my-model": totals}), wide=False)
    assert "no answer" in capsys.readouterr().out
    both = make_rates_table(
        "Goals", metrics, {"my-model": totals, "other": RunTotals.from_records(goal_run())}
    )
    print_table(get_output_console(), both, wide=True)
    mine = next(line for line in capsys.readouterr().out.splitlines() if "my-model" in line)
    assert "0.0" not in mine


def test_goals_have_a_row_for_unreadable_answers() -> None:
    records = goal_run()
    metrics = get_declaration(records[0].ability).terminal_metrics
    rows = make_rates_table("Goals", metrics, {"my-model": RunTotals.from_records(records)}).rows
    assert "parsing" in [row[0] for row in rows]


@pytest.mark.parametrize("name", RUNS)
def test_every_verdict_says_whether_the_answer_is_right(name: str) -> None:
    for record in RUNS[name]():
        verdict: Verdict = record.verdict
        if verdict.excluded is None:
            is_right = get_declaration(record.ability).outcome(verdict).value == "success"
            assert verdict.success in (is_right, None)
            assert record_to_json(record)["success"] is verdict.success
    if name == "goals":
        assert {record.verdict.success for record in goal_run() if not record.verdict.excluded} <= {
            True,
            False,
        }
