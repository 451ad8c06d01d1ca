from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.attempt import AnswerUsage
from eai.base.errors import InputError
from eai.run.journal import Answer, AnswerJournal

ANSWER = Answer("27_2", 1, "request", "prompt", "{}", "", "stop", ("reasoning",), AnswerUsage(3, 5, 2, 0.25))


def test_a_written_answer_is_found_in_the_journal(tmp_path: Path) -> None:
    file = tmp_path / "new" / "answers.jsonl"
    strange = replace(ANSWER, task_id="1_1", text="ünder\r\n\u2028 }", usage=AnswerUsage(1, 1))
    cut = replace(ANSWER, task_id="2_1", text="half a smiley: \ud83d")
    journal = AnswerJournal(file)
    for answer in (ANSWER, strange, cut):
        journal.write_answer(answer)
        again = AnswerJournal(file)  # written when `add` returns
        assert again.find_answer((answer.task_id, 1), "request") == answer
    assert journal.find_answer(("27_2", 1), "request") == ANSWER


def test_a_line_of_the_journal_has_every_field(tmp_path: Path) -> None:
    file = tmp_path / "answers.jsonl"
    journal = AnswerJournal(file)
    journal.write_answer(ANSWER)
    assert file.read_text() == json.dumps(asdict(ANSWER)) + "\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full disk to write to")
def test_a_full_disk_is_an_error_that_names_the_file(tmp_path: Path) -> None:
    file = tmp_path / "answers.jsonl"
    journal = AnswerJournal(file)
    file.symlink_to("/dev/full")
    with pytest.raises(InputError, match=r"answers\.jsonl: cannot be written"):
        journal.write_answer(ANSWER)


def test_another_request_or_epoch_is_not_found_in_the_journal(tmp_path: Path) -> None:
    journal = AnswerJournal(tmp_path / "answers.jsonl")
    journal.write_answer(ANSWER)
    assert journal.find_answer(("27_2", 2), "request") is None
    assert journal.find_answer(("27_2", 1), "other") is None
    assert journal.find_answer(("27_3", 1), "request") is None


@given(cut=st.integers(min_value=1, max_value=200))
def test_an_incomplete_last_line_is_overwritten_by_the_next_answer(
    cut: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    file = tmp_path_factory.mktemp("torn") / "answers.jsonl"
    journal = AnswerJournal(file)
    journal.write_answer(ANSWER)
    journal.write_answer(replace(ANSWER, epoch=2))
    file.write_bytes(file.read_bytes()[:-cut])
    torn = AnswerJournal(file)
    assert torn.find_answer(("27_2", 1), "request") == ANSWER
    assert torn.find_answer(("27_2", 2), "request") is None
    torn.write_answer(replace(ANSWER, epoch=2))
    assert AnswerJournal(file).find_answer(("27_2", 2), "request") == replace(ANSWER, epoch=2)


@pytest.mark.parametrize("line", ['{"task_id": "27_2"}', "{", "[" * 100_000, '"\\xff"'])
def test_a_file_that_is_no_journal_is_refused_with_its_line(tmp_path: Path, line: str) -> None:
    file = tmp_path / "answers.jsonl"
    journal = AnswerJournal(file)
    journal.write_answer(ANSWER)
    with file.open("a") as opened:
        opened.write(f"{line}\n")
    with pytest.raises(InputError, match=r"answers\.jsonl, line 2: expected an answer of a run"):
        AnswerJournal(file)


@pytest.mark.parametrize(
    ("reason", "cut_off"), [("stop", False), ("max_tokens", True), ("model_length", True), ("unknown", False)]
)
def test_an_answer_is_truncated_only_by_a_length_limit(reason: str, cut_off: bool) -> None:
    assert replace(ANSWER, stop_reason=reason).is_cut_off is cut_off


def test_usage_sums_only_known_numbers() -> None:
    assert AnswerUsage(1, 2) + AnswerUsage(3, 4) == AnswerUsage(4, 6)
    assert AnswerUsage(1, 2, 3, None) + AnswerUsage(3, 4, None, 0.5) == AnswerUsage(4, 6, 3, 0.5)
    assert AnswerUsage(1, 2, 3, 0.5) + AnswerUsage(0, 0, 4, 0.5) == AnswerUsage(1, 2, 7, 1.0)
