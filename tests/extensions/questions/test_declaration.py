from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.extensions.questions.declaration import (
    _VerdictOnQuestionAnswer,
    open_question_file_as_named_task_set,
)
from eai.extensions.questions.question import Question, QuestionForm, QuestionKind, questions_to_bytes
from eai.extensions.questions.shortcuts import compute_answer_entropy
from eai.results.batch import score_run
from eai.results.certainty import compute_rate_intervals
from eai.results.codec import record_from_json, record_to_json
from eai.results.comparison import compare_runs
from eai.results.epochs import find_majority_index
from eai.results.options import ScoringOptions
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.responses import Response, ResponseFile
from eai.results.summary import compute_metric_rates, make_contributions_by_metric


def asked(number: int, form: QuestionForm, answer: tuple[str, ...], **changes: object) -> Question:
    values = {
        "id": f"{form.value}-{number}",
        "domain": "d",
        "task": f"t{number // 2}",
        "title": "t",
        "kind": QuestionKind.STATE,
        "form": form,
        "depth": 1,
        "options": {QuestionForm.YES_NO: 2, QuestionForm.CHOICE: 4, QuestionForm.OPEN: 0}[form],
        "prompt": f"{number}?",
        "answer": answer,
    }
    return Question.model_validate({**values, **changes})


QUESTIONS = [
    asked(0, QuestionForm.YES_NO, ("yes",)),
    asked(1, QuestionForm.YES_NO, ("no",)),
    asked(2, QuestionForm.CHOICE, ("B",), depth=2),
    asked(3, QuestionForm.CHOICE, ("D",), depth=8),
    asked(4, QuestionForm.OPEN, ("1", "2")),
    asked(5, QuestionForm.OPEN, ("1",)),
    asked(6, QuestionForm.OPEN, ("1",)),
    asked(7, QuestionForm.OPEN, ("a", "b"), kind=QuestionKind.BACKWARD, accept="any"),
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
WORLD_MODEL = Ability("world_model")


def scored(folder: Path, questions: Sequence[Question], answers: Mapping[str, str]) -> list[Record]:
    """Return the records of answers to questions from a file."""
    file = folder / f"{len(list(folder.iterdir()))}.jsonl"
    file.write_bytes(questions_to_bytes(questions))
    suite = open_suite(str(file), WORLD_MODEL)
    given = tuple([Response(each.id, answers[each.id]) for each in questions if each.id in answers])
    missing = {each.id: "no answer" for each in questions if each.id not in answers}
    return score_run(suite, ResponseFile("me", given), missing, ScoringOptions())


def rates(records: Sequence[Record]) -> Mapping[str, Rate]:
    return compute_metric_rates([record.verdict for record in records], WORLD_MODEL)


def parts(rate: Rate) -> tuple[float, float]:
    return rate.numerator, rate.denominator


def test_rates_count_all_questions(tmp_path: Path) -> None:
    found = rates(scored(tmp_path, QUESTIONS, ANSWERS))
    assert parts(found["right"]) == (4, 8)
    assert parts(found["state"]) == (3, 7)
    assert parts(found["backward"]) == (1, 1)
    assert parts(found["forward"]) == (0, 0)
    assert parts(found["form.open"]) == (2, 4)
    assert parts(found["parsing"]) == (1, 8)
    assert parts(found["f1"]) == (6, 8)  # 3 right, none wrong, 2 missed


def test_a_missing_answer_is_not_unreadable(tmp_path: Path) -> None:
    unreadable = dict.fromkeys(["yes_no-0", "choice-2", "open-4"], "hard to say")
    records = scored(tmp_path, QUESTIONS, unreadable)
    assert parts(rates(records)["parsing"]) == (3, len(QUESTIONS))
    assert [record.unanswered is None for record in records].count(True) == 3


def test_guessing_is_a_random_choice_or_the_most_common_answer(tmp_path: Path) -> None:
    found = rates(scored(tmp_path, QUESTIONS, ANSWERS))
    assert found["state.chance.guess"].share == pytest.approx((0.5 * 2 + 0.25 * 2 + 2) / 7)
    assert found["backward.chance.guess"].percent == 100


def test_an_absent_shortcut_counts_as_a_guess(tmp_path: Path) -> None:
    questions = [
        asked(n, QuestionForm.CHOICE, ("A",), shortcuts={"names": n < 2, "longest": 0.25}) for n in range(4)
    ] + [asked(4, QuestionForm.YES_NO, ("yes",), shortcuts={"longest": 0})]
    found = rates(scored(tmp_path, questions, {}))
    ways = {way: found[f"chance.{way}"].numerator for way in ("guess", "names", "longest", "text")}
    assert ways == {"guess": 1.5, "names": 2.5, "longest": 1.0, "text": 1.5}


def test_questions_about_one_task_count_together(tmp_path: Path) -> None:
    independent = [asked(2 * n, QuestionForm.YES_NO, ("yes",)) for n in range(40)]
    alike = [asked(n, QuestionForm.YES_NO, ("yes",)) for n in range(40)]
    wide = []
    for some in (independent, alike):
        given = {q.id: "yes" if i % 4 < 2 else "no" for i, q in enumerate(some)}
        certainty = compute_rate_intervals(
            make_contributions_by_metric(scored(tmp_path, some, given), WORLD_MODEL)["right"]
        )
        assert certainty is not None
        wide.append(certainty.interval.high - certainty.interval.low)
    assert wide[1] > 1.3 * wide[0]


def test_rates_by_depth(tmp_path: Path) -> None:
    found = rates(scored(tmp_path, QUESTIONS, ANSWERS))
    counts = {depth: parts(found[f"state.depth.{depth}"]) for depth in ("1", "2-3", "4-7", "8+")}
    assert counts == {"1": (2, 5), "2-3": (1, 1), "4-7": (0, 0), "8+": (0, 1)}


def test_a_record_of_a_question_round_trips(tmp_path: Path) -> None:
    records = scored(tmp_path, QUESTIONS, ANSWERS)
    assert [record.task_id for record in records] == [question.id for question in QUESTIONS]
    assert [record_from_json(record_to_json(record)) for record in records] == records
    verdict = records[4].verdict
    assert isinstance(verdict, _VerdictOnQuestionAnswer)
    assert (verdict.counts, verdict.gold, verdict.kind) == ((1, 0, 1), ("1", "2"), QuestionKind.STATE)
    assert records[0].task is not None
    assert records[0].task.name == QUESTIONS[0].task


def test_other_questions_of_the_same_ids_are_not_compared(tmp_path: Path) -> None:
    records = scored(tmp_path, QUESTIONS, ANSWERS)
    others = [each.model_copy(update={"depth": 7}) for each in QUESTIONS[:3]]
    found = compare_runs(records, scored(tmp_path, [*others, *QUESTIONS[3:]], ANSWERS))
    assert (found.tasks, found.only_in_first) == (5, tuple(each.id for each in others))


def test_a_question_file_serves_only_the_world_model_ability(tmp_path: Path) -> None:
    file = tmp_path / "q.jsonl"
    file.write_bytes(questions_to_bytes(QUESTIONS))
    assert find_benchmark(str(file)).name == "d-q"
    with pytest.raises(InputError, match=r"q\.jsonl: it has no tasks for .*; give --ability world_model"):
        open_suite(str(file), Ability.ACTION_SEQUENCING)
    with pytest.raises(InputError, match="virtualhome: expected a file that eai export questions writes"):
        open_suite("virtualhome", WORLD_MODEL)


def test_entropy_measures_how_evenly_answers_are_spread() -> None:
    assert compute_answer_entropy(QUESTIONS, QuestionKind.STATE, QuestionForm.YES_NO) == 1.0
    assert compute_answer_entropy(QUESTIONS, QuestionKind.STATE, QuestionForm.CHOICE) == 0.5
    assert compute_answer_entropy(QUESTIONS, QuestionKind.BACKWARD, QuestionForm.OPEN) is None
    same = [asked(n, QuestionForm.YES_NO, ("yes",)) for n in range(3)]
    assert compute_answer_entropy(same, QuestionKind.STATE, QuestionForm.YES_NO) == 0.0
    plans = [
        asked(n, QuestionForm.OPEN, answer, kind=QuestionKind.VALIDATION)
        for n, answer in enumerate([("works",), ("goal 1",), ("step 2", "requirement 1")])
    ]
    assert compute_answer_entropy(plans, QuestionKind.VALIDATION, QuestionForm.OPEN) == pytest.approx(1.0)


def test_entropy_ignores_the_failing_step_of_an_outcome() -> None:
    def entropy(kind: QuestionKind, *told: str) -> float | None:
        asked = [
            QUESTIONS[0].model_copy(
                update={"kind": kind, "form": QuestionForm.OPEN, "answer": (a,), "options": 0}
            )
            for a in told
        ]
        return compute_answer_entropy(asked, kind, QuestionForm.OPEN)

    for kind in (QuestionKind.COUNTERFACTUAL, QuestionKind.VALIDATION):
        assert entropy(kind, "fails 1", "fails 2", "fails 3") == 0
        assert entropy(kind, "works", "goal 1") == pytest.approx(1 / math.log2(3))  # no step fails
    assert entropy(QuestionKind.STATE, "at ball", "at box") == 1


def test_a_task_file_is_no_question_file(tmp_path: Path) -> None:
    file = tmp_path / "tasks.jsonl"
    file.write_text('{"id":"one","version":1,"base":"lamps:lamps"}\n', encoding="utf-8")
    assert open_question_file_as_named_task_set(file) is None


@pytest.mark.parametrize(
    ("answers", "chosen"),
    [(["yes", "no", " no\n"], 1), (['["a"]', 'So:\n["b"]', '["b"]'], 1), (["yes", "no"], 0)],
)
def test_answers_to_questions_need_no_json(answers: list[str], chosen: int) -> None:
    assert find_majority_index(answers, Ability("world_model")) == chosen
