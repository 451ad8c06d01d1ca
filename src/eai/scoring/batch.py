"""Scoring many answers, in this process or in several, and what is not answered with them."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from multiprocessing import active_children
from typing import TypeAlias

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.record import NOT_ANSWERED, Record
from eai.abilities.responses import Response, ResponseFile
from eai.benchmarks.suite import Suite

CLEANING_SECONDS = 1
"""How long an interrupted worker may take to end its planner and to remove its files."""

_CHUNKS = 10
"""How many portions a worker gets: often enough word of how far it is, and little overhead."""

_suite: ContextVar[Suite] = ContextVar("suite")
"""What a worker scores with, from its first moment on."""

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


Told: TypeAlias = Callable[[int], None]
"""Is told how many answers are scored so far."""


def untold(scored: int) -> None:
    """Tells nobody."""


def score_run(
    suite: Suite,
    answers: ResponseFile,
    unanswered: Mapping[str, str],
    settings: Settings,
    told: Told = untold,
) -> list[Record]:
    """The records of all tasks that a model was asked, in the order of the data set.

    Args:
        suite: the tasks.
        answers: the answers, whose form together may decide how each is read.
        unanswered: why a task that was asked has no answer, by its id.
        settings: how to score.
        told: is told how far it is.
    """
    opened = suite.over([response.text for response in answers.responses])
    scored = score_batch(
        opened, answers, workers=settings.workers, explanations=settings.explanations, told=told
    )
    records = {record.task_id: record for record in scored}
    for task_id, why in unanswered.items():
        records[task_id] = _lacking(opened, answers.model, task_id, why, left_out=settings.allow_missing)
    return [records[task_id] for task_id in suite.task_ids if task_id in records]


def score_batch(
    suite: Suite,
    answers: ResponseFile,
    *,
    workers: int = 1,
    explanations: bool = False,
    told: Told = untold,
) -> list[Record]:
    """The records of a model's answers, in the order of the answers.

    Args:
        suite: the tasks, opened for these answers.
        answers: what to score.
        workers: how many processes to use; each opens the suite for itself.
        explanations: put the step-by-step explanation into each record.
        told: is told how far it is.
    """
    count = len(answers.responses)
    workers = min(workers, count)
    if suite.reopen is None or workers < 2:
        score = partial(_record, suite, answers.model, explanations=explanations)
        return _counted(map(score, answers.responses), told)
    score_there = partial(_score_in_worker, answers.model, explanations=explanations)
    chunk = max(1, count // (workers * _CHUNKS))
    with worker_pool(workers, partial(_open_in_worker, suite.reopen)) as pool:
        with _interrupts_held():  # until all workers are there, who inherit that
            scored = pool.map(score_there, answers.responses, chunksize=chunk)
        return _counted(scored, told)


def _counted(records: Iterable[Record], told: Told) -> list[Record]:
    """All records, of whose number word is given as they come."""
    found: list[Record] = []
    for record in records:
        found.append(record)
        told(len(found))
    return found


@contextmanager
def worker_pool(workers: int, open_worker: Callable[[], None] | None = None) -> Iterator[ProcessPoolExecutor]:
    """A pool of processes that an interrupt ends, whatever they do.

    A terminal interrupts all processes at once. A worker that ended by itself might hold a lock for which
    another would wait for ever, so that workers leave it to their caller, who has them clean up and kills
    what stays.
    """
    others = active_children()
    with ProcessPoolExecutor(workers, initializer=partial(_begin, open_worker)) as pool:
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


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Interrupts wait until the end of the block, and so they do for ever in processes that it starts."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(open_worker: Callable[[], None] | None) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if open_worker is not None:
        open_worker()


def _open_in_worker(reopen: Callable[[], Suite]) -> None:
    _suite.set(reopen())


def _score_in_worker(model: str, response: Response, *, explanations: bool) -> Record:
    return _record(_suite.get(), model, response, explanations=explanations)


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
