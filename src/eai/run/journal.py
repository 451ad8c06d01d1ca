"""The journal of a run: every answer as it arrived, one line each, before anything is made of it.

It is what a run is resumed from: a line is whole or, after a crash in the middle of writing it, ignored.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from io import BufferedWriter
from pathlib import Path
from typing import TypeAlias

from pydantic import TypeAdapter, ValidationError

from eai.abilities.record import Usage
from eai.abilities.verdict import Json
from eai.errors import InputError

JOURNAL = "answers.jsonl"
"""Name of the journal in the folder of a run."""


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer of a model.

    Attributes:
        task_id: the data set's id.
        epoch: which of several answers to the task it is, from 1 on.
        request_sha256: digest of all that decides the answer: model, prompt, parameters.
        prompt_sha256: digest of the prompt alone.
        text: the answer without reasoning.
        reasoning: what the model thought before it, or empty.
        stop_reason: why it ended, as Inspect says it: ``stop``, ``max_tokens``, ...
        repairs: names of what was done to the text to separate or complete the answer.
        usage: what it took.
    """

    task_id: str
    epoch: int
    request_sha256: str
    prompt_sha256: str
    text: str
    reasoning: str
    stop_reason: str
    repairs: tuple[str, ...]
    usage: Usage

    @property
    def truncated(self) -> bool:
        """Whether a limit of length cut it off."""
        return self.stop_reason in ("max_tokens", "model_length")

    def to_json(self) -> dict[str, Json]:
        """The answer as a line of the journal has it."""
        fields: dict[str, Json] = {name: getattr(self, name) for name in self.__slots__}
        return {**fields, "usage": self.usage.to_json()}


Place: TypeAlias = tuple[str, int]
"""Id of the task, and epoch."""


class Journal:
    """The answers of one run in a file that is only ever appended to.

    It is to be closed, as a context manager or by `close`.

    Args:
        path: the file; it and its folder come into being with the first answer.

    Raises:
        InputError: the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: BufferedWriter | None = None
        self._answers: dict[str, dict[Place, Answer]] = {}
        for answer in _read(path):
            self._keep(answer)

    def find(self, task_id: str, epoch: int, request_sha256: str) -> Answer | None:
        """The answer to this very request, or None."""
        return self._answers.get(request_sha256, {}).get((task_id, epoch))

    def add(self, answer: Answer) -> None:
        """Write an answer down; when this returns, the end of the process cannot lose it.

        Raises:
            InputError: the file cannot be written.
        """
        try:
            if self._file is None:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self._path.open("ab")
            self._file.write(json.dumps(answer.to_json()).encode() + b"\n")
            self._file.flush()
        except OSError as error:
            raise self._unwritten(error) from error
        self._keep(answer)

    def close(self) -> None:
        """Close the file; another answer would open it again.

        Raises:
            InputError: what could not be written before still cannot.
        """
        file, self._file = self._file, None
        try:
            if file is not None:
                file.close()
        except OSError as error:
            raise self._unwritten(error) from error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _unwritten(self, error: OSError) -> InputError:
        return InputError(f"{self._path}: cannot be written ({error.strerror})")

    def _keep(self, answer: Answer) -> None:
        self._answers.setdefault(answer.request_sha256, {})[answer.task_id, answer.epoch] = answer


def _read(path: Path) -> Iterator[Answer]:
    """The whole lines of a file; what an interrupted writer left at its end is cut off."""
    if not path.exists():
        return
    adapter = TypeAdapter(Answer)
    try:
        content = path.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            with path.open("r+b") as file:
                file.truncate(whole)
        for number, line in enumerate(content[:whole].splitlines(), 1):
            try:
                yield adapter.validate_json(line)
            except ValidationError as error:
                raise InputError(f"{path}, line {number}: expected an answer of a run") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
