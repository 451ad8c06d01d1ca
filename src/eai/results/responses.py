"""Reads and writes response files: a model's answers, in the format of the reference package.

The paper's public challenge uses this format, too. A file is a JSON list of ``{"identifier": ...,
"llm_output": ...}``, named ``<model>_outputs.json``; or it has one such object a line and is named
``<model>_outputs.jsonl``; or it is a Parquet file with these two columns, ``<model>_outputs.parquet``. If a
task has several answers, each row has the number of its answer, from 0, in ``sample``. JSON lines and Parquet
files are never loaded as a whole.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

from eai.base.errors import InputError, did_you_mean
from eai.base.files import find_files_below, parse_json, read_content, require_file, write_files_atomically
from eai.base.grouping import group_pairs
from eai.results.parquet import read_columns

T = TypeVar("T", bound=Hashable)

SUFFIX = "_outputs.json"
LINES = "_outputs.jsonl"
"""Suffix of the name of a response file with one object a line."""
PARQUET = "_outputs.parquet"
"""Suffix of the name of a response file in Parquet."""
COLUMNS = ("identifier", "llm_output")
"""Keys of a row: the task's id as the file spells it, and the answer."""
SAMPLE = "sample"
"""Key of the number of an answer, in files with several answers to a task."""
MAX_SAMPLES = 10_000_000
"""Maximum number of answers to a task."""
ENDINGS = (SUFFIX, LINES, PARQUET)
"""Suffixes of the names of response files."""
_ATTEMPT_NAME = re.compile(rf"_attempt_\d+{SUFFIX}$")

_MAX_SHOWN_CHARACTERS = 100
"""Maximum number of characters of an unknown identifier in a message."""


@dataclass(frozen=True, slots=True)
class Response:
    """One answer, or a missing answer.

    Attributes:
        task_id: id of the task.
        text: the answer; empty if it is missing.
        sample: number of the answer, from 0, if the task has several; else None.
        unanswered: reason for a missing answer; None if there is an answer, even an empty one.
    """

    task_id: str
    text: str
    sample: int | None = None
    unanswered: str | None = None


ResponseRow: TypeAlias = Response | bytes | Mapping[str, object]
"""An answer, or a row of a response file that is not parsed yet, for a worker to parse (`read_response`)."""


@dataclass(frozen=True, slots=True)
class ResponseFile:
    """The answers of one model, in the order of the file.

    Attributes:
        model: name of the model.
        responses: the answers. If a task may have several answers, each iteration reads the file again.
        skipped_rows: number of rows that are left out because the data set does not have their tasks.
        further_epochs: the answers of further epochs (rounds of answers), if a task counts by its mean over
            all epochs.
    """

    model: str
    responses: Collection[Response]
    skipped_rows: int = 0
    further_epochs: tuple[ResponseFile, ...] = ()

    @property
    def allows_several_answers_per_task(self) -> bool:
        """Whether the file may have several answers to a task (samples)."""
        return isinstance(self.responses, _AnswersKeptInFile)

    @property
    def answered_task_ids(self) -> Collection[str]:
        """Ids of the tasks with an answer."""
        if isinstance(self.responses, _AnswersKeptInFile):
            return self.responses.answered_task_ids
        return {response.task_id for response in self.responses}

    def read_rows(self) -> Iterator[ResponseRow]:
        """Yield the answers in order.

        If tasks may have several answers, yield rows of the file, which `read_response` parses.
        """
        if isinstance(self.responses, _AnswersKeptInFile):
            return self.responses.read_rows()
        return iter(self.responses)

    def group_answers_by_key(self, key: Callable[[str], T]) -> dict[T, ResponseFile]:
        """Group the answers by a key, which a function computes from the text of an answer. Keep their order.

        The answers of `further_epochs` (rounds after the first) are left out.
        """
        if isinstance(self.responses, _AnswersKeptInFile):
            parts: dict[T, Collection[Response]] = {**self.responses.group_answers_by_key(key)}
        else:
            parts = {**group_pairs((key(response.text), response) for response in self.responses)}
        return {value: replace(self, responses=part, further_epochs=()) for value, part in parts.items()}


@dataclass(frozen=True, slots=True)
class _AnswersKeptInFile(Collection[Response]):
    """The answers of a file with several answers to a task. Each iteration reads the file again.

    Attributes:
        path: the file.
        answer_count: number of answers in the file that are not left out.
        answered_task_ids: ids of the tasks with an answer.
        task_id_of: function from an identifier in the file to the id of its task.
        skipped_row_numbers: numbers of the rows that are left out, counted from 1.
    """

    path: Path
    answer_count: int
    answered_task_ids: Collection[str]
    task_id_of: Callable[[str], str | None]
    skipped_row_numbers: Collection[int]

    def read_rows(self) -> Iterator[ResponseRow]:
        return (
            row
            for number, row in enumerate(_read_response_rows(self.path), 1)
            if number not in self.skipped_row_numbers
        )

    def group_answers_by_key(self, key: Callable[[str], T]) -> dict[T, _AnswersKeptInFile]:
        """Group the answers by a key, which a function computes from the text of an answer."""
        numbers: dict[T, set[int]] = {}
        tasks: dict[T, set[str]] = {}
        for number, row in enumerate(_read_response_rows(self.path), 1):
            if number not in self.skipped_row_numbers:
                response = read_response(row, self.task_id_of)
                value = key(response.text)
                numbers.setdefault(value, set()).add(number)
                tasks.setdefault(value, set()).add(response.task_id)
        rows_of_other_keys = {
            value: set().union(*(numbers[other] for other in numbers if other != value)) for value in numbers
        }
        return {
            value: replace(
                self,
                answer_count=len(rows_of_key),
                answered_task_ids=frozenset(tasks[value]),
                skipped_row_numbers=frozenset({*self.skipped_row_numbers, *rows_of_other_keys[value]}),
            )
            for value, rows_of_key in numbers.items()
        }

    def __iter__(self) -> Iterator[Response]:
        return (read_response(row, self.task_id_of) for row in self.read_rows())

    def __len__(self) -> int:
        return self.answer_count

    def __contains__(self, item: object) -> bool:
        return any(response == item for response in self)


def find_response_files(path: Path) -> list[Path]:
    """Return the response file at a path, or all response files below a folder, sorted.

    Their names end in ``_outputs.json``, ``.jsonl`` or ``.parquet``. In a folder, files whose names have the
    number of an attempt are skipped: they are not a complete run.

    Raises:
        InputError: there is no such file.
    """
    if path.is_dir():
        files = find_files_below(path, *(f"*{ending}" for ending in ENDINGS))
        response_files = [file for file in files if not _ATTEMPT_NAME.search(file.name)]
        if not response_files:
            raise InputError(f"{path}: expected a folder with <model>{SUFFIX} files, found none")
        return response_files
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    return [path]


def read_responses(
    path: Path,
    task_ids: Collection[str],
    task_id_of: Callable[[str], str | None] = str,
    *,
    samples: bool = False,
) -> ResponseFile:
    """Read a response file with answers to tasks of the given ids.

    Args:
        path: the file.
        task_ids: the ids.
        task_id_of: function from an identifier in the file to the id of its task; the identity by default. It
            returns None if the data set does not have the task. Rows of such tasks are left out and counted.
        samples: whether a task may have several answers, if rows have the number ``sample``, from 0.

    Raises:
        InputError: the file is not a JSON list of answers or has no row; a row lacks a key or its value has
            another type; an identifier is unknown or repeated.
    """
    checked_rows = _read_and_check_rows(path, task_ids, task_id_of)
    first = next(checked_rows, None)
    sampled = samples and first is not None and first.sample is not None
    file = _make_response_file(
        path, chain(() if first is None else (first,), checked_rows), task_id_of, has_samples=sampled
    )
    if not file.responses:
        rows = f"{file.skipped_rows:,} for tasks that are not in the data set"
        raise InputError(
            f"{path}: expected at least one answer, found {rows if file.skipped_rows else 'an empty list'}"
        )
    return file


class _CheckedResponseRow(NamedTuple):
    """A row of a response file, with its number from 1, its location for messages, and its task.

    The task is None if the row is left out.
    """

    number: int
    location: str
    task_id: str | None
    text: str
    sample: Any


def _read_and_check_rows(
    path: Path, task_ids: Collection[str], task_id_of: Callable[[str], str | None]
) -> Iterator[_CheckedResponseRow]:
    known_ids = frozenset(task_ids)
    for number, row in enumerate(_parse_response_rows(path), 1):
        location = f"{path}, row {number}"
        identifier, text, sample = _read_row_fields(location, row)
        task_id = task_id_of(identifier)
        if task_id is not None and task_id not in known_ids:
            shown_id = task_id[:_MAX_SHOWN_CHARACTERS]
            hint = (
                did_you_mean(shown_id, task_ids) or f", which have ids such as {next(iter(task_ids), '')!r}"
            )
            raise InputError(f"{location}: identifier {shown_id!r} is not one of the tasks{hint}")
        yield _CheckedResponseRow(number, location, task_id, text, sample)


def _make_response_file(
    path: Path,
    rows: Iterable[_CheckedResponseRow],
    task_id_of: Callable[[str], str | None],
    *,
    has_samples: bool,
) -> ResponseFile:
    """Return the answers in the rows of a file. Answers with sample numbers are not kept in memory.

    Raises:
        InputError: a sample number is wrong, or a row repeats an answer's task and sample number.
    """
    samples_of_task: dict[str, bytearray] = {}
    skipped: set[int] = set()
    answers: list[Response] = []
    number = 0
    for row in rows:
        sample = row.sample if has_samples else 0
        if type(sample) is not int or not 0 <= sample < MAX_SAMPLES:
            raise InputError(
                f'{row.location}: "{SAMPLE}" must be a whole number from 0 to {MAX_SAMPLES - 1}, '
                "because row 1 has such a number"
            )
        if row.task_id is None:
            skipped.add(row.number)
            continue
        if not _add_sample_number_if_new(samples_of_task.setdefault(row.task_id, bytearray()), sample):
            sample_text = f"sample {sample} of " if has_samples else ""
            shown_id = row.task_id[:_MAX_SHOWN_CHARACTERS]
            raise InputError(
                f"{row.location}: {sample_text}identifier {shown_id!r} occurs twice; keep one row"
            )
        number += 1
        answers += [] if has_samples else [Response(row.task_id, row.text)]
    samples = _AnswersKeptInFile(path, number, frozenset(samples_of_task), task_id_of, frozenset(skipped))
    return ResponseFile(read_model_name(path), samples if has_samples else tuple(answers), len(skipped))


def _add_sample_number_if_new(seen: bytearray, sample: int) -> bool:
    """Add a number to a bit set of answer numbers. Return whether the set did not contain it before."""
    byte, bit = sample // 8, 1 << sample % 8
    seen.extend(bytes(max(0, byte + 1 - len(seen))))
    is_new = not seen[byte] & bit
    seen[byte] |= bit
    return is_new


def read_response(row: ResponseRow, task_id_of: Callable[[str], str | None]) -> Response:
    """Return the answer in a row of a file that `read_responses` has read."""
    if isinstance(row, Response):
        return row
    value = json.loads(row, strict=False) if isinstance(row, bytes) else row
    identifier, text, sample = _read_row_fields("a row", value)
    return Response(task_id_of(identifier) or identifier, text, sample)


def write_responses(folder: Path, file: ResponseFile) -> None:
    """Write answers as a response file, so that they can be scored again, also by other programs.

    Raises:
        InputError: the folder cannot be written.
    """
    rows = [{"identifier": r.task_id, "llm_output": r.text} for r in file.responses]
    write_files_atomically({folder / f"{file.model}{SUFFIX}": json.dumps(rows, indent=1) + "\n"})


def read_model_name(path: Path) -> str:
    """Return the name of the model that a response file's name begins with.

    Raises:
        InputError: the file name has no text before its suffix, or only dots.
    """
    ending = next((ending for ending in ENDINGS if path.name.endswith(ending)), path.suffix)
    name = path.name.removesuffix(ending)
    if not name.strip("."):
        raise InputError(f"{path}: expected a file named after a model, <model>{SUFFIX}")
    return name


def format_attempt_name(name: str, attempt: int) -> str:
    """Return a model's name with the number of an attempt, from 1, as in names of response files."""
    return f"{name}_attempt_{attempt}"


def _read_response_rows(path: Path) -> Iterator[ResponseRow]:
    """Yield the rows of a response file. Rows of JSON lines are not parsed yet."""
    if path.suffix == Path(PARQUET).suffix:
        return read_columns(path, COLUMNS, (SAMPLE,))
    if path.suffix == Path(LINES).suffix:
        return (line for _, line in _read_numbered_lines(path))
    return iter(_read_json_list(path))


def _parse_response_rows(path: Path) -> Iterator[object]:
    """Yield the rows of a response file as JSON values."""
    if path.suffix == Path(LINES).suffix:
        return (parse_json(path, line, number) for number, line in _read_numbered_lines(path))
    return _read_response_rows(path)


def _read_numbered_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield the nonblank lines of a file, numbered from 1. Only a line feed ends a line."""
    require_file(path)
    try:
        with path.open("rb") as file:
            yield from ((number, line) for number, line in enumerate(file, 1) if line.strip())
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error


def _read_json_list(path: Path) -> list[Any]:
    rows = parse_json(path, read_content(path))
    if not isinstance(rows, list):
        raise InputError(
            f'{path}: expected a list of {{"identifier", "llm_output"}}, not {_name_json_type(rows)}'
        )
    return rows


def _read_row_fields(location: str, row: object) -> tuple[str, str, Any]:
    """Return the identifier, the answer and the sample number of a row."""
    if not isinstance(row, dict):
        raise InputError(f'{location}: expected {{"identifier", "llm_output"}}, not {_name_json_type(row)}')
    for key in COLUMNS:
        if key not in row:
            raise InputError(f'{location}: the key "{key}" is missing')
    identifier, text, sample = row["identifier"], row["llm_output"], row.get(SAMPLE)
    if not isinstance(identifier, str):
        raise InputError(f'{location}: "identifier" must be a string, not {_name_json_type(identifier)}')
    if not isinstance(text, str | None):
        raise InputError(f'{location}: "llm_output" must be a string, not {_name_json_type(text)}')
    return identifier, text or "", sample


def _name_json_type(value: object) -> str:
    names = {dict: "an object", list: "a list", str: "a string", bool: "a truth value", type(None): "null"}
    return names.get(type(value), "a number")
