from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from eai.abilities.verdict import ConfusionCounts
from eai.base.errors import InputError
from eai.extensions.questions.question import (
    Accept,
    Question,
    QuestionForm,
    QuestionKind,
    format_gold_answer,
    grade_answer,
    questions_to_bytes,
    read_questions_and_sha256,
)


def lines(*questions: Question) -> list[dict[str, Any]]:
    return [json.loads(line) for line in questions_to_bytes(questions).splitlines()]


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    questions = (FACTS, ANY.model_copy(update={"id": "r", "prompt": 'Où?\n\n"x"'}))
    file = tmp_path / "questions.jsonl"
    file.write_bytes(questions_to_bytes(questions))
    assert read_questions_and_sha256(file)[0] == questions


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "guess"}, r"line 3: kind: expected 'forward'"),
        ({"depth": 0}, r"line 3: depth: expected greater than or equal to 1"),
        ({"answer": "yes"}, r"line 3: answer: expected a list, found 'yes'"),
        ({"extra": 1}, r"line 3: extra: unknown"),
        ({"version": 1}, r"line 3: version: expected 2, found 1"),
        ({"shortcuts": {"names": 2}}, r"line 3: shortcuts"),
        ({"id": "q"}, r"line 3: the id 'q' occurs twice"),
        ({"form": "choice", "answer": []}, r"line 3: answer: .*expected one answer .* choice, found \[\]"),
        (
            {"form": "yes_no", "answer": ["yes", "no"]},
            r"line 3: answer: .*expected one answer .* yes_no, found \[",
        ),
        ({"prompt": ""}, r"line 3: prompt: expected a text that is not empty"),
    ],
)
def test_an_error_in_a_question_file_names_line_and_field(
    tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    (good,) = lines(FACTS)
    file = tmp_path / "questions.jsonl"
    file.write_text(f"{json.dumps(good)}\n\n{json.dumps({**good, 'id': 'r', **change})}\n")
    with pytest.raises(InputError, match=r"questions\.jsonl: " + message):
        read_questions_and_sha256(file)


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"{", "line 1: the line: Invalid JSON"), (b"\n", "at least one question"), (b"\xff", "line 1")],
)
def test_a_file_without_questions_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "questions.jsonl"
    file.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_questions_and_sha256(file)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_questions_and_sha256(tmp_path / "none.jsonl")


def test_equal_questions_are_equal_bytes() -> None:
    assert questions_to_bytes([question(FACTS.form, "a")]) == questions_to_bytes([question(FACTS.form, "a")])


def question(
    form: QuestionForm, *answer: str, accept: Accept = "all", options: int = 0, question_id: str = "q"
) -> Question:
    return Question(
        id=question_id,
        domain="d",
        task="t",
        title="t",
        kind=QuestionKind.STATE,
        form=form,
        depth=1,
        options=options,
        prompt="?",
        answer=answer,
        accept=accept,
    )


YES = question(QuestionForm.YES_NO, "yes", options=2)
LETTER = question(QuestionForm.CHOICE, "B", options=4)
FACTS = question(QuestionForm.OPEN, "at(robot, box)", "not lit(lamp_1)")
NOTHING = question(QuestionForm.OPEN)
ANY = question(QuestionForm.OPEN, "GO(box)", "GO(ball)", accept="any")


@pytest.mark.parametrize(
    ("asked", "text", "exact", "counts"),
    [
        (YES, "yes", True, (1, 0, 0)),
        (YES, "Yes.", True, (1, 0, 0)),
        (YES, "no", False, (0, 1, 1)),
        (YES, "The answer is yes", True, (1, 0, 0)),
        (YES, "<think>no? no.</think> yes", True, (1, 0, 0)),
        (LETTER, "B", True, (1, 0, 0)),
        (LETTER, "**B.**", True, (1, 0, 0)),
        (LETTER, "C", False, (0, 1, 1)),
        (FACTS, '["not lit(lamp_1)", "at(robot, box)"]', True, (2, 0, 0)),
        (FACTS, '```json\n["not lit( lamp_1 )", "AT(robot,box)"]\n```', True, (2, 0, 0)),
        (FACTS, '["at(robot, box)"]', False, (1, 0, 1)),
        (FACTS, '["at(robot, box)", "lit(lamp_1)"]', False, (1, 1, 1)),
        (FACTS, '["at(robot, box)", "at(robot, box)", "not lit(lamp_1)"]', True, (2, 0, 0)),
        (FACTS, "[]", False, (0, 0, 2)),
        (NOTHING, "[]", True, (0, 0, 0)),
        (NOTHING, '["lit(lamp_1)"]', False, (0, 1, 0)),
        (ANY, '["GO(ball)"]', True, (1, 0, 0)),
        (ANY, '["GO(lamp_1)"]', False, (0, 1, 1)),
        (ANY, '["GO(ball)", "GO(lamp_1)"]', False, (1, 1, 0)),
        (ANY, '["GO(ball)", "GO(box)"]', False, (2, 0, 0)),
        (question(QuestionForm.OPEN, "1", "3"), "[1, 3]", True, (2, 0, 0)),
    ],
)
def test_an_answer_is_graded_by_its_items(
    asked: Question, text: str, exact: bool, counts: tuple[int, int, int]
) -> None:
    graded = grade_answer(asked, text)
    assert (graded.exact, graded.counts, graded.readable) == (exact, ConfusionCounts(*counts), True)


@pytest.mark.parametrize(
    ("asked", "text", "missed"),
    [
        (YES, "", 1),
        (YES, "yes and no", 1),
        (LETTER, "B or C", 1),
        (LETTER, "E", 1),
        (FACTS, "at(robot, box)", 2),
        (FACTS, '{"facts": "at(robot, box)"}', 2),
        (NOTHING, "nothing", 0),
        (ANY, "GO(ball)", 1),
        (FACTS, '[["at", "robot", "box"]]', 2),
    ],
)
def test_an_unreadable_answer_is_wrong_and_not_guessed(asked: Question, text: str, missed: int) -> None:
    graded = grade_answer(asked, text)
    assert (graded.exact, graded.counts, graded.readable) == (False, ConfusionCounts(0, 0, missed), False)


def test_repairs_are_named() -> None:
    assert grade_answer(YES, "yes").repairs == ()
    assert grade_answer(YES, "It does: yes").repairs == ("prose",)
    assert grade_answer(FACTS, 'So: ["at(robot, box)"]').repairs == ("prose",)


QUOTED = question(QuestionForm.OPEN, 'says(robot, "é")', "at(a\\b)")


@pytest.mark.parametrize("asked", [YES, LETTER, FACTS, NOTHING, ANY, QUOTED])
def test_the_gold_answer_is_right(asked: Question) -> None:
    assert grade_answer(asked, format_gold_answer(asked)).exact
