"""The journal of a run, every answer as it arrived, and the desk where answers are looked up and counted.

A run is resumed from its journal: a line is whole or, after a crash in the middle of writing it, ignored.
Inspect's own resume does not do it: it takes over whole samples by id and epoch, whatever was asked. An
experiment would ask its first attempts twice, a changed prompt would keep its old answer, fewer tasks would
all be asked again, and samples that are not yet in the log are lost when the process is killed.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from pydantic import TypeAdapter, ValidationError

from eai.abilities.attempt import Attempt
from eai.base.errors import EaiError, InputError
from eai.base.files import convert_write_errors, number_lines, read_content
from eai.results.codec import dataclass_to_json
from eai.results.trials import Answer, AnswerKey, Conversation, describe_attempts
from eai.run.job import Job

JOURNAL = "answers.jsonl"
"""Name of the journal in the folder of a run."""

BEGUN = "begun.jsonl"
"""Name of the file beside it that says which episodes have begun, as often as they have."""


class AnswerJournal:
    """The answers of one run in a file that is only ever appended to, over what is no whole line at its end.

    Args:
        path: the file; it and its folder come into being with the first answer.

    Raises:
        InputError: the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._answers: dict[tuple[str, str, int, int], Answer] = {}
        content, adapter = read_content(path) if path.exists() else b"", TypeAdapter(Answer)
        self._size = content.rfind(b"\n") + 1
        for number, line in number_lines(content[: self._size]):
            try:
                self._keep(adapter.validate_json(line))
            except ValidationError as error:
                raise InputError(f"{path}, line {number}: expected an answer of a run") from error

    def find(self, place: AnswerKey, request_sha256: str, attempt: int = 1) -> Answer | None:
        """The answer to this very request, or None."""
        return self._answers.get((request_sha256, *place, attempt))

    def add(self, answer: Answer) -> None:
        """Write an answer down; when this returns, the end of the process cannot lose it.

        Raises:
            InputError: the file cannot be written, or is not there any more.
        """
        with convert_write_errors(self._path):
            if not self._size:
                self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("r+b" if self._size else "wb") as file:
                file.seek(self._size)  # over what could be written of an answer before
                file.write(json.dumps(dataclass_to_json(answer)).encode() + b"\n")
                file.truncate()
                self._size = file.tell()
        self._keep(answer)

    def begin(self, place: AnswerKey, request_sha256: str) -> int:
        """Note that an episode begins, in a file beside this one; returns how often it has begun.

        Raises:
            InputError: the file cannot be read or written.
        """
        path, line = self._path.with_name(BEGUN), json.dumps([*place, request_sha256])
        with convert_write_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a+", encoding="utf-8") as file:
                file.seek(0)
                before = file.read().split("\n").count(line)
                file.write(f"{line}\n")
        return before + 1

    def _keep(self, answer: Answer) -> None:
        self._answers[answer.request_sha256, answer.task_id, answer.epoch, answer.attempt] = answer


ProgressWatch: TypeAlias = Callable[[int, int, int], None]
"""Shows how far a run is.

How many tasks are answered, in every epoch and those found included; how many were given up because a request
failed; how many there are.
"""


class RunState:
    """Everything known about a job, and the questions that are still open.

    Args:
        job: what is asked.
        journal: where answers go; answers to the same requests that are there already are taken from it.
        watch: is called at every answer and failure.

    Attributes:
        job: what is asked.
        journal: where answers go.
        given: the answers there are, by task and epoch; in an experiment of every attempt, in order.
        inquiries: each task as it is put to the model, by task and epoch; what is over is answered.
        failures: why there is no answer, by task and epoch.
        stopped: why nothing more is to be asked, if that is so.
    """

    def __init__(self, job: Job, journal: AnswerJournal, watch: ProgressWatch | None) -> None:
        self.job = job
        self.journal = journal
        self.all_answers: dict[AnswerKey, list[Answer]] = defaultdict(list)
        self.conversations: dict[AnswerKey, Conversation] = {}
        self.failures: dict[AnswerKey, str] = {}
        self.stopped: EaiError | None = None
        self._watch = watch
        self._over = 0
        for task_id in job.prompts:
            for epoch in range(1, job.epochs + 1):
                self.conversations[task_id, epoch] = job.start_conversation(task_id, epoch)
                self._recall((task_id, epoch))

    @property
    def is_complete(self) -> bool:
        """Whether there are all answers."""
        return self._over == len(self.conversations)

    @property
    def last_answers(self) -> dict[AnswerKey, Answer]:
        """The last answer to each task that is answered, by task and epoch."""
        return {
            place: given[-1] for place, given in self.all_answers.items() if self.conversations[place].is_over
        }

    @property
    def attempts(self) -> dict[AnswerKey, tuple[Attempt, ...]]:
        """The attempts at each task that is carried out and over."""
        return {
            place: tuple(describe_attempts(attempts, given))
            for place, given in self.all_answers.items()
            if self.conversations[place].is_over and (attempts := self.conversations[place].attempts)
        }

    def request(self, place: AnswerKey) -> str:
        """Digest of all that decides the next answer."""
        return self.job.request_sha256(
            place[0], self.conversations[place].question, len(self.all_answers[place]) + 1
        )

    def add_answer(self, answer: Answer) -> None:
        """Write an answer down.

        Raises:
            InputError: the journal cannot be written; then nothing more is to be asked.
        """
        try:
            self.journal.add(answer)
        except InputError as error:
            self.stopped = error
            raise
        self._accept(answer)
        self.report()

    def give_up(self, task_id: str, epoch: int, why: str) -> None:
        """Note that a request failed for good."""
        self.failures[task_id, epoch] = why
        self.report()

    def stop(self, why: str) -> None:
        """Note that no request can ever succeed, so that nothing more is to be asked."""
        hint = "nothing more was asked, and what is answered is kept; the same command resumes from here"
        self.stopped = EaiError(f"{self.job.endpoint.model}: {why}; {hint}")

    def report(self) -> None:
        """Show how far the run is."""
        if self._watch is not None:
            self._watch(self._over, len(self.failures), len(self.conversations))

    def _recall(self, place: AnswerKey) -> None:
        """Take what the journal holds of the answers to a task."""
        while not self.conversations[place].is_over:
            answer = self.journal.find(place, self.request(place), len(self.all_answers[place]) + 1)
            if answer is None:
                return
            self._accept(answer)

    def _accept(self, answer: Answer) -> None:
        place = (answer.task_id, answer.epoch)
        inquiry = self.conversations[place]
        self.all_answers[place].append(answer)
        inquiry.add_answer(answer.text)
        self._over += inquiry.is_over
