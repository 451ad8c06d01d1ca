"""Reads and writes result files: scored answers (one JSON record a line), their summary, and shards of runs.

A run may be scored in shards (parts), each by a job of its own. The files of all shards are then merged.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar

from pydantic_core import from_json

from eai.abilities.experiment import Experiment
from eai.abilities.protocol import DEFAULT_PROTOCOL
from eai.abilities.verdict import Verdict
from eai.base.errors import InputError, prefix_errors_with_location
from eai.base.files import find_files_below, require_file, write_files_atomically
from eai.base.json_value import Json
from eai.results.codec import READABLE_SCHEMAS, SCHEMA, experiment_to_json, record_from_json, record_to_json
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.totals import RunTotals

if TYPE_CHECKING:
    from eai.benchmarks.suite import Suite


def make_record(
    suite: Suite, model: str, task_id: str, response: str, verdict: Verdict, **more: Any
) -> Record:
    """Return the record of a scored answer to a task; keyword arguments are further fields."""
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
        errata=suite.errata.find_errata_of_task(suite.ability, task_id),
        **more,
    )


def format_record_line(record: Record) -> str:
    """Return a record (scored answer) as a line of a file, without the line feed."""
    return json.dumps(record_to_json(record), ensure_ascii=True)


def read_records(path: Path) -> Iterator[Record]:
    """Yield the records of a file.

    Raises:
        InputError: the file cannot be read, a line is not a record, its answer is not the one that was
            scored, or its verdict contradicts itself.
    """
    for number, line in enumerate(_read_lines_of_records(path), 1):
        if line.strip():
            with prefix_errors_with_location(f"{path}, line {number}"):
                record = _parse_record(line)
            yield record


_REMEDY = "; eai score makes records of answers"
"""End of messages about a line that is not a record: often, the file has answers instead of records."""


def _read_lines_of_records(path: Path) -> Iterator[str]:
    require_file(path)
    try:
        with path.open(encoding="utf-8") as file:
            yield from file
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: expected a readable records.jsonl ({error})") from error


def _parse_record(line: str) -> Record:
    try:
        values = _load_json(line)
    except (ValueError, RecursionError) as error:
        raise InputError(f"expected a JSON object ({error}){_REMEDY}") from error
    if not isinstance(values, dict) or "schema" not in values:
        raise InputError(f"expected a record of a scored answer{_REMEDY}")
    schema = values.get("schema")
    if schema not in READABLE_SCHEMAS:
        raise InputError(
            f"schema {schema!r} cannot be read; expected {' or '.join(map(str, READABLE_SCHEMAS))}: "
            "score the answers again, or use another version of eai"
        )
    record = record_from_json(values)
    if record.protocol is DEFAULT_PROTOCOL and schema == SCHEMA:
        contradiction = record.verdict.find_contradiction()
        if contradiction is None and values["success"] not in (None, record.verdict.success):
            contradiction = f"success is {json.dumps(values['success'])}, but not by the other fields"
        if contradiction is not None:
            raise InputError(f"the verdict was changed: {contradiction}; score the answer again")
    return record


def _load_json(line: str) -> Any:
    """Parse JSON; the standard library parses texts that the fast parser refuses, such as lone surrogates."""
    try:
        return from_json(line)
    except ValueError:
        return json.loads(line, strict=False)


SUMMARY = "summary.json"
RECORDS = "records.jsonl"

MAX_BATCH_RECORDS = 256
"""Maximum number of records (scored answers) that are prepared at a time."""


RecordBatch: TypeAlias = tuple[bytes, RunTotals]
"""Consecutive records (scored answers) of a run: their lines as bytes, and their totals."""


def make_record_batch(records: Sequence[Record]) -> RecordBatch:
    """Return records (scored answers) as a batch that is ready to be written."""
    return b"".join(
        [format_record_line(record).encode() + b"\n" for record in records]
    ), RunTotals.from_records(records)


RunDetailsAndRatesByAttempt: TypeAlias = tuple[Mapping[str, Json], Sequence[Mapping[str, Rate]]]
"""Parts of ``summary.json``: the field ``run``, and all metrics after each of several attempts at a task."""


def write_record_batches(
    folder: Path,
    batches: Iterable[RecordBatch],
    describe_run: Callable[[RunTotals], RunDetailsAndRatesByAttempt] | None = None,
) -> RunTotals:
    """Write the records (scored answers) of one model in one suite, and their summary.

    Batches are written as they come and not kept.

    Args:
        folder: the folder of the files.
        batches: the batches of records in order.
        describe_run: returns further content of the summary, after all batches were written.

    Raises:
        InputError: the folder cannot be written.
    """
    totals = RunTotals()

    def generate_record_lines_and_sum_run_totals() -> Iterator[bytes]:
        for batch_lines, batch_totals in batches:
            totals.add_totals_of_later_records(batch_totals)
            yield batch_lines

    def generate_summary_json() -> Iterator[str]:
        yield format_summary(totals, *(({}, ()) if describe_run is None else describe_run(totals)))

    write_files_atomically(
        {
            folder / RECORDS: generate_record_lines_and_sum_run_totals(),
            folder / SUMMARY: generate_summary_json(),
        }
    )
    return totals


_OPTIONAL_FIELDS = frozenset({"planner", "run", "by_attempt"})
"""Fields of ``summary.json`` that are left out if they are empty."""


def format_summary(
    totals: RunTotals, run: Mapping[str, Json], rates_by_attempt: Sequence[Mapping[str, Rate]]
) -> str:
    """Return the content of ``summary.json``.

    Args:
        totals: the totals of the run's records.
        run: the value of the field ``run``, such as the used tokens and the missing answers.
        rates_by_attempt: the rates with at most 1, 2, ... attempts at each task; empty for a single attempt.
    """
    first, errata = totals.first_record, totals.errata
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
        "by_attempt": [{name: rate.to_json() for name, rate in rates.items()} for rates in rates_by_attempt],
    }
    written = {name: value for name, value in fields.items() if value or name not in _OPTIONAL_FIELDS}
    return json.dumps(written, indent=2) + "\n"


T = TypeVar("T")

_SHARD_TEXT = re.compile(r"([0-9]{1,9})/([0-9]{1,9})")
_SHARD_FILE = re.compile(r"records\.shard-([0-9]+)-of-([0-9]+)\.jsonl")


class RunShard(NamedTuple):
    """One of ``of`` equal parts of a run: every ``of``-th task in order, from the ``number``-th on."""

    number: int
    of: int

    @staticmethod
    def parse(text: str) -> RunShard:
        """Parse a text such as ``2/8`` as a shard.

        Raises:
            InputError: the text is not a shard.
        """
        match = _SHARD_TEXT.fullmatch(text)
        if match is None or not 1 <= int(match[1]) <= int(match[2]):
            raise InputError(f"{text!r} is no shard: expected I/N, such as 2/8, from 1/8 to 8/8")
        return RunShard(int(match[1]), int(match[2]))

    def select_items_of_shard(self, items: Iterable[T]) -> Iterator[T]:
        """Yield the items of this shard from the items of all shards."""
        return islice(items, self.number - 1, None, self.of)

    @property
    def records_file_name(self) -> str:
        """Name of the file with the shard's records."""
        return f"records.shard-{self.number}-of-{self.of}.jsonl"


def find_shards(path: Path) -> dict[Path, list[Path]]:
    """Return a mapping from each folder with shards, below a given folder, to its files in order.

    Raises:
        InputError: there are no shards, or a folder lacks a shard or has shards of two runs.
    """
    folders: dict[Path, dict[RunShard, Path]] = {}
    for file in find_files_below(path, "records.shard-*.jsonl"):
        match = _SHARD_FILE.fullmatch(file.name)
        if match is not None:
            folders.setdefault(file.parent, {})[RunShard(int(match[1]), int(match[2]))] = file
    if not folders:
        raise InputError(f"{path}: expected a folder with records.shard-I-of-N.jsonl below, found none")
    for folder, files in folders.items():
        numbers = {shard.of for shard in files}
        if len(numbers) > 1:
            named = " and of ".join(map(str, sorted(numbers)))
            raise InputError(
                f"{folder}: expected the shards of one run, found some of {named}; keep those of one"
            )
        of = numbers.pop()
        missing = [str(number) for number in range(1, of + 1) if RunShard(number, of) not in files]
        if missing:
            raise InputError(f"{folder}: of {of} shards these are missing: {', '.join(missing)}; score them")
    return {folder: [files[shard] for shard in sorted(files)] for folder, files in folders.items()}


def merge_shards(folder: Path, files: Sequence[Path]) -> RunTotals:
    """Write the records and the summary of a run that was scored in parts by ``eai score --shard``.

    The files equal the files of a run that was not split, byte by byte.

    Raises:
        InputError: a file has no records or is of another run, or the folder cannot be written.
    """
    counts = [sum(not line.isspace() for line in _read_lines_of_records(file)) for file in files]
    if counts != sorted(counts, reverse=True) or counts[0] - counts[-1] > 1 or not counts[0]:
        raise InputError(
            f"{folder}: expected equal numbers of records in all shards, or one less in the last "
            f"ones, found {', '.join(map(str, counts))}; score the incomplete shards again"
        )
    return write_record_batches(folder, map(make_record_batch, _interleave_shards(files, folder)))


def _interleave_shards(files: Sequence[Path], folder: Path) -> Iterator[Sequence[Record]]:
    """Yield the records of all shards (parts) in the original order, in groups of one from each shard."""
    expected: dict[str, object] | None = None
    for dealt in zip_longest(*map(read_records, files)):
        round_ = [record for record in dealt if record is not None]
        expected = expected or _describe_run(round_[0])
        for record in round_:
            for name, value in _describe_run(record).items():
                if value != expected[name]:
                    raise InputError(
                        f"{folder}: expected the shards of one run, "
                        f"found {name} {expected[name]} and {name} {value}"
                    )
        yield round_


def _describe_run(record: Record) -> dict[str, object]:
    """Return the values that all scored answers of a run share, by name.

    The harness is left out: a file may have episodes of several harnesses.
    """
    experiment = record.experiment or Experiment()
    return {
        "protocol": record.protocol.value,
        "domain": record.domain,
        "ability": record.ability.value,
        "model": record.model,
        "data_sha256": record.data_sha256,
        "suite_size": record.suite_size,
        "errata": None if record.errata is None else record.errata.version,
        "experiment": replace(experiment, harness=None).label or None,
    }
