"""Registered readers of logs. A reader recognizes a log by its content, and reads it whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import BaseModel, Field, ValidationError

from eai.base.entry_points import get_entry_points
from eai.base.errors import InputError
from eai.base.files import find_files_below, read_content
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import LoggedEpisode
from eai.tasks.options import describe_validation_error
from eai.tasks.source import Source
from eai.tasks.task import Task

GROUP = "eai.logs"
"""Group of entry points that register readers of logs."""

M = TypeVar("M", bound=BaseModel)

Share = Annotated[float, Field(ge=0, le=1)]
"""Type of a share in a log: a number from 0 to 1."""

Count = Annotated[int, Field(ge=0)]
"""Type of a count in a log: an integer that is not negative."""


@dataclass(frozen=True, slots=True)
class LogReader:
    """A reader of one form of logs.

    Attributes:
        format: name of the form of logs.
        recognizes: whether content has this form. The content may be damaged.
        read: reads a log, given its path for messages and its content. It raises InputError, with the place
            in the file, if any part of the log is damaged.
        replay: replays the actions of an episode in a benchmark, given its tasks by id; None if logs of this
            form have no actions that can be replayed.
    """

    format: str
    recognizes: Callable[[bytes], bool]
    read: Callable[[Path, bytes], Sequence[LoggedEpisode]]
    replay: Callable[[LoggedEpisode, Mapping[str, Task], Benchmark], LoggedEpisode] | None = None


@cache
def list_readers() -> tuple[LogReader, ...]:
    """Return the readers of all forms of logs that packages register as entry points.

    Raises:
        InputError: an entry point does not lead to a `LogReader`.
    """
    readers = {name: point.load() for name, point in get_entry_points(GROUP).items()}
    for name, reader in readers.items():
        if not isinstance(reader, LogReader):
            raise InputError(f"{GROUP} {name}: expected a LogReader, found {type(reader).__name__}")
    return tuple(readers.values())


def list_log_files(path: Path) -> list[Path]:
    """Return a file, or all files below a folder whose names do not begin with a dot."""
    return find_files_below(path, "[!.]*") if path.is_dir() else [path]


def is_log(path: Path) -> bool:
    """Whether a file, or any file in a folder, has a known form of logs, even if the log is damaged."""
    if path.is_dir():
        return any(map(is_log, list_log_files(path)))
    content = read_content(path)
    return any(reader.recognizes(content) for reader in list_readers())


def read_log(
    path: Path, benchmark: Benchmark | None = None, source: Source | None = None
) -> tuple[LoggedEpisode, ...]:
    """Return the episodes of a log, at least one, by the reader that recognizes its content.

    Args:
        path: the log.
        benchmark: a benchmark in whose tasks the episodes are replayed, if their reader can do so.
        source: the source of the benchmark's tasks.

    Raises:
        InputError: the file cannot be read, not exactly one reader recognizes it, it is damaged, or it has
            no episode.
    """
    content = read_content(path)
    readers = [reader for reader in list_readers() if reader.recognizes(content)]
    if not readers:
        known_formats = ", ".join([reader.format for reader in list_readers()])
        raise InputError(f"{path}: unknown log format; expected one of {known_formats}")
    if len(readers) > 1:
        formats = ", ".join([reader.format for reader in readers])
        raise InputError(
            f"{path}: several log formats fit this file ({formats}); uninstall the package of one reader"
        )
    (reader,) = readers
    episodes = reader.read(path, content)
    if not episodes:
        raise InputError(f"{path}: expected at least one episode, found none")
    if benchmark is not None and reader.replay is not None:
        tasks = benchmark.tasks(source or Source())
        episodes = [reader.replay(episode, tasks, benchmark) for episode in episodes]
    return tuple([_set_log_format_and_last_message(episode, reader) for episode in episodes])


def _set_log_format_and_last_message(episode: LoggedEpisode, reader: LogReader) -> LoggedEpisode:
    words = episode.words or (episode.steps[-1].feedback if episode.steps else "")
    return replace(episode, format=reader.format, words=" ".join(words.split()))


def read_logs(
    paths: Sequence[Path], benchmark: Benchmark | None = None, source: Source | None = None
) -> dict[Path, tuple[LoggedEpisode, ...]]:
    """Return a mapping from paths of logs, or of folders with logs only, to their episodes.

    Arguments are those of `read_log`.

    Raises:
        InputError: a log cannot be read or is given twice, a folder is empty, or two logs have the same
            episode of the same agent.
    """
    logs: dict[Path, tuple[LoggedEpisode, ...]] = {}
    files: set[Path] = set()
    seen: set[tuple[str, ...]] = set()
    for place, path in [(given, path) for given in paths for path in list_log_files(given)]:
        if path.resolve() in files:
            raise InputError(f"{path}: this log is given twice; give each log once")
        files.add(path.resolve())
        episodes = read_log(path, benchmark, source)
        logs[place] = logs.get(place, ()) + episodes
        for episode in episodes:
            key = (episode.format, episode.agent, episode.task, episode.setting)
            if episode.agent and key in seen:
                raise InputError(
                    f"{path}: the episode {' '.join(key[1:])} occurs twice; give each episode once"
                )
            seen.add(key)
    for folder in [given for given in paths if given not in logs]:
        raise InputError(f"{folder}: expected logs, found an empty folder")
    return logs


def validate(model: type[M], place: str, value: object) -> M:
    """Return a JSON value as an object of a Pydantic model.

    Raises:
        InputError: the value does not fit the model. The message has ``place`` (file and line), and the path
            of the invalid value within the JSON value.
    """
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise InputError(f"{place}: {describe_validation_error(error, whole='the log')}") from error
