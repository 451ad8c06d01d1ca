"""The journal of a run, which is a file of all answers so far, and the state of a run with open questions.

A run resumes from its journal. A line that a crash cut off is ignored. Inspect's own resume is not used,
because it takes over whole samples by id and epoch, even if the question has changed. An experiment would ask
its first attempts twice. A changed prompt would keep its old answer. A run of fewer tasks would ask all of
them again. Samples that are not yet in the log are lost when the process is killed.
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
from eai.base.files import number_lines, raise_write_errors_as_input_errors, read_content
from eai.results.codec import dataclass_to_json
from eai.results.trials import Answer, AnswerKey, Conversation, add_answer_details_to_attempts
from eai.run.job import QuestionJob

JOURNAL = "answers.jsonl"
"""File name of the journal in the folder of a run."""

BEGUN = "begun.jsonl"
"""Name of the file beside the journal that has a line for each start of an episode."""


class AnswerJournal:
    """The answers of one run in a file that only grows; a last line that a crash cut off is overwritten.

    Args:
        path: the file; it and its folder are created with the first answer.

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
                self._index_answer(adapter.validate_json(line))
            except ValidationError as error:
                raise InputError(
                    f"{path}, line {number}: expected an answer of a run; delete the line to ask again"
                ) from error

    def find_answer(self, key: AnswerKey, request_sha256: str, attempt: int = 1) -> Answer | None:
        """Return the recorded answer to exactly this request, or None if the request has no answer."""
        return self._answers.get((request_sha256, *key, attempt))

    def add(self, answer: Answer) -> None:
        """Write an answer to disk, so that the answer survives a crash of the process.

        Raises:
            InputError: the file cannot be written, or was deleted.
        """
        with raise_write_errors_as_input_errors(self._path):
            if not self._size:
                self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("r+b" if self._size else "wb") as file:
                file.seek(self._size)  # overwrite the incomplete answer that a crash left behind
                file.write(json.dumps(dataclass_to_json(answer)).encode() + b"\n")
                file.truncate()
                self._size = file.tell()
        self._index_answer(answer)

    def record_and_count_episode_starts(self, key: AnswerKey, request_sha256: str) -> int:
        """Record in a file beside the journal that an episode begins, and return how often it has begun.

        Raises:
            InputError: the file cannot be read or written.
        """
        path, line = self._path.with_name(BEGUN), json.dumps([*key, request_sha256])
        with raise_write_errors_as_input_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a+", encoding="utf-8") as file:
                file.seek(0)
                times_before = file.read().split("\n").count(line)
                file.write(f"{line}\n")
        return times_before + 1

    def _index_answer(self, answer: Answer) -> None:
        self._answers[answer.request_sha256, answer.task_id, answer.epoch, answer.attempt] = answer


ProgressWatch: TypeAlias = Callable[[int, int, int, int], None]
"""Function that is called with the numbers of answered tasks, failed tasks, all tasks, and output tokens.

A task counts once in every epoch. Answers that the journal already had count as answered, without their
tokens. A task has failed if one of its requests failed for good.
"""


class RunState:
    """The answers so far to a job (the questions of a suite to a model), and its open questions.

    Args:
        job: the job.
        journal: the journal for new answers; answers that it already has to the same requests are used.
        watch: called at every answer and failure.

    Attributes:
        job: the job.
        journal: the journal for new answers.
        all_answers: mapping from task and epoch to the answers in order; experiments have one for each
            attempt.
        conversations: mapping from task and epoch to the questions asked so far and the next one.
        failures: mapping from task and epoch to the reason why the answer is missing.
        stopped: reason why the run sends no more questions; None while the run goes on.
        answer_limit: maximum number of tokens of further answers by default; None for no limit.
    """

    def __init__(self, job: QuestionJob, journal: AnswerJournal, watch: ProgressWatch | None) -> None:
        self.job = job
        self.journal = journal
        self.all_answers: dict[AnswerKey, list[Answer]] = defaultdict(list)
        self.conversations: dict[AnswerKey, Conversation] = {}
        self.failures: dict[AnswerKey, str] = {}
        self.stopped: EaiError | None = None
        self.answer_limit = job.answer_limit
        self._watch = watch
        self._finished = 0
        self._new_tokens = 0
        for task_id in job.prompts:
            for epoch in range(1, job.epochs + 1):
                self.conversations[task_id, epoch] = job.start_conversation(task_id, epoch)
                self._take_answers_from_journal((task_id, epoch))

    @property
    def is_complete(self) -> bool:
        """Whether every question of the job has an answer."""
        return self._finished == len(self.conversations)

    @property
    def last_answers(self) -> dict[AnswerKey, Answer]:
        """Mapping from task and epoch to the last answer, for each finished task."""
        return {key: given[-1] for key, given in self.all_answers.items() if self.conversations[key].is_over}

    @property
    def attempts(self) -> dict[AnswerKey, tuple[Attempt, ...]]:
        """Mapping from task and epoch to attempts at a finished task; empty if answers are not executed."""
        return {
            key: tuple(add_answer_details_to_attempts(attempts, given))
            for key, given in self.all_answers.items()
            if self.conversations[key].is_over and (attempts := self.conversations[key].attempts)
        }

    def hash_next_request(self, key: AnswerKey) -> str:
        """Return the digest of everything that decides the next answer to a task in an epoch."""
        return self.job.hash_request(key[0], self.conversations[key].question, len(self.all_answers[key]) + 1)

    def add_answer(self, answer: Answer) -> None:
        """Write an answer to the journal, and add it to the answers of the run.

        Raises:
            InputError: the journal cannot be written; then the run sends no more questions.
        """
        try:
            self.journal.add(answer)
        except InputError as error:
            self.stopped = error
            raise
        self._add_to_conversation(answer)
        self._new_tokens += answer.usage.output_tokens or 0
        self.report_progress()

    def record_failure(self, task_id: str, epoch: int, reason: str) -> None:
        """Record that a request failed after all repetitions, so that its task gets no answer."""
        self.failures[task_id, epoch] = reason
        self.report_progress()

    def stop_run(self, reason: str) -> None:
        """Record a reason why no request can succeed, so that the run sends no more questions."""
        hint = "nothing more was asked, and what is answered is kept; the same command resumes from here"
        self.stopped = EaiError(f"{self.job.endpoint.model}: {reason}; {hint}")

    def report_progress(self) -> None:
        """Call the progress watch with the numbers of answered and failed tasks, and of output tokens."""
        if self._watch is not None:
            self._watch(self._finished, len(self.failures), len(self.conversations), self._new_tokens)

    def _take_answers_from_journal(self, key: AnswerKey) -> None:
        while not self.conversations[key].is_over:
            answer = self.journal.find_answer(
                key, self.hash_next_request(key), len(self.all_answers[key]) + 1
            )
            if answer is None:
                return
            self._add_to_conversation(answer)

    def _add_to_conversation(self, answer: Answer) -> None:
        key = (answer.task_id, answer.epoch)
        conversation = self.conversations[key]
        self.all_answers[key].append(answer)
        conversation.add_answer(answer.text)
        self._finished += conversation.is_over
