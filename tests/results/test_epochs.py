"""Scoring the answers of a model in ``eai run``; whole runs are in `test_run`."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from eai.abilities.attempt import AnswerUsage
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.benchmarks.errata import ApplicableErrata
from eai.cli.console import format_count, format_dollars
from eai.cli.table import result_to_json
from eai.results.epochs import ModelAnswers, find_majority_index, normalise_answer, score_answers
from eai.results.options import ScoringOptions
from eai.results.totals import RunTotals
from eai.results.trials import Answer
from eai.tasks.prompts.prompt import Prompt
from results.work import TASK_IDS, echo_suite

PLANS = Ability.ACTION_SEQUENCING
GOALS = Ability.GOAL_INTERPRETATION
SUBGOALS = Ability.SUBGOAL_DECOMPOSITION
OPERATORS = Ability.TRANSITION_MODELING


@pytest.mark.parametrize(
    ("ability", "one", "other"),
    [
        (PLANS, '{"WALK": ["sofa", "3"]}', "Here it is:\n```json\n{'WALK':\n['sofa', '3']}\n```"),
        (PLANS, '[{"action": "OPEN"}]', '  [ {"action" : "OPEN"} ]'),
        (GOALS, '{"node goals": [["a"], ["b", "c"]]}', '{"node goals": [["b", "c"], ["a"]]}'),
        (GOALS, '{"a": [{"x": "1", "y": "2"}]}', '{"a": [{"y": "2", "x": "1"}]}'),
        (SUBGOALS, '{"output": ["ON(tv.1)  and A"], "n": 1}', '{"n": 1, "output": ["ON(tv.1) and A"]}'),
        (OPERATORS, "(:action a\n  :effect (b))", "Sure.\n(:action a :effect (b))"),
    ],
)
def test_answers_that_differ_only_in_form_have_one_meaning(ability: Ability, one: str, other: str) -> None:
    assert normalise_answer(one, ability) == normalise_answer(other, ability) is not None


@pytest.mark.parametrize(
    ("ability", "one", "other"),
    [
        (PLANS, '{"WALK": ["a"], "GRAB": ["a"]}', '{"GRAB": ["a"], "WALK": ["a"]}'),
        (PLANS, '{"WALK": ["a"], "WALK": ["b"]}', '{"WALK": ["b"], "WALK": ["a"]}'),
        (PLANS, '{"POUR": ["a", "b"]}', '{"POUR": ["b", "a"]}'),
        (GOALS, '{"edge goals": [["inside", "a", "b"]]}', '{"edge goals": [["inside", "b", "a"]]}'),
        (SUBGOALS, '{"output": ["A", "B"]}', '{"output": ["B", "A"]}'),
        (SUBGOALS, '{"output": [1]}', '{"output": [true]}'),
    ],
)
def test_answers_that_differ_in_content_have_different_meanings(
    ability: Ability, one: str, other: str
) -> None:
    assert normalise_answer(one, ability) != normalise_answer(other, ability)


@pytest.mark.parametrize(
    ("answers", "chosen"),
    [
        (["{'A': []}", "{'B': []}", "{'B':[]}"], 1),
        (["{'A': []}", "{'B': []}"], 0),
        (["{'B': []}", "no", "neither"], 1),
        (["{'B': []}", "no", "{'B': []}"], 0),
        (["{'B': []}", "no"], 0),
        (["{'B': []}", None, None], 1),
        (["{'B': []}", "no", None], 1),
        (["no", "neither"], 0),
        (["only"], 0),
    ],
)
def test_the_first_answer_of_the_most_frequent_meaning_is_chosen(
    answers: list[str | None], chosen: int
) -> None:
    assert find_majority_index(answers, PLANS) == chosen


def test_plans_that_are_not_json_have_no_meaning() -> None:
    assert [normalise_answer("no", each) for each in PAPER_ABILITIES] == [None] * 4


@pytest.mark.parametrize("epochs", [1, 2, 3])
def test_each_epoch_is_scored_in_a_folder_of_its_own(tmp_path: Path, epochs: int) -> None:
    task_id, usage = TASK_IDS[0], AnswerUsage(7, 2)
    texts = [f"{text} answer to {task_id}" for text in ("one", "another", "third")][:epochs]
    given = {
        (task_id, epoch): Answer(task_id, epoch, "0" * 64, "0" * 64, text, "", "stop", (), usage)
        for epoch, text in enumerate(texts, 1)
    }
    obtained = ModelAnswers("m", "m", {task_id: Prompt("?")}, given, {}, epochs)
    result = score_answers(obtained, tmp_path, echo_suite(), ScoringOptions())
    several = list(range(1, epochs + 1)) if epochs > 1 else []
    assert sorted(tmp_path.glob("epoch_*")) == [tmp_path / f"epoch_{epoch}" for epoch in several]
    assert [one.folder for one in result.by_epoch] == [tmp_path / f"epoch_{epoch}" for epoch in several]
    assert [record.response for record in result.map_keys_to_records().values()] == texts
    assert list(result.map_keys_to_records()) == list(given)
    for one in (result, *result.by_epoch):
        told = json.loads((one.folder / "summary.json").read_text())["run"]
        assert (told["answered"], told["usage"]["input_tokens"]) == (1, 7 * len(one.map_keys_to_records()))


@pytest.mark.parametrize(
    ("others", "success"),
    [((), False), (("I do not know.",), False), (("{'A': []}",), True)],
)
def test_an_answer_that_most_rounds_lack_does_not_count(
    tmp_path: Path, others: tuple[str, ...], success: bool
) -> None:
    task_id = TASK_IDS[0]
    right = f"{{'A': []}} for {task_id}"
    given = {
        (task_id, epoch): Answer(task_id, epoch, "0" * 64, "0" * 64, text, "", "stop", (), AnswerUsage())
        for epoch, text in enumerate((right, *others), 1)
    }
    failures = {(task_id, epoch): "it took too long" for epoch in range(len(given) + 1, 4)}
    obtained = ModelAnswers("m", "m", {task_id: Prompt("?")}, given, failures, 3)
    (record,) = score_answers(obtained, tmp_path, echo_suite(), ScoringOptions()).records
    assert (record.response == right) is success
    assert (record.unanswered == "it took too long") is (not others)


def test_each_epoch_has_its_own_reason_for_a_missing_answer(tmp_path: Path) -> None:
    failures = {(TASK_IDS[0], 1): "it took too long", (TASK_IDS[0], 2): "the server was down"}
    obtained = ModelAnswers("m", "m", {TASK_IDS[0]: Prompt("?")}, {}, failures, 2)
    result = score_answers(obtained, tmp_path, echo_suite(), ScoringOptions())
    assert [list(one.task_ids_by_failure_reason) for one in result.by_epoch] == [
        ["it took too long"],
        ["the server was down"],
    ]


@pytest.mark.parametrize(
    ("errata", "told"), [(None, None), (ApplicableErrata("2.0", ("e1",)), ("2.0", [TASK_IDS[0]]))]
)
def test_the_effect_of_errata_is_stated_only_if_errata_were_used(
    tmp_path: Path, errata: ApplicableErrata | None, told: tuple[str, list[str]] | None
) -> None:
    obtained = ModelAnswers("m", "m", {TASK_IDS[0]: Prompt("?")}, {}, {}, 1)
    result = score_answers(obtained, tmp_path, echo_suite(), ScoringOptions(allow_missing=False))
    (record,) = result.records
    marked = [replace(record, errata=errata)]
    found = result_to_json(RunTotals.from_records(marked), result.folder)["errata"]
    assert told == ((found["version"], found["corrected"]) if isinstance(found, dict) else found)


@pytest.mark.parametrize(
    ("number", "text"), [(0, "0 tasks"), (1, "1 task"), (2, "2 tasks"), (1000, "1,000 tasks")]
)
def test_counted_nouns_are_in_singular_or_plural(number: int, text: str) -> None:
    assert format_count(number, "task") == text


@pytest.mark.parametrize(("amount", "text"), [(0, "$0.0000"), (0.0012, "$0.0012"), (12.345, "$12.35")])
def test_small_amounts_are_not_shown_as_zero(amount: float, text: str) -> None:
    assert format_dollars(amount) == text
