from __future__ import annotations

import os
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.results.responses import find_response_files
from eai.results.runs import find_record_files, read_runs, write_inspect_log_names_and_epoch
from record_files import write_records
from studies.report.samples import action_run, all_runs, goal_run, write_runs


def test_runs_are_found_in_folders_and_files(tmp_path: Path) -> None:
    folder = write_runs(tmp_path, all_runs())
    assert len(list(read_runs([folder]))) == 6
    assert len(list(read_runs([folder / "run0", folder / "run1" / "records.jsonl"]))) == 2
    assert len(list(read_runs([folder, folder]))) == 6


def test_links_to_folders_are_followed_once(tmp_path: Path) -> None:
    elsewhere = write_runs(tmp_path / "elsewhere", [action_run("first"), goal_run()])
    runs = tmp_path / "runs"
    runs.mkdir()
    (runs / "linked").symlink_to(elsewhere, target_is_directory=True)
    (runs / "again").symlink_to(elsewhere, target_is_directory=True)
    (elsewhere / "round").symlink_to(runs, target_is_directory=True)
    assert len(list(read_runs([runs]))) == 2


def test_one_file_may_hold_several_runs(tmp_path: Path) -> None:
    file = tmp_path / "all.jsonl"
    write_records(file, [*action_run(), *goal_run()])
    assert [len(run.records) for run in read_runs([file])] == [12, 4]


def test_runs_are_sorted_by_protocol_domain_ability_and_model(tmp_path: Path) -> None:
    keys = [run.key for run in read_runs([write_runs(tmp_path, all_runs())])]
    ordered = sorted(keys, key=lambda key: key.sort_key)
    assert [key.protocol.value for key in ordered] == ["strict"] * 5 + ["eai-1.0.5"]
    assert [key.model for key in ordered if key.ability.value == "action_sequencing"][:2] == [
        "first",
        "second",
    ]


def test_a_run_with_two_records_of_a_task_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "merged.jsonl"
    write_records(file, [*goal_run(), goal_run()[1]])
    with pytest.raises(InputError, match=r"merged.jsonl: the run first.* has 2 records of task 1_1"):
        list(read_runs([file]))


def test_unusable_record_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    blank = tmp_path / "records.jsonl"
    blank.write_text("\n")
    twice = write_runs(tmp_path / "twice", [goal_run(), goal_run()])
    for paths, words in (
        ([tmp_path / "none"], "no such file"),
        ([tmp_path / "empty"], "found none"),
        ([blank], "at least one record"),
        ([twice], "is also in"),
    ):
        with pytest.raises(InputError, match=words):
            list(read_runs(paths))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_in_a_folder_is_ignored(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "records.jsonl")
    os.mkfifo(tmp_path / "m_outputs.json")
    with pytest.raises(InputError, match=r"somewhere below, found none"):
        find_record_files([tmp_path])
    with pytest.raises(InputError, match="found none"):
        find_response_files(tmp_path)


def test_a_run_reads_the_log_reference_beside_its_records(tmp_path: Path) -> None:
    folder = write_runs(tmp_path, [action_run()])
    assert [run.log for run in read_runs([folder])] == [None]
    write_inspect_log_names_and_epoch(folder / "run0", {"27_2": Path("logs/a.eval")}, 2)
    assert [run.log for run in read_runs([folder])] == [("a.eval", 2)]
    logs = {"27_2": Path("logs/a.eval"), "28_1": Path("logs/b.eval")}
    write_inspect_log_names_and_epoch(folder / "run0", logs, {"27_2": 3})
    names = {"27_2": "a.eval", "28_1": "b.eval"}
    assert [run.log for run in read_runs([folder])] == [(names, {"27_2": 3})]
    (folder / "run0" / "inspect.json").write_text("{}")
    with pytest.raises(InputError, match=r'inspect.json: expected a JSON object {"log": ..., "epoch": ...}'):
        list(read_runs([folder]))
