"""The journal of a run, which is a file of all answers so far, and the state of a run with open questions.

A run resumes from its journal. A line that a crash cut off is ignored. Inspect's own resume is not used,
because it takes over whole samples by id and epoch, even if the question has changed. If a model has several
attempts at a task, Inspect would repeat the first attempts. A changed prompt would keep its old answer. A run
of fewer tasks would ask all of them again. Samples that are not yet in the log are lost when the process is
killed.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import NamedTuple, TypeAlias

from pydantic import TypeAdapter

from eai.abilities.attempt import Attempt
from eai.base.errors import EaiError, InputError
from eai.base.files import number_lines, raise_write_errors_as_input_errors, read_content
from eai.results.codec import dataclass_to_json
from eai.results.trials import Answer, Conversation, TaskIdAndEpoch, add_answer_details_to_attempts
from eai.run.job import QuestionJob

JOURNAL = "answers.jsonl"
"""File name of the journal, the file of all answers so far, in the folder of a run."""

MAX_FIRST_FAILURES = 10
"""Number of tasks asked first. If all their requests fail, a run without any answer stops."""

BEGUN = "begun.jsonl"
"""Name of the file beside the answers that has a line for each start of an episode."""


class AnswerJournal:
    """The answers of one run in a file that only grows; a last line that a crash cut off is overwritten.

    Args:
        path: the file; it and its folder are created with the first answer.

    Raises:
        InputError: the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._answers: dict[TaskIdAndEpoch, list[Answer]] = defaultdict(list)
        content, adapter = read_content(path) if path.exists() else b"", TypeAdapter(Answer)
        self._size = content.rfind(b"\n") + 1
        for number, line in number_lines(content[: self._size]):
            try:
                # not `validate_json`, which refuses the lone surrogates of an answer that was cut off
                self._index_answer(adapter.validate_python(json.loads(line)))
            except (ValueError, RecursionError) as error:
                raise InputError(
                    f"{path}, line {number}: expected an answer of a run; delete the line to ask again"
                ) from error

    def find_answer(self, key: TaskIdAndEpoch, request_sha256: str, attempt: int = 1) -> Answer | None:
        """Return the recorded answer to exactly this request, or None if the request has no answer."""
        wanted = request_sha256, attempt
        answers = reversed(self._answers[key] if self.has_answers(key) else ())
        return next((each for each in answers if (each.request_sha256, each.attempt) == wanted), None)

    def has_answers(self, key: TaskIdAndEpoch) -> bool:
        """Whether the journal has an answer to any request about a task in an epoch (round of answers)."""
        return key in self._answers

    def write_answer(self, answer: Answer) -> None:
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

    def record_and_count_episode_starts(self, key: TaskIdAndEpoch, request_sha256: str) -> int:
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
        self._answers[answer.task_id, answer.epoch].append(answer)


ProgressWatch: TypeAlias = Callable[[int, int, int, int, str], None]
"""Function that is called with the numbers of answered tasks, failed tasks, all tasks, and output tokens.

The last argument is the reason of a failure, or "" without a new failure.

A task counts once in every epoch (one answer to each task). Answers from an earlier start of the run count as
answered, without their tokens. A task has failed if a request failed after all repetitions.
"""


class _ConversationInJournal(NamedTuple):
    """The conversation about a task in an epoch (round of answers), with its answers in order."""

    key: TaskIdAndEpoch
    conversation: Conversation
    answers: list[Answer]


class RunState:
    """The answers so far to a job (the questions of a suite to a model, in one or more rounds).

    Conversations are not stored here, so that memory does not grow with prompts. Only the solver that asks
    the questions holds a conversation.

    Args:
        job: the job.
        journal: the journal for new answers. Requests that it has already an answer to are not sent again.
        watch: called at every answer and failure.

    Attributes:
        job: the job.
        journal: the journal for new answers.
        last_answers: mapping from task and epoch to the last answer, for each finished task.
        attempts: mapping from task and epoch to attempts at a finished task; empty unless the run executes
            each answer and asks again after an error.
        failures: mapping from task and epoch to the reason why the answer is missing.
        stopped: reason why the run sends no more questions; None while the run goes on.
        answer_limit: maximum number of tokens of further answers by default; None for no limit.
    """

    def __init__(self, job: QuestionJob, journal: AnswerJournal, watch: ProgressWatch | None) -> None:
        self.job = job
        self.journal = journal
        self.last_answers: dict[TaskIdAndEpoch, Answer] = {}
        self.attempts: dict[TaskIdAndEpoch, tuple[Attempt, ...]] = {}
        self.failures: dict[TaskIdAndEpoch, str] = {}
        self.stopped: EaiError | None = None
        self.answer_limit = job.answer_limit
        self._watch = watch
        self._new_tokens = 0
        self._first_tasks: dict[TaskIdAndEpoch, bool] = {}  # whether the request failed
        self._has_answers = False
        for key in product(job.prompts, range(1, job.epochs + 1)):
            if journal.has_answers(key):
                self.open_conversation(key)

    def has_all_answers(self, job: QuestionJob) -> bool:
        """Whether all questions of a job are answered. The job has all tasks of the run, or some."""
        return all(key in self.last_answers for key in product(job.prompts, range(1, job.epochs + 1)))

    @property
    def _number_of_questions_to_ask(self) -> int:
        return len(self.job.prompts) * self.job.epochs

    def open_conversation(self, key: TaskIdAndEpoch) -> _ConversationInJournal:
        """Return the conversation about a task in an epoch (round of answers), with the journal's answers."""
        recorded = _ConversationInJournal(key, self.job.start_conversation(*key), [])
        while not recorded.conversation.is_over:
            answer = self.journal.find_answer(
                key, self.hash_request_for_next_answer(recorded), len(recorded.answers) + 1
            )
            if answer is None:
                break
            self._add_to_conversation(recorded, answer)
        return recorded

    def hash_request_for_next_answer(self, recorded: _ConversationInJournal) -> str:
        """Return the digest of everything on which the next answer of a conversation depends."""
        task_id, _ = recorded.key
        return self.job.hash_request(task_id, recorded.conversation.question, len(recorded.answers) + 1)

    def add_answer(self, recorded: _ConversationInJournal, answer: Answer) -> None:
        """Write an answer to the journal, and add it to its conversation and to the answers of the run.

        Raises:
            InputError: the journal cannot be written; then the run sends no more questions.
        """
        try:
            self.journal.write_answer(answer)
        except InputError as error:
            self.stopped = error
            raise
        self._add_to_conversation(recorded, answer)
        self._new_tokens += answer.usage.output_tokens or 0
        self.call_progress_callback()

    def record_failure(self, task_id: str, epoch: int, reason: str) -> None:
        """Record that a request failed after all repetitions, so that its task gets no answer."""
        self.failures[task_id, epoch] = reason
        # at its end, the run prints the error that stopped it
        self.call_progress_callback("" if self.stopped else reason)

    def stop_asking_questions(self, reason: str) -> None:
        """Record a reason why no request can succeed, so that the run sends no more questions."""
        hint = "nothing more was asked, and what is answered is kept; the same command resumes from here"
        self.stopped = EaiError(f"{self.job.endpoint.model}: {reason}; {hint}")

    def record_request(self, key: TaskIdAndEpoch) -> None:
        """Record the task of a request that begins, unless `MAX_FIRST_FAILURES` tasks are recorded already.

        `record_failure_and_stop_if_all_failed` reads the recorded tasks.
        """
        if len(self._first_tasks) < MAX_FIRST_FAILURES:
            self._first_tasks.setdefault(key, False)

    def record_failure_and_stop_if_all_failed(self, key: TaskIdAndEpoch, reason: str) -> None:
        """Record a failure that may recur at every request.

        Stop if the first `MAX_FIRST_FAILURES` tasks have all failed in this way, and no task has an answer.
        """
        if key in self._first_tasks:
            self._first_tasks[key] = True
        is_complete = len(self._first_tasks) == MAX_FIRST_FAILURES
        if is_complete and all(self._first_tasks.values()) and not self._has_answers:
            self.stop_asking_questions(f"all of the first {MAX_FIRST_FAILURES} requests failed: {reason}")

    def call_progress_callback(self, failure: str = "") -> None:
        """Call the progress callback with numbers of answered, failed and all questions, and output tokens.

        Args:
            failure: reason of a new failure.
        """
        if self._watch is not None:
            total = self._number_of_questions_to_ask
            self._watch(len(self.last_answers), len(self.failures), total, self._new_tokens, failure)

    def _add_to_conversation(self, recorded: _ConversationInJournal, answer: Answer) -> None:
        key, conversation, answers = recorded
        answers.append(answer)
        self._has_answers = True
        conversation.add_answer(answer.text)
        if conversation.is_over:
            self.last_answers[key] = answer
            if conversation.attempts:
                self.attempts[key] = tuple(add_answer_details_to_attempts(conversation.attempts, answers))
