"""Progress of a long operation, reported to its caller so that a command line can draw a bar."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum


class Stage(str, Enum):
    """A stage of the operation."""

    WAIT = "wait"
    DOWNLOAD = "download"
    CONVERT = "convert"


@dataclass(frozen=True, slots=True)
class Progress:
    """`done` of `total` units of a stage; bytes for a download, tasks or files for a conversion.

    `total` is 0 where nothing can be counted: waiting for another process.
    """

    stage: Stage
    subject: str
    done: int
    total: int


Report = Callable[[Progress], None]
"""Called with each step forward, from the calling thread."""


def silent(progress: Progress) -> None:
    """Report nothing."""
