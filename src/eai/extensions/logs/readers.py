"""Registered readers of logs. A reader recognizes a log by its content, and reads it whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from eai.base.entry_points import get_entry_points
from eai.base.errors import InputError
from eai.base.files import read_content
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import LoggedEpisode
from eai.tasks.options import describe_validation_error
from eai.tasks.source import Source

GROUP = "eai.logs"
"""Group of entry points that register readers of logs."""

M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class LogReader:
    """A reader of one form of logs.

    Attributes:
        format: name of the form of logs.
        recognizes: whether content has this form. The content may be damaged.
        read: reads a log, given its path for messages and its content. It raises InputError, with the place
            in the file, if any part of the log is damaged.
        replay: replays the actions of episodes in the tasks of a benchmark; None if logs of this form have no
            actions that can be replayed.
    """

    format: str
    recognizes: Callable[[bytes], bool]
    read: Callable[[Path, bytes], Sequence[LoggedEpisode]]
    replay: Callable[[Sequence[LoggedEpisode], Benchmark, Source], Sequence[LoggedEpisode]] | None = None


@cache
def list_readers() -> tuple[LogReader, ...]:
    """Return all registered readers.

    Raises:
        InputError: an entry point does not lead to a reader.
    """
    readers = {name: point.load() for name, point in get_entry_points(GROUP).items()}
    for name, reader in readers.items():
        if not isinstance(reader, LogReader):
            raise InputError(f"{GROUP} {name}: expected a LogReader, found {type(reader).__name__}")
    return tuple(readers.values())


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
    if path.is_dir():
        raise InputError(f"{path}: expected a log, found a folder; name the logs in it")
    content = read_content(path)
    readers = [reader for reader in list_readers() if reader.recognizes(content)]
    if len(readers) != 1:
        forms = ", ".join([reader.format for reader in readers or list_readers()])
        problem = "several readers recognize" if readers else "no reader recognizes"
        raise InputError(f"{path}: {problem} this file; the forms are {forms}")
    episodes = readers[0].read(path, content)
    if not episodes:
        raise InputError(f"{path}: expected at least one episode, found none")
    if benchmark is not None and readers[0].replay is not None:
        episodes = readers[0].replay(episodes, benchmark, source or Source())
    return tuple([replace(episode, format=readers[0].format) for episode in episodes])


def read_logs(
    paths: Iterable[Path], benchmark: Benchmark | None = None, source: Source | None = None
) -> dict[Path, tuple[LoggedEpisode, ...]]:
    """Return a mapping from paths of logs to their episodes. Arguments are those of `read_log`.

    Raises:
        InputError: a log cannot be read, or two logs have the same episode of the same agent.
    """
    logs = {path: read_log(path, benchmark, source) for path in paths}
    seen: set[tuple[str, ...]] = set()
    for path, episodes in logs.items():
        for episode in episodes:
            key = (episode.format, episode.agent, episode.task, episode.setting)
            if episode.agent and key in seen:
                raise InputError(
                    f"{path}: the episode {' '.join(key[1:])} occurs twice; give each episode once"
                )
            seen.add(key)
    return logs


def validate(model: type[M], place: str, value: object) -> M:
    """Return a JSON value as an object of a Pydantic model.

    Raises:
        InputError: the value does not fit the model; the message has the place and the path of the value.
    """
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise InputError(f"{place}: {describe_validation_error(error, whole='the log')}") from error
