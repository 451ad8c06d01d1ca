from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.results.responses import (
    Response,
    ResponseFile,
    find_response_files,
    format_attempt_name,
    read_model_name,
    read_responses,
    write_responses,
)

TASKS = ("27_2", "11_1")
GOOD = {"identifier": "27_2", "llm_output": "a"}


def without_scene(identifier: str) -> str:
    return identifier.removeprefix("scene_1_")


def written(folder: Path, content: object, name: str = "m_outputs.json") -> Path:
    file = folder / name
    file.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
    return file


def test_answers_are_read_in_the_order_of_the_file(tmp_path: Path) -> None:
    rows = [{"identifier": "scene_1_11_1", "llm_output": None, "more": 1}, GOOD]
    read = read_responses(written(tmp_path, rows), TASKS, without_scene)
    assert read.model == "m"
    assert read.responses == (Response("11_1", ""), Response("27_2", "a"))


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", ", line 1, column 1: expected JSON"),
        (b'[\n{"identifier"]', ", line 2, column 14: expected JSON"),
        (b"\0" * 100, ", line 1, column 1: expected JSON"),
        (b'["\xff"]', ": expected JSON in UTF-8"),
        (gzip.compress(b"[]", mtime=0), ": expected JSON, found a compressed file; unpack it with gunzip"),
        (b"[" * 100_000, ": expected JSON"),
        (b"[" + b"1" * 10_000 + b"]", ": expected JSON"),
        ({}, ': expected a list of {"identifier", "llm_output"}, not an object'),
        ("x", ': expected a list of {"identifier", "llm_output"}, not a string'),
        (3, ': expected a list of {"identifier", "llm_output"}, not a number'),
        (None, ': expected a list of {"identifier", "llm_output"}, not null'),
        ([], ": expected at least one answer"),
        ([GOOD, [1]], ', row 2: expected {"identifier", "llm_output"}, not a list'),
        ([{"identifier": "27_2"}], ', row 1: the key "llm_output" is missing'),
        ([{"llm_output": "a"}], ', row 1: the key "identifier" is missing'),
        ([{**GOOD, "identifier": 27}], ', row 1: "identifier" must be a string, not a number'),
        ([{**GOOD, "llm_output": {}}], ', row 1: "llm_output" must be a string, not an object'),
        ([{**GOOD, "llm_output": True}], ', row 1: "llm_output" must be a string, not a truth value'),
        ([{**GOOD, "identifier": "0_0"}], ", row 1: identifier '0_0' is not one of the tasks"),
        ([{**GOOD, "identifier": "\ud800\n"}], ", row 1: identifier '\\ud800\\n' is not one of the tasks"),
        ([{**GOOD, "identifier": "x" * 10_000}], ", row 1: identifier 'xxx"),
        ([GOOD, GOOD], ", row 2: identifier '27_2' occurs twice"),
        (
            [GOOD, {**GOOD, "identifier": "scene_1_27_2"}],
            ", row 2: identifier '27_2' occurs twice",
        ),
    ],
    ids=lambda content: str(content)[:30],
)
def test_a_bad_file_is_named_with_the_place(content: object, complaint: str, tmp_path: Path) -> None:
    file = written(tmp_path, content)
    with pytest.raises(InputError) as caught:
        read_responses(file, TASKS, without_scene)
    assert str(caught.value).startswith(f"{file}{complaint}")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < len(str(file)) + 200


def test_rows_of_tasks_that_are_not_in_the_data_set_are_left_out_and_counted(tmp_path: Path) -> None:
    def published(identifier: str) -> str | None:
        return None if identifier.startswith("scene_2_") else without_scene(identifier)

    other = {"identifier": "scene_2_22_1", "llm_output": "b"}
    read = read_responses(written(tmp_path, [other, GOOD, other]), TASKS, published)
    assert (read.responses, read.skipped_rows) == ((Response("27_2", "a"),), 2)
    with pytest.raises(InputError, match="expected at least one answer, found 1 for tasks that are not in"):
        read_responses(written(tmp_path, [other]), TASKS, published)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_responses(tmp_path, TASKS)


@pytest.mark.parametrize(
    ("name", "model"),
    [("gpt-4o_outputs.json", "gpt-4o"), ("answers.json", "answers"), ("a.b_outputs.json", "a.b"), ("x", "x")],
)
def test_a_file_is_named_after_its_model(name: str, model: str) -> None:
    assert read_model_name(Path("folder") / name) == model


@pytest.mark.parametrize("name", ["_outputs.json", "._outputs.json", ".._outputs.json"])
def test_a_file_whose_model_could_not_have_a_folder_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"expected a file named after a model, <model>_outputs\.json"):
        read_model_name(Path("folder") / name)


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("openai/gpt-4o", "openai_gpt-4o"),
        ("hf/Qwen/Qwen2.5-7B", "hf_Qwen_Qwen2.5-7B"),
        ("../../etc/passwd", ".._.._etc_passwd"),
        ("C:\\a b\0\n|c", "C_a_b_c"),
        ("größe", "größe"),
    ],
)
def test_model_names_become_file_names(name: str, file: str) -> None:
    assert to_file_name(name) == file


@pytest.mark.parametrize("name", ["", ".", ".."])
def test_a_model_name_of_dots_is_not_a_file_name(name: str) -> None:
    with pytest.raises(InputError, match="no file can be named after"):
        to_file_name(name)


@given(st.text(min_size=1))
def test_no_name_leads_out_of_its_folder(name: str) -> None:
    try:
        assert (Path("/folder") / to_file_name(name)).resolve().parent == Path("/folder")
    except InputError:
        assert set(name) == {"."}


def test_files_are_found_below_a_folder_by_name(tmp_path: Path) -> None:
    below = tmp_path / "below"
    below.mkdir()
    files = [written(tmp_path, [], "b_outputs.json"), written(below, [], "a_outputs.json")]
    written(tmp_path, [], "notes.json")
    assert find_response_files(tmp_path) == files
    assert find_response_files(tmp_path / "notes.json") == [tmp_path / "notes.json"]


def test_a_folder_without_response_files_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="found none"):
        find_response_files(tmp_path)
    with pytest.raises(InputError, match="no such file or folder"):
        find_response_files(tmp_path / "none.json")


def test_files_of_single_attempts_are_found_only_by_name(tmp_path: Path) -> None:
    file = written(tmp_path, [], "m_outputs.json")
    names = [format_attempt_name("m", 1), format_attempt_name("m", 12)]
    assert names == ["m_attempt_1", "m_attempt_12"]
    attempts = [written(tmp_path, [], f"{name}_outputs.json") for name in names]
    assert find_response_files(tmp_path) == [file]
    assert find_response_files(attempts[0]) == [attempts[0]]


def test_written_responses_are_read_unchanged(tmp_path: Path) -> None:
    made = ResponseFile("m", (Response("27_2", "{\u201c\n}"), Response("11_1", "")))
    write_responses(tmp_path / "new" / "folder", made)
    assert read_responses(tmp_path / "new" / "folder" / "m_outputs.json", TASKS) == made


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"file/m_outputs\.json: cannot be written"):
        write_responses(tmp_path / "file", ResponseFile("m", ()))


def test_json_lines_have_one_answer_a_line(tmp_path: Path) -> None:
    first = json.dumps({"identifier": "11_1", "llm_output": "a\nb"})
    file = written(tmp_path, f"\n{first}\r\n  \n{json.dumps(GOOD)}".encode(), "m_outputs.jsonl")
    assert read_responses(file, TASKS).responses == (Response("11_1", "a\nb"), Response("27_2", "a"))
    bad = written(tmp_path, f"{first}\n\n[1, }}\n".encode(), "bad_outputs.jsonl")
    with pytest.raises(InputError, match=r"bad_outputs\.jsonl, line 3, column 5: expected JSON"):
        read_responses(bad, TASKS)
    twice = f'{first}\n{{"identifier": "27_2", "llm_output": "a", "llm_output": "b"}}\n'
    bad = written(tmp_path, twice.encode(), "bad_outputs.jsonl")
    with pytest.raises(InputError, match=r"jsonl, line 2: the member 'llm_output' occurs twice"):
        read_responses(bad, TASKS)


def test_only_a_line_feed_ends_a_line_of_answers(tmp_path: Path) -> None:
    odd = "a\u2028b\u0085c\x0cd\x1ce"
    rows = f'{{"identifier": "27_2", "llm_output": "{odd}"}}\n\n{{"identifier": "11_1", "llm_output": "z"}}\n'
    read = read_responses(written(tmp_path, rows.encode(), "m_outputs.jsonl"), TASKS)
    assert read.responses == (Response("27_2", odd), Response("11_1", "z"))
    bad = written(tmp_path, f"{rows}\n  ?".encode(), "bad_outputs.jsonl")
    with pytest.raises(InputError, match=r"bad_outputs\.jsonl, line 5, column 3: expected JSON"):
        read_responses(bad, TASKS)
