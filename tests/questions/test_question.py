from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from eai.errors import InputError
from eai.questions.question import Question, questions_content, read_questions
from questions.test_answers import ANY, FACTS, question


def lines(*questions: Question) -> list[dict[str, Any]]:
    return [json.loads(line) for line in questions_content(questions).splitlines()]


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    questions = (FACTS, ANY.model_copy(update={"id": "r", "prompt": 'Où?\n\n"x"'}))
    file = tmp_path / "questions.jsonl"
    file.write_bytes(questions_content(questions))
    assert read_questions(file).questions == questions


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "guess"}, r"line 3: kind: expected 'forward'"),
        ({"depth": 0}, r"line 3: depth: expected greater than or equal to 1"),
        ({"answer": "yes"}, r"line 3: answer: expected a list, found 'yes'"),
        ({"extra": 1}, r"line 3: extra: unknown"),
        ({"version": 1}, r"line 3: version: expected 2, found 1"),
        ({"shortcuts": {"names": 2}}, r"line 3: shortcuts"),
        ({"id": "q"}, r"line 3: the id 'q' stands there twice"),
        ({"prompt": ""}, r"line 3: prompt: expected a text that is not empty"),
    ],
)
def test_a_bad_line_is_told_by_file_line_and_field(
    tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    (good,) = lines(FACTS)
    file = tmp_path / "questions.jsonl"
    file.write_text(f"{json.dumps(good)}\n\n{json.dumps({**good, 'id': 'r', **change})}\n")
    with pytest.raises(InputError, match=r"questions\.jsonl: " + message):
        read_questions(file)


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"{", "line 1: the line: Invalid JSON"), (b"\n", "at least one question"), (b"\xff", "line 1")],
)
def test_what_holds_no_question_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "questions.jsonl"
    file.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_questions(file)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_questions(tmp_path / "none.jsonl")


def test_equal_questions_are_equal_bytes() -> None:
    assert questions_content([question(FACTS.form, "a")]) == questions_content([question(FACTS.form, "a")])
