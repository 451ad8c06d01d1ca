"""Scoring many answers, in this process or in several."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

from eai.abilities.record import Record
from eai.abilities.responses import Response, ResponseFile
from eai.abilities.suite import Suite

_CHUNKS_PER_WORKER = 4


def score_batch(
    suite: Suite, answers: ResponseFile, *, workers: int = 1, explanations: bool = False
) -> list[Record]:
    """The records of a model's answers, in the order of the answers.

    Args:
        suite: the tasks, opened for these answers.
        answers: what to score.
        workers: how many processes to use; they share what the suite has loaded where the system can fork.
        explanations: put the step-by-step explanation into each record.
    """
    score = partial(_score, suite, answers.model, explanations=explanations)
    if workers == 1 or len(answers.responses) < 2 * workers:
        return score(answers.responses)
    with ProcessPoolExecutor(workers) as pool:
        chunks = _chunks(answers.responses, workers * _CHUNKS_PER_WORKER)
        return [record for records in pool.map(score, chunks) for record in records]


def _score(suite: Suite, model: str, responses: Iterable[Response], *, explanations: bool) -> list[Record]:
    return [_record(suite, model, response, explanations=explanations) for response in responses]


def _record(suite: Suite, model: str, response: Response, *, explanations: bool) -> Record:
    scorer = suite.scorer(response.task_id)
    verdict = scorer.score(response.text)
    if explanations:
        explanation = scorer.explain(response.text).to_json()
        verdict = replace(verdict, details={**(verdict.details or {}), "explanation": explanation})
    return Record(
        suite.protocol,
        suite.domain.value,
        suite.ability,
        model,
        response.task_id,
        response.text,
        suite.data_sha256,
        verdict,
    )


def _chunks(responses: Sequence[Response], count: int) -> list[Sequence[Response]]:
    size = -(-len(responses) // count)
    return [responses[i : i + size] for i in range(0, len(responses), size)]
