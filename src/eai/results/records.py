"""The files of results: records, one JSON object a line, their summary, and the shards of a run.

A run may be scored in shards, each by a job of its own, which are put together again.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar

from pydantic_core import from_json

from eai.abilities.verdict import Verdict
from eai.base.errors import InputError, prefix_errors
from eai.base.files import files_below, require_file, write_whole
from eai.base.json_value import Json
from eai.results.codec import READABLE, experiment_to_json, record_from_json, record_to_json
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.totals import Totals

if TYPE_CHECKING:
    from eai.benchmarks.suite import Suite


def make_record(
    suite: Suite, model: str, task_id: str, response: str, verdict: Verdict, **more: Any
) -> Record:
    """The record of an answer to a task of a suite; ``more`` are its further fields."""
    return Record(
        suite.protocol,
        suite.domain,
        suite.ability,
        model,
        task_id,
        response,
        suite.data_sha256,
        verdict,
        suite_size=len(suite.task_ids),
        errata=suite.errata.use(suite.ability, task_id),
        **more,
    )


def record_line(record: Record) -> str:
    """A record as a file has it, without the end of the line."""
    return json.dumps(record_to_json(record), ensure_ascii=True)


def read_records(path: Path) -> Iterator[Record]:
    """Read a file of records.

    Raises:
        InputError: the file cannot be read, a line is not a record, or its answer is not the one that was
            scored.
    """
    for number, line in enumerate(_lines(path), 1):
        if line.strip():
            with prefix_errors(f"{path}, line {number}"):
                record = _parse(line)
            yield record


def _lines(path: Path) -> Iterator[str]:
    require_file(path)
    try:
        with path.open(encoding="utf-8") as file:
            yield from file
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: expected a readable records.jsonl ({error})") from error


def _parse(line: str) -> Record:
    try:
        values = _loaded(line)
    except (ValueError, RecursionError) as error:
        raise InputError(f"expected a JSON object ({error})") from error
    if not isinstance(values, dict):
        raise InputError("expected a JSON object")
    schema = values.get("schema")
    if schema not in READABLE:
        raise InputError(f"schema {schema!r}, expected {' or '.join(map(str, READABLE))}")
    return record_from_json(values)


def _loaded(line: str) -> Any:
    """JSON; what the faster reader does not take, such as half a surrogate, the other one does."""
    try:
        return from_json(line)
    except ValueError:
        return json.loads(line, strict=False)


SUMMARY = "summary.json"
RECORDS = "records.jsonl"

MAX_BATCH_RECORDS = 256
"""How many records are made ready at a time."""


RecordBatch: TypeAlias = tuple[bytes, Totals]
"""Some records of a run, one after the other: their lines as a file has them, and their totals."""


def make_record_batch(records: Sequence[Record]) -> RecordBatch:
    """Records that are ready to be written."""
    return b"".join([record_line(record).encode() + b"\n" for record in records]), Totals.from_records(
        records
    )


def write_record_batches(
    folder: Path,
    parts: Iterable[RecordBatch],
    run: Mapping[str, Json] | None = None,
    stages: Sequence[Mapping[str, Rate]] = (),
) -> Totals:
    """Write the records of one model part by part as they come, none of which is kept, and their summary.

    Args:
        folder: where to.
        parts: the records in their order.
        run: what the summary says of a run besides.
        stages: the rates after each attempt, where a task has several.

    Raises:
        InputError: the folder cannot be written.
    """
    totals = Totals()

    def lines() -> Iterator[bytes]:
        for written, part in parts:
            totals.merge(part)
            yield written

    def summary() -> Iterator[str]:
        yield json.dumps(_summary(totals, run or {}, stages), indent=2) + "\n"

    write_whole({folder / RECORDS: lines(), folder / SUMMARY: summary()})
    return totals


_IF_ANY = frozenset({"planner", "run", "by_attempt"})
"""The fields of a summary that are left out where there is nothing to say."""


def _summary(
    totals: Totals, run: Mapping[str, Json], stages: Sequence[Mapping[str, Rate]]
) -> Mapping[str, Json]:
    first, errata = totals.first, totals.errata
    fields: dict[str, Json] = {
        "protocol": first.protocol.value,
        "domain": first.domain,
        "ability": first.ability.value,
        "model": first.model,
        **({} if first.experiment is None else experiment_to_json(first.experiment)),
        "data_sha256": first.data_sha256,
        "errata": None if errata is None else errata.to_json(),
        "coverage": totals.coverage.to_json(),
        "planner": ", ".join(totals.planners),
        "unit": "percent",
        "run": run,
        **{name: rate.to_json() for name, rate in totals.rates.items()},
        "by_attempt": [{name: rate.to_json() for name, rate in each.items()} for each in stages],
    }
    return {name: value for name, value in fields.items() if value or name not in _IF_ANY}


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

    def select(self, items: Iterable[T]) -> Iterator[T]:
        """Its part of some items."""
        return islice(items, self.number - 1, None, self.of)

    @property
    def file_name(self) -> str:
        """The name of the file of its records."""
        return f"records.shard-{self.number}-of-{self.of}.jsonl"


def write_shard(folder: Path, shard: Shard, parts: Iterable[RecordBatch]) -> None:
    """Write the records of a shard; its file is there when it is whole.

    Raises:
        InputError: the folder cannot be written.
    """
    write_whole({folder / shard.file_name: (lines for lines, _ in parts)})


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


def merge_shards(folder: Path, files: Sequence[Path]) -> Totals:
    """Write records and summary of the run of which these are all shards: the bytes of a run in one part.

    Raises:
        InputError: a file is not one of records or not of this run, or the folder cannot be written.
    """
    counts = [sum(not line.isspace() for line in _lines(file)) for file in files]
    if counts != sorted(counts, reverse=True) or counts[0] - counts[-1] > 1 or not counts[0]:
        raise InputError(f"{folder}: expected equal shards, found {', '.join(map(str, counts))} records")
    return write_record_batches(folder, map(make_record_batch, _in_turn(files, folder)))


def _in_turn(files: Sequence[Path], folder: Path) -> Iterator[Sequence[Record]]:
    """A record of each shard one after the other, as `Shard.of_these` dealt them out, a round at a time."""
    first: Record | None = None
    for dealt in zip_longest(*map(read_records, files)):
        round_ = [record for record in dealt if record is not None]
        first = first or round_[0]
        for record in round_:
            if _made_of(record) != _made_of(first):
                raise InputError(
                    f"{folder}: expected the shards of one run, found {first.model}, {record.model}"
                )
        yield round_


def _made_of(record: Record) -> tuple[str, str, str | None]:
    """The common part of all records of a run: model, data, version of their errata."""
    return record.model, record.data_sha256, None if record.errata is None else record.errata.version
