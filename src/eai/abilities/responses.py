"""Response files: the answers of a model as the reference and the challenge exchange them.

A file is a JSON list of ``{"identifier": ..., "llm_output": ...}``, named ``<model>_outputs.json``, or has
one such object a line and is named ``<model>_outputs.jsonl``; or it is a Parquet file with these two columns,
``<model>_outputs.parquet``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from eai.data.files import files_below, lines, read_columns, write_whole
from eai.errors import InputError, did_you_mean

SUFFIX = "_outputs.json"
LINES = "_outputs.jsonl"
"""How the names of files end that hold an object a line."""
PARQUET = "_outputs.parquet"
"""How the names of Parquet files end."""
COLUMNS = ("identifier", "llm_output")
"""A row: the id of the task, as the file spells it, and the answer."""
ENDINGS = (SUFFIX, LINES, PARQUET)
"""How the names of response files end."""
_ATTEMPT = re.compile(rf"_attempt_\d+{SUFFIX}$")

_SHOWN = 100
"""How many characters of an unknown identifier a message shows."""


@dataclass(frozen=True, slots=True)
class Response:
    """One answer: the id of its task, and the text; a missing text is empty."""

    task_id: str
    text: str


@dataclass(frozen=True, slots=True)
class ResponseFile:
    """The answers of one model, in the order of the file.

    Attributes:
        model: the model.
        responses: the answers.
        elsewhere: how many rows are left out because the data set does not have their tasks.
        further: the answers of further epochs, where tasks count by the mean over all.
    """

    model: str
    responses: tuple[Response, ...]
    elsewhere: int = 0
    further: tuple[ResponseFile, ...] = ()


def find_response_files(path: Path) -> list[Path]:
    """A response file itself, or all ``*_outputs.json``, ``.jsonl`` and ``.parquet`` below a folder, by name.

    The answers of single attempts of an experiment are no run by themselves: they are found by name alone.

    Raises:
        InputError: there is none.
    """
    if path.is_dir():
        files = files_below(path, *(f"*{ending}" for ending in ENDINGS))
        found = [file for file in files if not _ATTEMPT.search(file.name)]
        if not found:
            raise InputError(f"{path}: expected a folder with <model>{SUFFIX} files, found none")
        return found
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    return [path]


def read_responses(
    path: Path,
    task_ids: Collection[str],
    task_id_of: Callable[[str], str | None] = str,
) -> ResponseFile:
    """Read a response file for tasks with these ids.

    Args:
        path: the file.
        task_ids: the ids.
        task_id_of: from an identifier, as files have it, to the id of its task; by default the same. None is
            for a task that is known not to be in the data set: such rows are left out and counted.

    Raises:
        InputError: the file is not a JSON list of answers, a row lacks a key or has it of another type, an
            identifier is unknown or repeated, or there is no row.
    """
    rows = _read_list(path)
    known = frozenset(task_ids)
    responses: dict[str, Response] = {}
    elsewhere = 0
    for number, row in enumerate(rows, 1):
        identifier, text = _fields(f"{path}, row {number}", row)
        task_id = task_id_of(identifier)
        if task_id is None:
            elsewhere += 1
            continue
        shown = task_id[:_SHOWN]
        if task_id not in known:
            hint = did_you_mean(shown, task_ids) or f", which have ids such as {next(iter(task_ids), '')!r}"
            raise InputError(f"{path}, row {number}: identifier {shown!r} is not one of the tasks{hint}")
        if task_id in responses:
            raise InputError(f"{path}, row {number}: identifier {shown!r} stands there twice")
        responses[task_id] = Response(task_id, text)
    if not responses:
        found = f"{elsewhere:,} for tasks that are not in the data set" if elsewhere else "an empty list"
        raise InputError(f"{path}: expected at least one answer, found {found}")
    return ResponseFile(model_name(path), tuple(responses.values()), elsewhere)


def write_responses(folder: Path, file: ResponseFile) -> None:
    """Write answers as a response file, so that they can be scored again and elsewhere.

    Raises:
        InputError: the folder cannot be written.
    """
    rows = [{"identifier": r.task_id, "llm_output": r.text} for r in file.responses]
    write_whole({folder / f"{file.model}{SUFFIX}": json.dumps(rows, indent=1) + "\n"})


def model_name(path: Path) -> str:
    """The model that a response file is named after.

    Raises:
        InputError: there is no name before the suffix, or none that a folder of results could have.
    """
    ending = next((ending for ending in ENDINGS if path.name.endswith(ending)), path.suffix)
    name = path.name.removesuffix(ending)
    if not name.strip("."):
        raise InputError(f"{path}: expected a file named after a model, <model>{SUFFIX}")
    return name


def attempt_name(name: str, attempt: int) -> str:
    """The name of the answers of one attempt, counted from 1."""
    return f"{name}_attempt_{attempt}"


def file_name(name: str) -> str:
    """A name, such as a model's, as part of file names: an underscore for what is no letter, digit, ``.-_``.

    Raises:
        InputError: nothing but dots would be left, which is no name in any folder.
    """
    plain = re.sub(r"[^\w.-]+", "_", name)
    if not plain.strip("."):
        raise InputError(f"{name!r}: expected a name that files can be named after")
    return plain


def _read_list(path: Path) -> Sequence[object]:
    if path.suffix == Path(PARQUET).suffix:
        return read_columns(path, COLUMNS)
    try:
        content = path.read_bytes()
        is_lines = path.suffix == Path(LINES).suffix
        rows = [*_values(content)] if is_lines else json.loads(content, strict=False)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise InputError(f"{path}, {place}: expected JSON ({error.msg})") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: expected JSON in UTF-8 ({error})") from error
    if not isinstance(rows, list):
        raise InputError(f'{path}: expected a list of {{"identifier", "llm_output"}}, not {_kind(rows)}')
    return rows


def _values(content: bytes) -> Iterator[object]:
    """The values of a file with one a line; of a bad line the place is that in the file."""
    for number, line in lines(content):
        try:
            yield json.loads(line, strict=False)
        except json.JSONDecodeError as error:
            error.lineno += number - 1
            raise


def _fields(place: str, row: object) -> tuple[str, str]:
    """The identifier and the text of a row."""
    if not isinstance(row, dict):
        raise InputError(f'{place}: expected {{"identifier", "llm_output"}}, not {_kind(row)}')
    for key in COLUMNS:
        if key not in row:
            raise InputError(f'{place}: the key "{key}" is missing')
    identifier, text = row["identifier"], row["llm_output"]
    if not isinstance(identifier, str):
        raise InputError(f'{place}: "identifier" must be a string, not {_kind(identifier)}')
    if not isinstance(text, str | None):
        raise InputError(f'{place}: "llm_output" must be a string, not {_kind(text)}')
    return identifier, text or ""


def _kind(value: object) -> str:
    names = {dict: "an object", list: "a list", str: "a string", bool: "a truth value", type(None): "null"}
    return names.get(type(value), "a number")
