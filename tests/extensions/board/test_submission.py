from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.extensions.board.submission import (
    build_submission,
    check_submission,
    get_task_identifiers_by_submission_file,
)
from eai.tasks.source import DataMistake

COUNTS = {
    "virtualhome_goal_interpretation_outputs.json": 342,
    "virtualhome_subgoal_decomposition_outputs.json": 338,
    "virtualhome_action_sequencing_outputs.json": 342,
    "virtualhome_transition_modeling_outputs.json": 296,
    "behavior_goal_interpretation_outputs.json": 100,
    "behavior_subgoal_decomposition_outputs.json": 100,
    "behavior_action_sequencing_outputs.json": 100,
    "behavior_transition_modeling_outputs.json": 100,
}
FILE = "virtualhome_action_sequencing_outputs.json"
Rows = list[dict[str, object]]


@pytest.fixture(scope="module")
def complete(data_store: DataPackStore) -> dict[str, Rows]:
    """A complete submission."""
    return {
        file: [{"identifier": identifier, "llm_output": "{}"} for identifier in identifiers]
        for file, identifiers in get_task_identifiers_by_submission_file(data_store).items()
    }


def write(path: Path, files: dict[str, object], folder: str = "") -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(folder + name, content if isinstance(content, bytes) else json.dumps(content))
    return path


def test_a_submission_has_these_files(complete: dict[str, Rows]) -> None:
    assert {file: len(rows) for file, rows in complete.items()} == COUNTS


@pytest.mark.parametrize("folder", ["", "outputs/"])
@pytest.mark.parametrize("prefix", ["", "scene_1_"])
def test_complete_submissions_pass(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows], folder: str, prefix: str
) -> None:
    files = {
        file: [
            {**row, "identifier": prefix + str(row["identifier"]).removeprefix("scene_1_")} for row in rows
        ]
        for file, rows in complete.items()
    }
    assert check_submission(write(tmp_path / "s.zip", dict(files), folder), data_store) == []


def test_errors_of_files_have_the_order_of_the_zip(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows]
) -> None:
    extra = ["b.txt", "a.txt", "d.txt", "c.txt"]
    path = write(tmp_path / "s.zip", {**complete, **dict.fromkeys(extra)})
    assert [error.problem.split()[0] for error in check_submission(path, data_store)] == extra


def test_a_file_with_the_name_of_another_is_found(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows]
) -> None:
    path = write(tmp_path / "s.zip", dict(complete))
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
        archive.writestr(FILE, "[]")
    assert check_submission(path, data_store) == [DataMistake(FILE, "is there 2 times")]


@pytest.mark.parametrize(
    ("change", "problems"),
    [
        (lambda rows: rows[1:], ["27_2 is missing"]),
        (lambda rows: [*rows, rows[0]], ["27_2 is repeated"]),
        (lambda rows: [*rows, rows[0], rows[0]], ["27_2 is repeated"]),
        (lambda rows: [*rows, {"identifier": "0_0", "llm_output": "{}"}], ["0_0 is unknown"]),
        (lambda rows: [{"identifier": "27_2", "llm_output": " "}, *rows[1:]], ["27_2 is empty"]),
        (lambda rows: [{"identifier": "27_2"}, *rows[1:]], ["27_2 is empty"]),
        (
            lambda rows: [{"identifier": "27_2", "llm_output": {}}, *rows[1:]],
            ['27_2: "llm_output" is not a text'],
        ),
        (lambda rows: ["?", *rows[1:]], ['row 1 has no text "identifier"', "27_2 is missing"]),
        (lambda rows: {"rows": rows}, ['is not a list of {"identifier", "llm_output"}']),
        (lambda rows: b"[", ["is not JSON (Expecting value: line 1 column 2 (char 1))"]),
    ],
)
def test_every_bad_row_is_named(
    data_store: DataPackStore,
    tmp_path: Path,
    complete: dict[str, Rows],
    change: Callable[[Rows], object],
    problems: list[str],
) -> None:
    files = {**complete, FILE: change(complete[FILE])}
    found = check_submission(write(tmp_path / "s.zip", files), data_store)
    assert found == [DataMistake(FILE, problem) for problem in problems]


def test_missing_and_surplus_files_are_named(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows]
) -> None:
    files: dict[str, object] = {name: rows for name, rows in complete.items() if name != FILE}
    path = write(tmp_path / "s.zip", {**files, "readme.txt": b"hello"})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("again/behavior_action_sequencing_outputs.json", "[]")
    assert check_submission(path, data_store) == [
        DataMistake("s.zip", "readme.txt is not one of the files"),
        DataMistake(FILE, "is missing"),
        DataMistake("behavior_action_sequencing_outputs.json", "is there 2 times"),
    ]


def test_a_member_that_cannot_be_read_is_named_and_the_others_are_checked(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows]
) -> None:
    other = "behavior_action_sequencing_outputs.json"
    path = write(tmp_path / "s.zip", {**complete, other: b" " * 32_000_001})
    content = path.read_bytes()
    start = content.index(FILE.encode()) + len(FILE)
    path.write_bytes(content[:start] + b"?" + content[start + 1 :])
    found = check_submission(path, data_store)
    assert [finding.place for finding in found] == [FILE, other]
    assert found[0].problem.startswith("cannot be read (")
    assert found[1].problem == "holds more than 32,000,000 bytes"


def test_a_file_that_is_not_a_zip_is_refused(data_store: DataPackStore, tmp_path: Path) -> None:
    for path in (tmp_path / "none.zip", tmp_path):
        with pytest.raises(InputError, match="expected a zip that can be read"):
            check_submission(path, data_store)


def write_run(folder: Path, model: str, complete: dict[str, Rows]) -> None:
    """Write the answers of a run, with rows in reverse and without scene prefixes."""
    for file, rows in complete.items():
        domain, _, ability = file.removesuffix("_outputs.json").partition("_")
        place = folder / domain / ability / model
        place.mkdir(parents=True)
        plain = [{**row, "identifier": str(row["identifier"]).removeprefix("scene_1_")} for row in rows]
        (place / f"{model}_outputs.json").write_text(json.dumps(plain[::-1]))


def test_a_built_submission_is_complete_and_reproducible(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows]
) -> None:
    write_run(tmp_path / "run", "gpt", complete)
    build_submission(tmp_path / "run", tmp_path / "one.zip", data_store)
    build_submission(tmp_path / "run", tmp_path / "new" / "two.zip", data_store, model="gpt")
    build_submission(tmp_path / "run", tmp_path / "in_folder.zip", data_store, folder="outputs")
    assert check_submission(tmp_path / "one.zip", data_store) == []
    assert check_submission(tmp_path / "in_folder.zip", data_store) == []
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "new" / "two.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "one.zip") as archive:
        assert sorted(archive.namelist()) == sorted(COUNTS)
        assert json.loads(archive.read(FILE)) == complete[FILE]
    with zipfile.ZipFile(tmp_path / "in_folder.zip") as archive:
        assert all(name.startswith("outputs/") for name in archive.namelist())


def test_a_submission_needs_exactly_one_known_model(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows]
) -> None:
    for model in ("gpt", "llama"):
        write_run(tmp_path / "run", model, complete)
    with pytest.raises(InputError, match="expected the answers of one model, found gpt, llama"):
        build_submission(tmp_path / "run", tmp_path / "s.zip", data_store)
    with pytest.raises(InputError, match="no answers of a model named claude"):
        build_submission(tmp_path / "run", tmp_path / "s.zip", data_store, model="claude")


@pytest.mark.parametrize("name", ["..", "../other", "/other", "a/b", ""])
def test_the_folder_of_a_submission_is_not_a_path(
    data_store: DataPackStore, tmp_path: Path, complete: dict[str, Rows], name: str
) -> None:
    write_run(tmp_path / "run", "m", complete)
    with pytest.raises(InputError, match="expected the name of a folder"):
        build_submission(tmp_path / "run", tmp_path / "s.zip", data_store, folder=name)
    with pytest.raises(InputError, match="expected the name of a folder"):
        build_submission(tmp_path / "run", tmp_path / "s.zip", data_store, model=name)
    assert not (tmp_path / "s.zip").exists()


def test_the_prompts_of_a_phase_determine_the_expected_rows(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    asked = ["scene_1_27_2", "scene_2_22_1", "scene_7_135_2"]
    kit, run = tmp_path / "llm_prompts", tmp_path / "run/virtualhome/action_sequencing/m"
    for folder, name, key in (
        (kit, FILE.replace("outputs", "prompts"), "llm_prompt"),
        (run, "m_outputs.json", "llm_output"),
    ):
        folder.mkdir(parents=True)
        (folder / name).write_text(json.dumps([{"identifier": each, key: "{}"} for each in asked]))
    archive = tmp_path / "s.zip"
    build_submission(tmp_path / "run", archive, data_store, prompts=kit)
    assert check_submission(archive, data_store, kit) == []
    with zipfile.ZipFile(archive) as written:
        assert [row["identifier"] for row in json.loads(written.read(FILE))] == asked
    short = [{"identifier": each, "llm_output": "{}"} for each in [*asked[:2], "scene_2_1_1"]]
    assert check_submission(write(archive, {FILE: short}), data_store, kit) == [
        DataMistake(FILE, "scene_2_1_1 is unknown"),
        DataMistake(FILE, "scene_7_135_2 is missing"),
    ]


def test_a_prompts_folder_without_prompts_is_refused(data_store: DataPackStore, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a folder with <domain>_<ability>_prompts"):
        get_task_identifiers_by_submission_file(data_store, tmp_path)
