"""Several answers to a task in one file: read, scored and written in batches, in any process."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.results.batch import NO_ROW, Scoring
from eai.results.options import ScoringOptions
from eai.results.parquet import import_parquet
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.records import (
    RECORDS,
    SUMMARY,
    RunShard,
    find_shards,
    merge_shards,
    write_record_batches,
)
from eai.results.responses import Response, ResponseFile, read_responses
from eai.results.runs import read_runs
from eai.results.totals import RunTotals
from record_files import write_shard
from results.work import TASK_IDS, echo_suite

SAMPLES = 100
ROWS = [
    {
        "identifier": task_id,
        "sample": sample,
        "llm_output": f"answer to {task_id if sample % 4 else 'nothing'}",
    }
    for sample in range(SAMPLES)
    for task_id in TASK_IDS[1:]
]


def written(folder: Path, rows: Sequence[Mapping[str, object]] = ROWS, ending: str = ".jsonl") -> Path:
    file = folder / f"m_outputs{ending}"
    if ending == ".parquet":
        pyarrow = pytest.importorskip("pyarrow")
        import_parquet().write_table(pyarrow.Table.from_pylist(rows), file)
    else:
        text = json.dumps(rows) if ending == ".json" else "\n\n".join(map(json.dumps, rows))
        file.write_text(text)
    return file


def read(file: Path) -> ResponseFile:
    return read_responses(file, TASK_IDS, echo_suite().benchmark.data.task_id_of, samples=True)


def scored(
    answers: ResponseFile, folder: Path, workers: int = 1, shard: RunShard | None = None
) -> RunTotals | None:
    settings, missing = ScoringOptions(explanations=True), {TASK_IDS[0]: NO_ROW}
    with Scoring(workers) as scoring:
        parts = scoring.score_in_batches(echo_suite(), answers, missing, settings, shard=shard)
        if shard is None:
            return write_record_batches(folder, parts)
        write_shard(folder, shard, parts)
        return None


def contents(folder: Path) -> tuple[bytes, bytes]:
    return (folder / RECORDS).read_bytes(), (folder / SUMMARY).read_bytes()


def test_every_sample_counts_and_a_task_without_any_fails(tmp_path: Path) -> None:
    totals = scored(read(written(tmp_path)), tmp_path)
    assert totals is not None
    assert totals.rates["task_success"] == Rate(6 * SAMPLES * 3 // 4, 6 * SAMPLES + 1)
    assert str(totals.coverage) == "6/7"
    lines = [json.loads(line) for line in (tmp_path / RECORDS).read_text().splitlines()]
    assert [(line["task_id"], line.get("sample")) for line in lines] == [
        *((row["identifier"], row["sample"]) for row in ROWS),
        (TASK_IDS[0], None),
    ]


def test_file_format_and_number_of_workers_do_not_change_records(tmp_path: Path) -> None:
    scored(read(written(tmp_path)), tmp_path / "one")
    for ending, workers in ((".jsonl", 2), (".json", 1), (".parquet", 2)):
        scored(read(written(tmp_path, ending=ending)), tmp_path / ending, workers)
        assert contents(tmp_path / ending) == contents(tmp_path / "one")
    for number in (1, 2, 3):
        scored(read(tmp_path / "m_outputs.jsonl"), tmp_path / "parts", shard=RunShard(number, 3))
    merge_shards(tmp_path / "parts", find_shards(tmp_path)[tmp_path / "parts"])
    assert contents(tmp_path / "parts") == contents(tmp_path / "one")


@pytest.mark.parametrize(
    ("row", "complaint"),
    [
        ({**ROWS[0]}, "row 601: sample 0 of identifier '1_1' occurs twice"),
        ({**ROWS[0], "sample": None}, 'row 601: "sample" must be a whole number from 0 to 9999999'),
        ({**ROWS[0], "sample": -1}, 'row 601: "sample" must be a whole number'),
        ({**ROWS[0], "sample": True}, 'row 601: "sample" must be a whole number'),
        ({**ROWS[0], "identifier": "x"}, "row 601: identifier 'x' is not one of the tasks"),
    ],
    ids=["twice", "missing", "negative", "no number", "unknown"],
)
def test_a_bad_row_is_reported_before_scoring_begins(
    row: Mapping[str, object], complaint: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=complaint):
        read(written(tmp_path, [*ROWS, row]))


def test_commands_for_one_answer_a_task_refuse_several(tmp_path: Path) -> None:
    file = written(tmp_path)
    with pytest.raises(InputError, match="row 7: identifier '1_1' occurs twice"):
        read_responses(file, TASK_IDS)
    scored(read(file), tmp_path)
    several = "has several answers to a task; give records with one answer to each task"
    with pytest.raises(InputError, match=several):
        list(read_runs([tmp_path]))
    twice = tmp_path / "twice"
    scored(read(written(tmp_path, [{**ROWS[0], "sample": number} for number in range(2)])), twice)
    with pytest.raises(InputError, match=several):
        list(read_runs([twice]))


def test_totals_of_parts_add_up_to_the_totals_of_the_run() -> None:
    records: list[Record] = [*Scoring().score_records(echo_suite(), "m", read_some())]
    whole, parts = RunTotals.from_records(records), RunTotals()
    for start in range(0, len(records), 3):
        parts.add_totals_of_later_records(
            RunTotals.from_records(replace(each) for each in records[start : start + 3])
        )
    assert parts == whole


def read_some() -> Sequence[Response]:
    return [Response(task_id, f"answer to {task_id}") for task_id in TASK_IDS]
