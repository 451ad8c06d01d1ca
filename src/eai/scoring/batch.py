"""Scoring many answers, in this process or in several, and what is not answered with them."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import active_children

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.record import NOT_ANSWERED, Record
from eai.abilities.responses import Response, ResponseFile
from eai.benchmarks.suite import Suite

CLEANING_SECONDS = 1
"""How long an interrupted worker may take to end its planner and to remove its files."""

NO_ROW = "the response file has no row of the task"
"""Why a task without an answer has none, where answers come from a file."""


@dataclass(frozen=True, slots=True)
class Settings:
    """How answers are scored.

    Attributes:
        workers: how many processes to use.
        explanations: put the step-by-step explanation into each record.
        allow_missing: leave tasks without an answer out of all rates instead of counting them as failures.
    """

    workers: int = 1
    explanations: bool = True
    allow_missing: bool = False


def score_run(
    suite: Suite, answers: ResponseFile, unanswered: Mapping[str, str], settings: Settings
) -> list[Record]:
    """The records of all tasks that a model was asked, in the order of the data set.

    Args:
        suite: the tasks.
        answers: the answers, whose form together may decide how each is read.
        unanswered: why a task that was asked has no answer, by its id.
        settings: how to score.
    """
    opened = suite.over([response.text for response in answers.responses])
    scored = score_batch(opened, answers, workers=settings.workers, explanations=settings.explanations)
    records = {record.task_id: record for record in scored}
    for task_id, why in unanswered.items():
        records[task_id] = _lacking(opened, answers.model, task_id, why, left_out=settings.allow_missing)
    return [records[task_id] for task_id in suite.task_ids if task_id in records]


def score_batch(
    suite: Suite, answers: ResponseFile, *, workers: int = 1, explanations: bool = False
) -> list[Record]:
    """The records of a model's answers, in the order of the answers.

    Args:
        suite: the tasks, opened for these answers.
        answers: what to score.
        workers: how many processes to use; each opens the suite for itself.
        explanations: put the step-by-step explanation into each record.
    """
    count = len(answers.responses)
    workers = min(workers, count)
    if suite.reopen is None or workers < 2:
        return _score(suite, answers.model, answers.responses, explanations=explanations)
    score = partial(_score_in_worker, suite.reopen, answers.model, explanations=explanations)
    records: dict[int, Record] = {}
    with worker_pool(workers) as pool:
        shares = pool.map(score, [answers.responses[worker::workers] for worker in range(workers)])
        for worker, share in enumerate(shares):
            records.update(zip(range(worker, count, workers), share, strict=True))
    return [records[i] for i in range(count)]


@contextmanager
def worker_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """A pool of processes that an interrupt ends, whatever they do.

    A terminal interrupts all processes at once. A worker that ended by itself might hold a lock for which
    another would wait for ever, so that workers leave it to their caller, who has them clean up and kills
    what stays.
    """
    others = active_children()
    with ProcessPoolExecutor(workers, initializer=_ignore_interrupts) as pool:
        try:
            yield pool
        except KeyboardInterrupt:
            own = [child for child in active_children() if child not in others]
            for child in own:
                child.terminate()
            for child in own:
                child.join(CLEANING_SECONDS)
                child.kill()
            raise


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _score_in_worker(
    reopen: Callable[[], Suite], model: str, responses: Iterable[Response], *, explanations: bool
) -> list[Record]:
    return _score(reopen(), model, responses, explanations=explanations)


def _score(suite: Suite, model: str, responses: Iterable[Response], *, explanations: bool) -> list[Record]:
    return [_record(suite, model, response, explanations=explanations) for response in responses]


def _record(suite: Suite, model: str, response: Response, *, explanations: bool) -> Record:
    assessment = suite.scorer(response.task_id).assess(response.text)
    return Record(
        suite.protocol,
        suite.domain,
        suite.ability,
        model,
        response.task_id,
        response.text,
        suite.data_sha256,
        assessment.verdict,
        assessment.explain() if explanations else None,
        task=suite.features(response.task_id),
        suite_size=len(suite.task_ids),
    )


def _lacking(suite: Suite, model: str, task_id: str, why: str, *, left_out: bool) -> Record:
    """The record of a task without an answer."""
    verdict = suite.unanswered(task_id)
    if left_out and verdict.excluded is None:
        verdict = DECLARATIONS[suite.ability].verdict(excluded=NOT_ANSWERED)
    return Record(
        suite.protocol,
        suite.domain,
        suite.ability,
        model,
        task_id,
        "",
        suite.data_sha256,
        verdict,
        task=suite.features(task_id),
        unanswered=why,
        suite_size=len(suite.task_ids),
    )
