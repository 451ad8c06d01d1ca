"""Scoring many answers, in this process or in several."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import active_children

from eai.abilities.record import Record
from eai.abilities.responses import Response, ResponseFile
from eai.benchmarks.suite import Suite

CLEANING_SECONDS = 1
"""How long an interrupted worker may take to end its planner and to remove its files."""


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
    )
