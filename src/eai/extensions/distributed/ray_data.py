"""Scoring as a step of Ray Data or Spark: batches of answers in, the same with their records out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from eai.abilities.declaration import AnswerOutcome
from eai.base.errors import InputError
from eai.benchmarks.suite import Suite
from eai.results.batch import Scoring
from eai.results.record import Record
from eai.results.records import record_line
from eai.results.responses import COLUMNS, Response
from eai.results.summary import outcome_of as outcome_of

ADDED = {"record": "string", "outcome": "string", "success": "boolean"}
"""The columns that are added, with their types as Spark writes them."""


class Scores:
    """The function for `ray.data.Dataset.map_batches` that scores the rows of a data set.

    Ray makes it once in each actor, which keeps the tasks that it has made; a batch whose actor dies is done
    again by another one. It needs nothing of Ray's itself.

    Args:
        suite: the tasks, opened by name for these answers (`Suite.adapt_to_answers`); actors reopen them.
        model: who answered.
        explanations: put the step-by-step explanation into each record.
    """

    def __init__(self, suite: Suite, model: str, *, explanations: bool = False) -> None:
        self._suite = suite
        self._model = model
        self._explanations = explanations

    def __call__(self, batch: Mapping[str, Sequence[Any]]) -> dict[str, Sequence[Any]]:
        """The batch with a record, an outcome and whether that is a success for each answer.

        A record is what its line in ``records.jsonl`` would be. All three are null for tasks that are known
        not to be in the data set, whose rows a response file may have; success also where a task is excluded.

        Args:
            batch: columns by name: ``identifier`` and ``llm_output``, as in response files, and any others.

        Raises:
            InputError: one of the two is missing, or there is no such task.
        """
        if not batch.keys() >= set(COLUMNS):
            raise InputError(f"expected the columns {' and '.join(COLUMNS)}, found {', '.join(batch)}")
        identifiers, texts = (batch[column] for column in COLUMNS)
        task_ids = [self._suite.benchmark.data.task_id_of(str(identifier)) for identifier in identifiers]
        answers = [
            Response(task_id, str(text or ""))
            for task_id, text in zip(task_ids, texts, strict=True)
            if task_id is not None
        ]
        records = Scoring().records(self._suite, self._model, answers, explanations=self._explanations)
        scored = [(None, None, None) if task_id is None else _columns(next(records)) for task_id in task_ids]
        return {**batch, **{column: [row[place] for row in scored] for place, column in enumerate(ADDED)}}

    def frames(self, frames: Iterable[Any]) -> Iterator[Any]:
        """The same for data frames, as ``mapInPandas`` of Spark gives them; ``ADDED`` has the types."""
        for frame in frames:
            scored = self({column: frame[column].tolist() for column in COLUMNS})
            yield frame.assign(**{column: scored[column] for column in ADDED})


def _columns(record: Record) -> tuple[str, str, bool | None]:
    outcome = outcome_of(record)
    excluded = record.verdict.excluded is not None
    return record_line(record), outcome.value, None if excluded else outcome is AnswerOutcome.SUCCESS
