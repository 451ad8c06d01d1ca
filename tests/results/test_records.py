from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import InputError
from eai.results.codec import record_to_json
from eai.results.record import Record
from eai.results.records import read_records
from record_files import write_records


def record(response: str = '{"WALK": ["sofa"]}', model: str = "m") -> Record:
    verdict = PlanVerdict(executable=True, success=False)
    return Record(
        Protocol.STRICT, "lamps", Ability.ACTION_SEQUENCING, model, "27_2", response, "0" * 64, verdict
    )


def test_a_file_reads_as_it_was_written(tmp_path: Path) -> None:
    first, second = tmp_path / "first.jsonl", tmp_path / "second.jsonl"
    write_records(first, [record(), record(model="n")])
    read = list(read_records(first))
    assert read == [record(), record(model="n")]
    write_records(second, read)
    assert second.read_bytes() == first.read_bytes()


@given(st.text(st.characters(), max_size=20))
def test_any_response_is_read_as_it_was_written(
    tmp_path_factory: pytest.TempPathFactory, response: str
) -> None:
    file = tmp_path_factory.mktemp("records") / "records.jsonl"
    write_records(file, [record(response)])
    assert [r.response for r in read_records(file)] == [response]
    assert file.read_bytes().count(b"\n") == 1


@pytest.mark.parametrize("response", ["", "\0", "\ud800", "\u2028\n\r", "é😀"])
def test_responses_with_odd_characters_are_read_unchanged(response: str, tmp_path: Path) -> None:
    write_records(tmp_path / "r.jsonl", [record(response)])
    assert [r.response for r in read_records(tmp_path / "r.jsonl")] == [response]


def test_empty_lines_are_skipped(tmp_path: Path) -> None:
    file = tmp_path / "records.jsonl"
    write_records(file, [record()])
    file.write_text(f"\n{file.read_text()}\n \n")
    assert list(read_records(file)) == [record()]


def changed(**fields: object) -> str:
    """Return a valid line with other fields; a field is left out if its value is `...`."""
    line: dict[str, Any] = {**record_to_json(record()), **fields}
    return json.dumps({key: value for key, value in line.items() if value is not ...})


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("{", "expected a JSON object"),
        ("[1]", "expected a record of a scored answer; eai score makes records of answers"),
        ('{"identifier": "1"}', "expected a record of a scored answer; eai score makes records of answers"),
        ("\0", "expected a JSON object"),
        ("[" * 100_000, "expected a JSON object"),
        ('{"schema": ' + "1" * 10_000 + "}", "expected a JSON object"),
        ("{}", "expected a record of a scored answer"),
        (changed(schema=None), "schema None cannot be read; expected 2"),
        (changed(schema=5), "schema 5 cannot be read; expected 2 or 3 or 4"),
        (changed(schema=[2]), "schema [2] cannot be read; expected 2"),
        (changed(task_id=...), "field task_id: is missing"),
        (changed(schema=1), "schema 1 cannot be read; expected 2"),
        (changed(response="another"), "expected the response that was scored"),
    ],
    ids=lambda text: text[:30],
)
def test_a_damaged_line_is_named(line: str, complaint: str, tmp_path: Path) -> None:
    file = tmp_path / "records.jsonl"
    write_records(file, [record()])
    file.write_text(file.read_text() + line + "\n")
    with pytest.raises(InputError) as caught:
        list(read_records(file))
    assert str(caught.value).startswith(f"{file}, line 2: {complaint}")
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.jsonl"):
        list(read_records(tmp_path / "none.jsonl"))
    (tmp_path / "binary.jsonl").write_bytes(b"\xff\xfe\0")
    with pytest.raises(InputError, match=r"binary\.jsonl"):
        list(read_records(tmp_path / "binary.jsonl"))
