"""Several episodes of a task count by their mean; `LOOK` and `DONE` do not count as actions."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from agents.switches import SWITCHES, WON
from eai.abilities.attempt import AnswerUsage
from eai.abilities.experiment import Experiment
from eai.agents.declaration import average_episode_verdicts, compute_contributions_to_metrics
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING
from eai.agents.verdict import EpisodeVerdict
from eai.benchmarks.suite import open_suite
from eai.results.certainty import compute_rate_intervals
from eai.results.comparison import compare_runs
from eai.results.epochs import ModelAnswers, SuiteResult, score_answers
from eai.results.options import ScoringOptions
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.records import RECORDS, read_records
from eai.results.responses import find_response_files
from eai.results.runs import read_runs
from eai.results.summary import break_down_records, compute_metric_rates, make_contributions_by_metric
from eai.results.tidy import TidyTables
from eai.results.trials import Answer
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.share import Share
from eai.tasks.source import Source

TASK, OTHER = "both", "half"
WINNING = {TASK: WON, OTHER: ("PRESS(lamp)",)}
CRASHED = "the harness crashed"


def settled(folder: Path, *won: str) -> SuiteResult:
    """Score episodes of tasks, given as one letter for each epoch: ``w`` won, ``l`` lost, ``c`` crashed."""
    suite = open_suite(SWITCHES, ACTING)
    given, failures = {}, {}
    for epoch, letters in enumerate(won, 1):
        for task_id, letter in zip(WINNING, letters, strict=True):
            if letter == "c":
                failures[task_id, epoch] = CRASHED
                continue
            play = EpisodeFactory(SWITCHES).begin_episode(suite.tasks[task_id], epoch)
            for command in ("LOOK", *(WINNING[task_id] if letter == "w" else ()), "DONE"):
                play.play_command(command)
            text = play.write_as_json_text("stopped")
            given[task_id, epoch] = Answer(task_id, epoch, "", "", text, "", "stop", (), AnswerUsage())
    prompts = {task_id: Prompt("?") for task_id in WINNING}
    obtained = ModelAnswers("m", "m", prompts, given, failures, len(won))
    return score_answers(obtained, folder, suite, ScoringOptions())


def test_a_task_counts_by_the_mean_over_its_episodes(tmp_path: Path) -> None:
    result = settled(tmp_path, "lw", "ww", "ww")
    assert result.totals.rates["success"] == Rate(pytest.approx(5 / 3), 2)
    actions = 2 * len(WON) / 3 + 1
    assert result.totals.rates["loops"] == Rate(0, pytest.approx(actions))
    written = json.loads((tmp_path / "summary.json").read_text())
    assert written["success"]["value"] == pytest.approx(500 / 6)
    assert written["run"]["passes"]["pass@1"]["value"] == pytest.approx(500 / 6)
    assert written["coverage"]["answered"] == 2


def test_success_by_goals_and_length_is_the_mean_over_episodes(tmp_path: Path) -> None:
    result = settled(tmp_path, "lw", "ww", "lw", "ww")
    found = break_down_records(result.records, ACTING)
    by_task = {case.task: case.share for cases in found.by_goals.values() for case in cases}
    assert by_task == {TASK: Share(0.5, 1), OTHER: Share(1, 1)}
    assert sum(found.outcomes.values()) == 2


def test_records_keep_the_mean_and_name_the_epoch_they_show(tmp_path: Path) -> None:
    result = settled(tmp_path, "cw", "lw", "ww")
    runs = {run.key.model: run.records for run in read_runs([tmp_path])}
    assert sorted(runs) == ["m", "m.epoch_1", "m.epoch_2", "m.epoch_3"]
    assert [record.drop_explanations() for record in runs["m"]] == result.records
    assert compute_metric_rates([record.verdict for record in runs["m"]], ACTING) == result.totals.rates
    assert result.map_tasks_to_epoch_of_recorded_answer() == {TASK: 2, OTHER: 1}
    assert {file.parent.name for file in find_response_files(tmp_path)} == {"epoch_1", "epoch_2", "epoch_3"}


def test_an_episode_that_crashed_is_lost_and_counted_apart(tmp_path: Path) -> None:
    result = settled(tmp_path, "ww", "cw")
    assert result.totals.rates["success"] == Rate(1.5, 2)
    assert result.task_ids_by_failure_reason == {CRASHED: [TASK]}


def test_episodes_of_one_task_are_not_independent_units(tmp_path: Path) -> None:
    def units(result: SuiteResult) -> tuple[int, float]:
        certainty = compute_rate_intervals(make_contributions_by_metric(result.records, ACTING)["success"])
        assert certainty is not None
        return certainty.tasks, certainty.by_task.high - certainty.by_task.low

    few, many = (settled(tmp_path / str(n), *["lw", "wl"] * n) for n in (1, 4))
    assert units(few) == pytest.approx(units(many))
    assert units(many)[0] == 2


def test_runs_of_several_epochs_are_compared_by_their_means(tmp_path: Path) -> None:
    first = settled(tmp_path / "first", "lw", "lw", "ww")
    second = settled(tmp_path / "second", "ww", "ww", "lw")
    found = compare_runs(first.records, second.records).differences
    assert found["success"].percentage_points == pytest.approx(100 / 6)
    assert (found["success"].yes_no, found["success"].only_second) == (False, ())
    assert found["success"].p_by_task == pytest.approx(1)


def test_inspect_computes_the_same_metric(tmp_path: Path) -> None:
    scorer = pytest.importorskip("inspect_ai.scorer")
    from eai.run.scorer import make_inspect_metric_of_paper_scores, make_score

    result = settled(tmp_path, "lw", "ww", "ww")
    scores = [
        scorer.SampleScore(score=make_score(record, epoch, answered=True), sample_id=task_id)
        for (task_id, epoch), record in result.map_keys_to_records().items()
    ]
    shares = {name: rate.share for name, rate in result.totals.rates.items() if rate.denominator}
    found = make_inspect_metric_of_paper_scores("acting")(scores)
    assert {name: share for name, share in found.items() if share is not None} == shares


def test_episodes_that_are_excluded_are_in_no_mean() -> None:
    won, lost = (EpisodeVerdict(success=success) for success in (True, False))
    out = replace(won, excluded="unreplayable")
    assert compute_contributions_to_metrics(average_episode_verdicts([out, won, lost]))["success"] == Share(
        0.5, 1
    )
    assert average_episode_verdicts([out, out]) == out


def acted(tmp_path: Path) -> list[Record]:
    return list(read_records(settled(tmp_path, "ww").folder / RECORDS))


def test_look_and_done_are_not_counted_as_actions(tmp_path: Path) -> None:
    records = acted(tmp_path)
    shares = {"GO": Rate(1, 1), "OPEN": Rate(1, 1), "PRESS": Rate(3, 3)}
    assert break_down_records(records, ACTING).by_action == shares
    made = TidyTables(Source(), features=False)
    made.add_records(records)
    assert {line.operator for line in made.steps} == set(shares)
    assert [line.steps_tried for line in made.answers] == [len(WON), 1]


def test_runs_with_two_harnesses_count_as_two_agents(tmp_path: Path) -> None:
    made = TidyTables(Source(), features=False)
    for harness in ("react", "text"):
        agent = Experiment(harness=harness, effort="high")
        made.add_records([record.add_experiment(agent) for record in acted(tmp_path)])
    assert [(line.harness, line.effort) for line in made.answers[1:3]] == [
        ("react", "high"),
        ("text", "high"),
    ]
    assert [line.model_harness_and_effort for line in made.answers[1:3]] == [
        "m, react, high",
        "m, text, high",
    ]


def test_a_line_shows_one_of_several_different_episodes(tmp_path: Path) -> None:
    made = TidyTables(Source(), features=False)
    made.add_records(settled(tmp_path, "lw", "wl").records)
    assert [(line.outcome, line.success) for line in made.answers] == [
        ("goal_missed", False),
        ("success", True),
    ]
