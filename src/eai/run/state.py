"""The desk of a run: where answers are looked up, written down and counted while Inspect asks for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from eai.errors import EaiError, InputError
from eai.prompts.prompt import Prompt
from eai.run.job import Requests
from eai.run.journal import Journal
from eai.scoring.answer import Answer, Place
from eai.scoring.trials import Inquiry, Tried


@dataclass(frozen=True, slots=True)
class Count:
    """How far a run is.

    Attributes:
        answered: tasks that are answered, in every epoch, found answers included.
        failed: tasks that were given up because a request failed.
        total: tasks that are to be answered.
    """

    answered: int
    failed: int
    total: int


Watch: TypeAlias = Callable[[Count], None]
"""Is told how far a run is."""


def unwatched(count: Count) -> None:
    """Tells nobody."""


class Desk:
    """Everything known about a job, and the questions that are still open.

    Args:
        job: what is asked.
        journal: where answers go; answers to the same requests that are there already are taken from it.
        watch: told of every answer and failure.

    Attributes:
        job: what is asked.
        given: the answers there are, by task and epoch; in an experiment of every attempt, in order.
        asked: the questions to which these are the answers.
        inquiries: each task as it is put to the model, by task and epoch; what is over is answered.
        failures: why there is no answer, by task and epoch.
        stopped: why nothing more is to be asked, if that is so.
    """

    def __init__(self, job: Requests, journal: Journal, watch: Watch = unwatched) -> None:
        self.job = job
        self.given: dict[Place, list[Answer]] = {}
        self.asked: dict[Place, list[Prompt]] = {}
        self.inquiries: dict[Place, Inquiry] = {}
        self.failures: dict[Place, str] = {}
        self.stopped: EaiError | None = None
        self._journal = journal
        self._watch = watch
        self._over = 0
        for task_id in job.prompts:
            for epoch in range(1, job.epochs + 1):
                self.inquiries[task_id, epoch] = job.inquiry(task_id, epoch)
                self._recall((task_id, epoch))

    @property
    def complete(self) -> bool:
        """Whether there are all answers."""
        return self._over == len(self.inquiries)

    @property
    def answers(self) -> dict[Place, Answer]:
        """The last answer to each task that is answered, by task and epoch."""
        return {place: given[-1] for place, given in self.given.items() if self.inquiries[place].over}

    @property
    def tried(self) -> dict[Place, Tried]:
        """All answers to each task that is carried out and over, and what became of them."""
        return {
            place: Tried(tuple(given), attempts)
            for place, given in self.given.items()
            if self.inquiries[place].over and (attempts := self.inquiries[place].attempts)
        }

    def request(self, place: Place) -> str:
        """Digest of all that decides the next answer."""
        attempt = len(self.given.get(place, ())) + 1
        return self.job.request_sha256(place[0], self.inquiries[place].question, attempt)

    def take(self, answer: Answer) -> None:
        """Write an answer down.

        Raises:
            InputError: the journal cannot be written; then nothing more is to be asked.
        """
        try:
            self._journal.add(answer)
        except InputError as error:
            self.stopped = error
            raise
        self._accept(answer)
        self.tell()

    def give_up(self, task_id: str, epoch: int, why: str) -> None:
        """Note that a request failed for good."""
        self.failures[task_id, epoch] = why
        self.tell()

    def stop(self, why: str) -> None:
        """Note that no request can ever succeed, so that nothing more is to be asked."""
        hint = "nothing more was asked, and what is answered is kept; the same command resumes from here"
        self.stopped = EaiError(f"{self.job.endpoint.model}: {why}; {hint}")

    def tell(self) -> None:
        """Say how far the run is."""
        self._watch(Count(self._over, len(self.failures), len(self.inquiries)))

    def _recall(self, place: Place) -> None:
        """Take what the journal holds of the answers to a task."""
        while not self.inquiries[place].over:
            attempt = len(self.given.get(place, ())) + 1
            answer = self._journal.find(place, self.request(place), attempt)
            if answer is None:
                return
            self._accept(answer)

    def _accept(self, answer: Answer) -> None:
        place = (answer.task_id, answer.epoch)
        inquiry = self.inquiries[place]
        self.asked.setdefault(place, []).append(inquiry.question)
        self.given.setdefault(place, []).append(answer)
        inquiry.take(answer.text)
        self._over += inquiry.over
