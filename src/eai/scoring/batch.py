"""Scoring many answers, in this process or in several."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from eai.abilities.record import Record
from eai.abilities.responses import Response, ResponseFile
from eai.benchmarks.suite import Suite


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
    with ProcessPoolExecutor(workers) as pool:
        shares = pool.map(score, [answers.responses[worker::workers] for worker in range(workers)])
        for worker, share in enumerate(shares):
            records.update(zip(range(worker, count, workers), share, strict=True))
    return [records[i] for i in range(count)]


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
    )
