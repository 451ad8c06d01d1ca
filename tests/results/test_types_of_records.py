"""Records as tables: each field has one type in the records of all suites and studies."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from eai.abilities.attempt import AnswerUsage, Attempt
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.json_value import Json
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import score_run
from eai.results.options import ScoringOptions
from eai.results.record import AnswerOrigin, Record
from eai.results.responses import Response, ResponseFile
from eai.tasks.source import Source
from experiments import experiment
from record_files import write_records
from suites import SUITES, answer_book

pytestmark = pytest.mark.usefixtures("data_store")


@cache
def records_of(folder: Path, name: str, ability: Ability) -> tuple[Record, ...]:
    """Return records of right answers, of other tasks' answers, and of an unreadable answer."""
    store = DataPackStore(folder)
    suite = open_suite(name, ability, source=Source(store, planner=PlannerChoice.BUILT_IN))
    task_ids = suite.task_ids[:60:5]
    book = answer_book(name, ability, store)
    texts = [book[task_id].text for task_id in task_ids]
    swapped = [*texts[:6], *texts[7:], "no answer"]
    responses = tuple([Response(*pair) for pair in zip(task_ids, swapped, strict=True)])
    found = score_run(suite, ResponseFile("m", responses), {}, ScoringOptions())
    usages = (AnswerUsage(), AnswerUsage(3, 4, 1, 0.5, 2.0))
    return tuple([replace(each, origin=AnswerOrigin(usage=usages[i % 2])) for i, each in enumerate(found)])


def all_records(folder: Path) -> Iterator[Record]:
    for name, ability in SUITES:
        yield from records_of(folder, name, ability)
    for record in records_of(folder, "virtualhome", Ability.ACTION_SEQUENCING):
        assert isinstance(record.verdict, PlanVerdict)
        attempt = Attempt(
            record.response, record.verdict, usage=AnswerUsage(), explanation=record.explanation
        )
        yield replace(record, attempts=(attempt, attempt), experiment=experiment(replans=1))


def kinds(value: Json, place: str = "") -> Iterator[tuple[str, str]]:
    """Return the types of all parts of a value by their paths; null fits any type."""
    if value is not None:
        yield place, type(value).__name__
    if isinstance(value, dict):
        for name, part in value.items():
            yield from kinds(part, f"{place}.{name}")
    elif isinstance(value, list):
        for part in value:
            yield from kinds(part, f"{place}[]")


def test_a_field_has_one_type_in_the_records_of_all_suites(data_store: DataPackStore, tmp_path: Path) -> None:
    write_records(tmp_path / "records.jsonl", all_records(data_store.folder))
    lines = (tmp_path / "records.jsonl").read_text().splitlines()
    types: dict[str, set[str]] = {}
    for line in lines:
        for place, kind in kinds(json.loads(line)):
            types.setdefault(place, set()).add(kind)
    assert {place: names for place, names in types.items() if len(names) > 1} == {}
    assert types[".goals.state[]"] == types[".usage.cost"] == {"float"}
    assert types[".explanation.steps[].call"] == types[".explanation.atoms[]"] == {"dict"}


@pytest.mark.parametrize(("name", "ability"), [*SUITES, (None, None)])
def test_records_load_in_arrow(
    data_store: DataPackStore, tmp_path: Path, name: str | None, ability: Ability | None
) -> None:
    reader = pytest.importorskip("pyarrow.json")
    file = tmp_path / "records.jsonl"
    if name is None or ability is None:
        write_records(file, all_records(data_store.folder))
    else:
        write_records(file, records_of(data_store.folder, name, ability))
    table = reader.read_json(file, reader.ReadOptions(block_size=file.stat().st_size))
    assert table.num_rows == len(file.read_text().splitlines())


def test_records_load_in_datasets_of_hugging_face(data_store: DataPackStore, tmp_path: Path) -> None:
    datasets = pytest.importorskip("datasets")
    file = tmp_path / "records.jsonl"
    written = records_of(data_store.folder, "virtualhome", Ability.ACTION_SEQUENCING)
    write_records(file, written)
    loaded = datasets.load_dataset("json", data_files=str(file), split="train", cache_dir=str(tmp_path))
    assert loaded["task_id"] == [record.task_id for record in written]
