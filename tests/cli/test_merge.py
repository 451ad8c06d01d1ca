"""Runs in parts, by jobs of their own or by workers: the same bytes as in one part by one process."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import pytest

from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from protocols import EACH_PROTOCOL
from suites import answer_book

SUITE = ("--domain", "behavior", "--ability", "action_sequencing", "--no-explanations")


@pytest.fixture(autouse=True)
def folder(data_store: DataPackStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, with the answers of two models. One model did not answer all tasks."""
    monkeypatch.setenv("EAI_DATA_DIR", str(data_store.folder))
    monkeypatch.chdir(tmp_path)
    book = answer_book("behavior", Ability.ACTION_SEQUENCING)
    for model, task_ids in (("whole", tuple(book)), ("part", [*book][5:40])):
        rows = [{"identifier": task_id, "llm_output": book[task_id].text} for task_id in task_ids]
        (tmp_path / "answers").mkdir(exist_ok=True)
        (tmp_path / "answers" / f"{model}_outputs.json").write_text(json.dumps(rows))
    return tmp_path


def written(folder: Path) -> Mapping[str, bytes]:
    """The results in a folder, without what shards left."""
    names = ("records.jsonl", "summary.json")
    return {str(file.relative_to(folder)): file.read_bytes() for name in names for file in folder.rglob(name)}


@EACH_PROTOCOL
def test_parts_together_are_the_bytes_of_a_run_in_one_part(eai: Command, folder: Path, protocol: str) -> None:
    rules = (*SUITE, "--protocol", protocol)
    assert eai("score", "answers", *rules, "--out", "one").status == 0
    for number in (3, 1, 2):
        workers = ("--workers", 2) if number == 2 else ()
        assert (
            eai("score", "answers", *rules, "--shard", f"{number}/3", *workers, "--out", "parts").status == 0
        )
    assert written(folder / "parts") == {}
    done = eai("score", "parts", "--merge")
    assert done.status == 0
    assert "3 shards of 100 records written to parts/whole" in done.out
    assert eai("score", "answers", *rules, "--workers", 3, "--out", "workers").status == 0
    assert written(folder / "one")
    assert written(folder / "one") == written(folder / "parts") == written(folder / "workers")


def test_what_is_not_whole_is_not_merged(eai: Command, folder: Path) -> None:
    assert "expected a folder with records.shard-I-of-N.jsonl" in eai("score", "answers", "--merge").err
    for number in (1, 3):
        eai("score", "answers/whole_outputs.json", *SUITE, "--shard", f"{number}/4", "--out", "parts")
    done = eai("score", "parts", "--merge")
    assert (done.status, done.err) == (2, "eai: parts: of 4 shards these are missing: 2, 4; score them\n")
    for number in (2, 4):
        eai("score", "answers/whole_outputs.json", *SUITE, "--shard", f"{number}/4", "--out", "parts")
    part = Path("parts/records.shard-2-of-4.jsonl")
    whole = part.read_text()
    part.write_text("".join(whole.splitlines(keepends=True)[:-3]))
    unequal = (
        "expected equal numbers of records in all shards, or one less in the last ones, found 25, 22, 25, 25"
    )
    assert unequal in eai("score", "parts", "--merge").err
    part.write_text(whole.replace('"model": "whole"', '"model": "other"'))
    assert (
        "expected the shards of one run, found model whole and model other"
        in eai("score", "parts", "--merge").err
    )
    part.write_text(whole)
    eai("score", "answers/whole_outputs.json", *SUITE, "--shard", "1/2", "--out", "parts")
    assert "expected the shards of one run, found some of 2 and of 4" in eai("score", "parts", "--merge").err


def test_a_shard_is_to_be_kept(eai: Command) -> None:
    done = eai("score", "answers", *SUITE, "--shard", "1/2")
    assert (done.status, "also give --out" in done.err) == (2, True)
