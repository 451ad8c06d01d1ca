"""The desk of a run: where answers are looked up, written down and counted while Inspect asks for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from eai.run.job import Job
from eai.run.journal import Journal
from eai.scoring.answer import Answer, Place


@dataclass(frozen=True, slots=True)
class Count:
    """How far a run is.

    Attributes:
        answered: answers there are, found ones included.
        failed: requests that were given up.
        total: answers that are wanted.
    """

    answered: int
    failed: int
    total: int


Watch: TypeAlias = Callable[[Count], None]
"""Is told how far a run is."""


def unwatched(count: Count) -> None:
    """Tells nobody."""


class Desk:
    """What is known of a job, and what is still to be asked.

    Args:
        job: what is asked.
        journal: where answers go; answers to the same requests that are there already are taken from it.
        watch: told of every answer and failure.

    Attributes:
        job: what is asked.
        answers: the answers there are, by task and epoch.
        failures: why there is no answer, by task and epoch.
        requests: digest of all that decides the answer to a task's prompt, by task.
    """

    def __init__(self, job: Job, journal: Journal, watch: Watch = unwatched) -> None:
        self.job = job
        self.answers: dict[Place, Answer] = {}
        self.failures: dict[Place, str] = {}
        self._journal = journal
        self._watch = watch
        self.requests = {task_id: job.request_sha256(prompt) for task_id, prompt in job.prompts.items()}
        for task_id, request in self.requests.items():
            for epoch in range(1, job.epochs + 1):
                answer = journal.find(task_id, epoch, request)
                if answer is not None:
                    self.answers[task_id, epoch] = answer

    @property
    def complete(self) -> bool:
        """Whether there are all answers."""
        return len(self.answers) == self._wanted

    @property
    def _wanted(self) -> int:
        return len(self.job.prompts) * self.job.epochs

    def take(self, answer: Answer) -> None:
        """Write an answer down.

        Raises:
            InputError: the journal cannot be written.
        """
        self._journal.add(answer)
        self.answers[answer.task_id, answer.epoch] = answer
        self.tell()

    def give_up(self, task_id: str, epoch: int, why: str) -> None:
        """Note that a request failed for good."""
        self.failures[task_id, epoch] = why
        self.tell()

    def tell(self) -> None:
        """Say how far the run is."""
        self._watch(Count(len(self.answers), len(self.failures), self._wanted))
