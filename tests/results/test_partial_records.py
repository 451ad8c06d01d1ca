"""Records of interrupted scoring: appended, read again and put into their final place."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.results import partial_records
from eai.results.partial_records import (
    append_record_batches,
    count_kept_records,
    get_path_of_partial_file,
    publish_records,
    remove_partial_files,
)
from eai.results.records import RECORDS, SUMMARY, RecordBatch, make_record_batch, write_record_batches
from eai.results.responses import Response, ResponseFile
from eai.results.totals import RunTotals
from results.test_shards import RECORDS as MADE

ANSWERS = ResponseFile("m", tuple(Response(record.task_id, record.response) for record in MADE))


@pytest.mark.parametrize("has_links", [True, False])
@pytest.mark.parametrize("cut", ["", '{"half of a rec'])
def test_appended_records_give_the_files_of_all_records(
    cut: str, has_links: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*paths: Path) -> None:
        raise OSError("no links here")

    if not has_links:
        monkeypatch.setattr(partial_records.os, "link", refuse)
    write_record_batches(tmp_path / "whole", [make_record_batch(MADE)])
    file = tmp_path / "parts" / RECORDS
    partial_file = get_path_of_partial_file(file, (), ANSWERS)
    assert count_kept_records(partial_file) == 0
    append_record_batches(partial_file, [make_record_batch(MADE[:2])])
    partial_file.write_bytes(partial_file.read_bytes() + cut.encode())
    assert count_kept_records(partial_file) == 2
    totals = append_record_batches(partial_file, [make_record_batch(MADE[2:3]), make_record_batch(MADE[3:])])
    assert totals == RunTotals.from_records(MADE)
    for _ in range(2):  # as by an interrupted command and by the next
        publish_records(partial_file, file, totals)
    assert count_kept_records(partial_file) == len(MADE)
    remove_partial_files(file)
    for folder in ("parts", "whole"):
        assert {path.name for path in (tmp_path / folder).iterdir()} == {RECORDS, SUMMARY}
    for name in (RECORDS, SUMMARY):
        assert (tmp_path / "parts" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_each_batch_is_kept_before_the_next_is_made(tmp_path: Path) -> None:
    partial_file = tmp_path / ".part"

    def batches() -> Iterator[RecordBatch]:
        for number, record in enumerate(MADE):
            assert count_kept_records(partial_file) == number
            yield make_record_batch([record])
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        append_record_batches(partial_file, batches())
    assert count_kept_records(partial_file) == len(MADE)


def test_other_answers_options_and_files_have_other_partial_files(tmp_path: Path) -> None:
    other_text = ResponseFile("m", (Response(MADE[0].task_id, "other"), *[*ANSWERS.responses][1:]))
    read = tmp_path / "goals"
    read.write_text("a")
    file = tmp_path / RECORDS
    names = [
        get_path_of_partial_file(file, ("strict",), ANSWERS),
        get_path_of_partial_file(file, ("eai-1.0.5",), ANSWERS),
        get_path_of_partial_file(file, ("strict",), other_text),
        get_path_of_partial_file(file, ("strict",), ResponseFile("m", ANSWERS.responses, 0, (ANSWERS,))),
        get_path_of_partial_file(file, ("strict",), ANSWERS, [read]),
    ]
    read.write_text("b")
    names.append(get_path_of_partial_file(file, ("strict",), ANSWERS, [read]))
    assert len({*names}) == len(names)
    assert get_path_of_partial_file(file, ("strict",), ANSWERS) == names[0]


def test_finished_scoring_removes_partial_files_of_the_same_records_only(tmp_path: Path) -> None:
    others = [tmp_path / RECORDS, tmp_path / ".records.shard-1-of-2.jsonl-0f.part"]
    for file in (*others, tmp_path / f".{RECORDS}-0f.part", tmp_path / f".{RECORDS}-1f.part"):
        file.touch()
    remove_partial_files(tmp_path / RECORDS)
    assert sorted(tmp_path.iterdir()) == sorted(others)


def test_a_folder_that_cannot_be_written_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be written"):
        append_record_batches(tmp_path / "file" / ".part", [])
