"""The files of results: records, one JSON object a line, their summary, and the shards of a run.

A run may be scored in shards, each by a job of its own, which are put together again.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain, zip_longest
from pathlib import Path
from typing import NamedTuple, TypeVar

from eai.abilities.codec import SCHEMA, experiment_to_json, record_from_json, record_to_json
from eai.abilities.record import Record
from eai.abilities.verdict import Json
from eai.data.files import files_below, write_whole
from eai.errors import InputError
from eai.results.coverage import coverage_of, errata_effect, planners_of
from eai.results.rate import Rate
from eai.results.summary import by_attempt, summarise


def write_records(path: Path, records: Iterable[Record]) -> None:
    """Write one record a line.

    Raises:
        InputError: the file cannot be written.
    """
    write_whole({path: (f"{line_of(record)}\n" for record in records)})


def line_of(record: Record) -> str:
    """A record as a file has it, without the end of the line."""
    return json.dumps(record_to_json(record), ensure_ascii=True)


def read_records(path: Path) -> Iterator[Record]:
    """Read a file of records.

    Raises:
        InputError: the file cannot be read, a line is not a record, or its answer is not the one that was
            scored.
    """
    try:
        with path.open(encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                if line.strip():
                    yield _parse(f"{path}, line {number}", line)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: expected a readable records.jsonl ({error})") from error


def _parse(place: str, line: str) -> Record:
    try:
        values = json.loads(line, strict=False)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{place}: expected a JSON object ({error})") from error
    if not isinstance(values, dict):
        raise InputError(f"{place}: expected a JSON object")
    schema = values.get("schema")
    if schema != SCHEMA:
        raise InputError(f"{place}: schema {schema!r}, expected {SCHEMA}")
    try:
        return record_from_json(values)
    except InputError as error:
        raise InputError(f"{place}: {error}") from error


SUMMARY = "summary.json"
RECORDS = "records.jsonl"


def write_results(
    folder: Path, records: list[Record], rates: Mapping[str, Rate], run: Mapping[str, Json] | None = None
) -> None:
    """Write the records and the summary of one model; ``run`` is what the summary says of a run besides.

    Raises:
        InputError: the folder cannot be written.
    """
    first, errata = records[0], errata_effect(records)
    planners = planners_of(record.verdict for record in records)
    summary: dict[str, Json] = {
        "protocol": first.protocol.value,
        "domain": first.domain,
        "ability": first.ability.value,
        "model": first.model,
        **({} if first.experiment is None else {"experiment": experiment_to_json(first.experiment)}),
        "data_sha256": first.data_sha256,
        "errata": None if errata is None else errata.to_json(),
        "coverage": coverage_of(records).to_json(),
        **({"planner": ", ".join(planners)} if planners else {}),
        "unit": "percent",
        **({} if run is None else {"run": run}),
        **{name: rate.to_json() for name, rate in rates.items()},
    }
    stages = by_attempt(records)
    if stages:
        summary["by_attempt"] = [{name: rate.to_json() for name, rate in each.items()} for each in stages]
    lines = (f"{line_of(record)}\n" for record in records)
    write_whole({folder / RECORDS: lines, folder / SUMMARY: json.dumps(summary, indent=2) + "\n"})


T = TypeVar("T")

_WRITTEN = re.compile(r"([0-9]+)/([0-9]+)")
_FILE = re.compile(r"records\.shard-([0-9]+)-of-([0-9]+)\.jsonl")


class Shard(NamedTuple):
    """One of several equal parts: of every ``of`` tasks in order the ``number``-th, counted from 1."""

    number: int
    of: int

    @staticmethod
    def parse(text: str) -> Shard:
        """The shard that a text such as ``2/8`` means.

        Raises:
            InputError: it is no such text.
        """
        found = _WRITTEN.fullmatch(text)
        if found is None or not 1 <= int(found[1]) <= int(found[2]):
            raise InputError(f"{text!r} is no shard: expected I/N, such as 2/8, from 1/8 to 8/8")
        return Shard(int(found[1]), int(found[2]))

    def of_these(self, items: Sequence[T]) -> Sequence[T]:
        """Its part of some items."""
        return items[self.number - 1 :: self.of]

    @property
    def file_name(self) -> str:
        """The name of the file of its records."""
        return f"records.shard-{self.number}-of-{self.of}.jsonl"


def write_shard(folder: Path, shard: Shard, records: Iterable[Record]) -> None:
    """Write the records of a shard; its file is there when it is whole.

    Raises:
        InputError: the folder cannot be written.
    """
    write_records(folder / shard.file_name, records)


def find_shards(path: Path) -> dict[Path, list[Path]]:
    """The folders below a folder that hold shards, each with its files in order.

    Raises:
        InputError: there is none, or one lacks a shard or has those of two runs.
    """
    folders: dict[Path, dict[Shard, Path]] = {}
    for file in files_below(path, "records.shard-*.jsonl"):
        found = _FILE.fullmatch(file.name)
        if found is not None:
            folders.setdefault(file.parent, {})[Shard(int(found[1]), int(found[2]))] = file
    if not folders:
        raise InputError(f"{path}: expected a folder with records.shard-I-of-N.jsonl below, found none")
    for folder, files in folders.items():
        numbers = {shard.of for shard in files}
        if len(numbers) > 1:
            named = " and of ".join(map(str, sorted(numbers)))
            raise InputError(f"{folder}: expected the shards of one run, found some of {named}")
        of = numbers.pop()
        missing = [str(number) for number in range(1, of + 1) if Shard(number, of) not in files]
        if missing:
            raise InputError(f"{folder}: of {of} shards there is no {', '.join(missing)}")
    return {folder: [files[shard] for shard in sorted(files)] for folder, files in folders.items()}


def merge_shards(folder: Path, files: Sequence[Path]) -> list[Record]:
    """Write records and summary of the run of which these are all shards: the bytes of a run in one part.

    Raises:
        InputError: a file is not one of records or not of this run, or the folder cannot be written.
    """
    records = list(_in_turn([list(read_records(file)) for file in files], folder))
    first = records[0]
    for record in records:
        if _made_of(record) != _made_of(first):
            raise InputError(f"{folder}: expected the shards of one run, found {first.model}, {record.model}")
    write_results(folder, records, summarise([record.verdict for record in records], first.ability))
    return records


def _made_of(record: Record) -> tuple[str, str, str | None]:
    """The common part of all records of a run: model, data, version of their errata."""
    return record.model, record.data_sha256, None if record.errata is None else record.errata.version


def _in_turn(parts: Sequence[Sequence[Record]], folder: Path) -> Iterator[Record]:
    """One record of each part after the other, as `Shard.of_these` dealt them out."""
    counts = [len(part) for part in parts]
    if counts != sorted(counts, reverse=True) or counts[0] - counts[-1] > 1 or not counts[0]:
        raise InputError(f"{folder}: expected equal shards, found {', '.join(map(str, counts))} records")
    return (record for record in chain.from_iterable(zip_longest(*parts)) if record is not None)
