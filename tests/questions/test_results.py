from __future__ import annotations

import json
from pathlib import Path

import pytest

from eai.questions.question import Accept, Form, Kind, Question
from eai.questions.records import QuestionRun, write_results
from eai.questions.results import depth_text, score, table_json, tabulate
from eai.questions.shortcuts import balance_of


def asked(number: int, form: Form, answer: tuple[str, ...], **changes: object) -> Question:
    values = {
        "id": f"{form.value}-{number}",
        "domain": "d",
        "task": f"t{number // 2}",
        "title": "t",
        "kind": Kind.STATE,
        "form": form,
        "depth": 1,
        "options": {Form.YES_NO: 2, Form.CHOICE: 4, Form.OPEN: 0}[form],
        "prompt": f"{number}?",
        "answer": answer,
    }
    return Question.model_validate({**values, **changes})


QUESTIONS = [
    asked(0, Form.YES_NO, ("yes",)),
    asked(1, Form.YES_NO, ("no",)),
    asked(2, Form.CHOICE, ("B",), depth=3),
    asked(3, Form.CHOICE, ("D",), depth=9),
    asked(4, Form.OPEN, ("1", "2")),
    asked(5, Form.OPEN, ("1",)),
    asked(6, Form.OPEN, ("1",)),
    asked(7, Form.OPEN, ("a", "b"), kind=Kind.BACKWARD, accept=Accept.ANY),
]
ANSWERS = {
    "yes_no-0": "yes",
    "yes_no-1": "hard to say",
    "choice-2": "B",
    "choice-3": "A",
    "open-4": '["1"]',
    "open-5": '["1"]',
    "open-7": '["b"]',
}


def test_rates_are_of_all_that_was_asked() -> None:
    table = tabulate(score(QUESTIONS, ANSWERS))
    row = table.by_kind[Kind.STATE]
    assert (row.exact.numerator, row.exact.denominator) == (3, 7)
    assert (row.unreadable.numerator, row.unreadable.denominator) == (1, 7)
    assert (row.f1.numerator, row.f1.denominator) == (4, 6)  # 2 right, none wrong, 2 missed
    assert table.by_kind[Kind.BACKWARD].exact.percent == 100
    assert (table.overall.exact.numerator, table.overall.exact.denominator) == (4, 8)
    assert list(table.by_kind) == [Kind.BACKWARD, Kind.STATE]


def test_no_answer_is_not_an_unreadable_one() -> None:
    unreadable = dict.fromkeys(["yes_no-0", "choice-2", "open-4"], "hard to say")
    row = tabulate(score(QUESTIONS, unreadable)).overall
    assert (row.unreadable.numerator, row.unreadable.denominator) == (3, len(QUESTIONS))


def test_chance_is_a_random_choice_or_the_most_common_answer() -> None:
    table = tabulate(score(QUESTIONS, ANSWERS))
    assert table.by_form[Form.YES_NO].chance.percent == 50
    assert table.by_form[Form.CHOICE].chance.percent == 25
    assert table.by_kind[Kind.STATE].chance.share == pytest.approx((0.5 * 2 + 0.25 * 2 + 2) / 7)
    assert table.by_kind[Kind.BACKWARD].chance.percent == 100


def test_chance_is_the_best_shortcut_where_one_is_better_than_guessing() -> None:
    questions = [
        asked(n, Form.CHOICE, ("A",), shortcuts={"names": n < 2, "longest": 0.25}) for n in range(4)
    ] + [asked(4, Form.YES_NO, ("yes",), shortcuts={"longest": 0})]
    row = tabulate(score(questions, {})).overall
    assert {name: rate.numerator for name, rate in row.chances.items()} == {
        "guess": 1.5,
        "names": 2.5,
        "longest": 1.0,
    }
    assert row.chance == row.chances["names"]


def test_the_unit_of_intervals_is_the_task() -> None:
    independent = [asked(2 * n, Form.YES_NO, ("yes",)) for n in range(40)]
    alike = [asked(n, Form.YES_NO, ("yes",)) for n in range(40)]
    wide = [
        tabulate(
            score(some, {q.id: "yes" if i % 4 < 2 else "no" for i, q in enumerate(some)})
        ).overall.interval
        for some in (independent, alike)
    ]
    first, second = [interval.high - interval.low for interval in wide if interval is not None]
    assert second > 1.3 * first


def test_rates_by_depth() -> None:
    table = tabulate(score(QUESTIONS, ANSWERS))
    depths = table_json(table)["by_depth"]
    assert isinstance(depths, dict)
    counts = {depth: (r["numerator"], r["denominator"]) for depth, r in depths["state"].items()}
    assert counts == {"1": (2, 5), "2-3": (1, 1), "4-7": (0, 0), "8+": (0, 1)}
    assert depth_text((1, 1)) == "1"


def test_records_hold_question_and_answer(tmp_path: Path) -> None:
    write_results(tmp_path, QuestionRun("me", "0" * 64, tuple(score(QUESTIONS, ANSWERS))))
    records = [json.loads(line) for line in (tmp_path / "records.jsonl").read_text().splitlines()]
    assert [record["id"] for record in records] == [question.id for question in QUESTIONS]
    assert [record["exact"] for record in records] == [True, False, True, False, False, True, False, True]
    assert records[6]["response"] is None
    assert records[4]["counts"] == [1, 0, 1]
    assert "prompt" not in records[0]
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["model"] == "me"
    assert summary["overall"]["exact"] == {"value": 50.0, "numerator": 4, "denominator": 8}


def test_how_even_answers_are() -> None:
    even = balance_of(QUESTIONS, Kind.STATE, Form.YES_NO)
    assert (even.number, even.entropy) == (2, 1.0)
    assert balance_of(QUESTIONS, Kind.STATE, Form.CHOICE).entropy == 0.5
    assert balance_of(QUESTIONS, Kind.BACKWARD, Form.OPEN).entropy is None
    same = [asked(n, Form.YES_NO, ("yes",)) for n in range(3)]
    assert balance_of(same, Kind.STATE, Form.YES_NO).entropy == 0.0
    plans = [
        asked(n, Form.OPEN, answer, kind=Kind.VALIDATION)
        for n, answer in enumerate([("works",), ("goal 1",), ("step 2", "requirement 1")])
    ]
    assert balance_of(plans, Kind.VALIDATION, Form.OPEN).entropy == pytest.approx(1.0)


def test_of_what_becomes_of_a_plan_the_step_does_not_count_and_else_every_word_does() -> None:
    def entropy(kind: Kind, *told: str) -> float | None:
        asked = [
            QUESTIONS[0].model_copy(update={"kind": kind, "form": Form.OPEN, "answer": (a,), "options": 0})
            for a in told
        ]
        return balance_of(asked, kind, Form.OPEN).entropy

    for kind in (Kind.COUNTERFACTUAL, Kind.VALIDATION):
        assert entropy(kind, "fails 1", "fails 2", "fails 3") == 0
    assert entropy(Kind.STATE, "at ball", "at box") == 1
