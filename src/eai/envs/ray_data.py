"""Scoring as a step of Ray Data: batches of answers in, the same with their records out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from eai.abilities.responses import COLUMNS, Response
from eai.benchmark.suite import Suite
from eai.errors import InputError
from eai.scoring.batch import Scoring
from eai.scoring.records import line_of

RECORD = "record"
"""The column that is added."""


class Scores:
    """The function for `ray.data.Dataset.map_batches` that scores the rows of a data set.

    Ray makes it once in each actor, which keeps the tasks that it has made; a batch whose actor dies is done
    again by another one. It needs nothing of Ray's itself.

    Args:
        suite: the tasks, opened by name, for these answers (`Suite.over`); an actor opens them again.
        model: who answered.
        explanations: put the step-by-step explanation into each record.
    """

    def __init__(self, suite: Suite, model: str, *, explanations: bool = False) -> None:
        self._suite = suite
        self._model = model
        self._explanations = explanations

    def __call__(self, batch: Mapping[str, Sequence[Any]]) -> dict[str, Sequence[Any]]:
        """The batch with the column ``record``: for each answer what its line in ``records.jsonl`` would be.

        It is null for tasks that are known not to be in the data set, whose rows a response file may have.

        Args:
            batch: columns by name: ``identifier`` and ``llm_output``, as in response files, and any others.

        Raises:
            InputError: one of the two is missing, or there is no such task.
        """
        if not batch.keys() >= set(COLUMNS):
            raise InputError(f"expected the columns {' and '.join(COLUMNS)}, found {', '.join(batch)}")
        identifiers, texts = (batch[column] for column in COLUMNS)
        task_ids = [self._suite.benchmark.task_id_of(str(identifier)) for identifier in identifiers]
        answers = [
            Response(task_id, str(text or ""))
            for task_id, text in zip(task_ids, texts, strict=True)
            if task_id is not None
        ]
        records = Scoring().records(self._suite, self._model, answers, explanations=self._explanations)
        lines = [None if task_id is None else line_of(next(records)) for task_id in task_ids]
        return {**batch, RECORD: lines}
