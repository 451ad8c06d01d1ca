from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import InputError
from eai.benchmarks.errata import ApplicableErrata
from eai.results.record import Record
from eai.results.records import (
    RunShard,
    find_shards,
    make_record_batch,
    merge_shards,
    read_records,
)
from eai.results.totals import RunTotals
from record_files import write_shard


@pytest.mark.parametrize(
    ("text", "shard"), [("1/1", RunShard(1, 1)), ("2/8", RunShard(2, 8)), ("8/8", RunShard(8, 8))]
)
def test_shards_are_counted_from_one(text: str, shard: RunShard) -> None:
    assert RunShard.parse(text) == shard
    assert shard.records_file_name == f"records.shard-{shard.number}-of-{shard.of}.jsonl"


@pytest.mark.parametrize("text", ["", "0/3", "4/3", "1", "1/0", "-1/3", "a/b", "1/3/5", f"1/{'9' * 5000}"])
def test_an_invalid_shard_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="is no shard: expected I/N"):
        RunShard.parse(text)


@pytest.mark.parametrize("of", [1, 2, 3, 10])
def test_every_item_is_in_one_shard(of: int) -> None:
    parts = [[*RunShard(number, of).select_items_of_shard(range(7))] for number in range(1, of + 1)]
    assert sorted(item for part in parts for item in part) == list(range(7))
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


def record(task_id: str) -> Record:
    verdict = PlanVerdict(executable=True, success=True)
    return Record(Protocol.STRICT, "lamps", Ability.ACTION_SEQUENCING, "m", task_id, "[]", "0" * 64, verdict)


RECORDS = [record(str(number)) for number in range(5)]


def test_shards_are_found_in_order_and_merged_unchanged(tmp_path: Path) -> None:
    for number in (3, 1, 2):
        shard = RunShard(number, 3)
        write_shard(tmp_path / "run", shard, [make_record_batch([*shard.select_items_of_shard(RECORDS)])])
    (tmp_path / "run" / "records.shard-1-of-x.jsonl").touch()
    found = find_shards(tmp_path)
    assert found == {
        tmp_path / "run": [tmp_path / "run" / RunShard(n, 3).records_file_name for n in (1, 2, 3)]
    }
    assert merge_shards(tmp_path, found[tmp_path / "run"]) == RunTotals.from_records(RECORDS)
    assert list(read_records(tmp_path / "records.jsonl")) == RECORDS


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ([], "expected a folder with records.shard-I-of-N.jsonl below, found none"),
        ([RunShard(1, 2), RunShard(1, 3)], "expected the shards of one run, found some of 2 and of 3"),
        ([RunShard(2, 4), RunShard(4, 4)], "of 4 shards these are missing: 1, 3"),
    ],
)
def test_a_missing_shard_is_reported(given: Sequence[RunShard], told: str, tmp_path: Path) -> None:
    for shard in given:
        write_shard(tmp_path, shard, [make_record_batch(RECORDS)])
    with pytest.raises(InputError, match=told):
        find_shards(tmp_path)


@pytest.mark.parametrize(
    ("change", "different"),
    [
        ({"model": "n"}, "model m and model n"),
        ({"data_sha256": "1" * 64}, f"data_sha256 {'0' * 64} and data_sha256 {'1' * 64}"),
        ({"errata": ApplicableErrata("2")}, "errata 1 and errata 2"),
        ({"errata": None}, "errata 1 and errata None"),
        ({"protocol": Protocol("eai-1.0.5")}, "protocol strict and protocol eai-1.0.5"),
        ({"domain": "switches"}, "domain lamps and domain switches"),
        (
            {"ability": Ability.SUBGOAL_DECOMPOSITION, "verdict": SubgoalVerdict(success=True)},
            "ability action_sequencing and ability subgoal_decomposition",
        ),
        ({"suite_size": 7}, "suite_size None and suite_size 7"),
        ({"experiment": Experiment(rules="slip-0.5")}, "experiment None and experiment rules-slip-0.5"),
    ],
)
def test_shards_of_different_runs_are_not_merged(
    change: dict[str, Any], different: str, tmp_path: Path
) -> None:
    first, second = [[replace(each, errata=ApplicableErrata("1"))] for each in RECORDS[:2]]
    for number, records in ((1, first), (2, [replace(second[0], **change)])):
        write_shard(tmp_path, RunShard(number, 2), [make_record_batch(records)])
    with pytest.raises(InputError, match=f"expected the shards of one run, found {different}$"):
        merge_shards(tmp_path, find_shards(tmp_path)[tmp_path])


def test_shards_of_episodes_in_several_harnesses_are_merged(tmp_path: Path) -> None:
    told = [
        replace(each, experiment=Experiment(harness=harness))
        for each, harness in zip(RECORDS, ("react", "text"), strict=False)
    ]
    for number in (1, 2):
        write_shard(tmp_path, RunShard(number, 2), [make_record_batch(told[number - 1 : number])])
    assert merge_shards(tmp_path, find_shards(tmp_path)[tmp_path]).record_count == len(told)


def test_shards_with_the_same_errata_version_are_merged(tmp_path: Path) -> None:
    told = [replace(each, errata=ApplicableErrata("1", (each.task_id,))) for each in RECORDS[:2]]
    for number in (1, 2):
        write_shard(tmp_path, RunShard(number, 2), [make_record_batch(told[number - 1 : number])])
    assert merge_shards(tmp_path, find_shards(tmp_path)[tmp_path]).record_count == len(told)
    assert list(read_records(tmp_path / "records.jsonl")) == told


@pytest.mark.parametrize("sizes", [(1, 2), (3, 1), (0, 0)])
def test_files_of_unequal_shards_are_not_merged(sizes: tuple[int, int], tmp_path: Path) -> None:
    for number, size in enumerate(sizes, 1):
        write_shard(tmp_path, RunShard(number, 2), [make_record_batch(RECORDS[:size])])
    with pytest.raises(
        InputError,
        match="expected equal numbers of records in all shards, or one less in the last ones, "
        f"found {sizes[0]}, {sizes[1]}",
    ):
        merge_shards(tmp_path, find_shards(tmp_path)[tmp_path])
