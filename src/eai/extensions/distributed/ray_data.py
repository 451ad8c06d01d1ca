"""Score batches of answers as a step of Ray Data or Spark, and add verdicts as columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from eai.abilities.declaration import AnswerOutcome
from eai.base.errors import InputError
from eai.benchmarks.suite import Suite
from eai.results.batch import Scoring
from eai.results.record import Record
from eai.results.records import format_record_line
from eai.results.responses import COLUMNS, Response
from eai.results.summary import find_answer_outcome as outcome_of

RECORD_COLUMNS = {"record": "string", "outcome": "string", "success": "boolean"}
"""Types of the columns that scoring adds, in Spark's notation, by column name."""


class BatchScorer:
    """Scores rows of a data set, as a function for `ray.data.Dataset.map_batches`.

    Ray creates one scorer in each actor (worker process); the actor keeps the tasks in memory. If an actor
    dies, another actor scores its batch. This class does not import Ray.

    Args:
        suite: The suite that `Suite.choose_suite_for_answers` returns for the answers in the data set. It
            must be opened by name, so that actors can open it again.
        model: Name of the model that answered.
        explanations: Whether each record contains its step-by-step explanation.
    """

    def __init__(self, suite: Suite, model: str, *, explanations: bool = False) -> None:
        self._suite = suite
        self._model = model
        self._explanations = explanations

    def __call__(self, batch: Mapping[str, Sequence[Any]]) -> dict[str, Sequence[Any]]:
        """Return the batch with three more columns: record, outcome and success.

        A record is the line that ``records.jsonl`` would contain. All three columns are null if the data set
        lacks the task because its scene is unpublished. Success is also null if all statistics leave out
        the task.

        Args:
            batch: Columns by name: ``identifier`` and ``llm_output``, as in response files, and any other
                columns.

        Raises:
            InputError: One of these two columns is missing, or a task does not exist.
        """
        if not batch.keys() >= set(COLUMNS):
            raise InputError(f"expected the columns {' and '.join(COLUMNS)}, found {', '.join(batch)}")
        identifiers, texts = (batch[column] for column in COLUMNS)
        task_ids = [self._suite.benchmark.data.task_id_of(str(identifier)) for identifier in identifiers]
        answers = [
            Response(task_id, str(text) if isinstance(text, str) else "")  # pandas has NaN for a missing text
            for task_id, text in zip(task_ids, texts, strict=True)
            if task_id is not None
        ]
        records = Scoring().score_records(self._suite, self._model, answers, explanations=self._explanations)
        scored = [
            (None, None, None) if task_id is None else _make_values_of_record_columns(next(records))
            for task_id in task_ids
        ]
        return {
            **batch,
            **{column: [row[index] for row in scored] for index, column in enumerate(RECORD_COLUMNS)},
        }

    def score_frames(self, frames: Iterable[Any]) -> Iterator[Any]:
        """Yield each data frame with the columns `RECORD_COLUMNS` added, for ``mapInPandas`` of Spark.

        `RECORD_COLUMNS` also gives the types of the columns.
        """
        for frame in frames:
            scored = self({column: frame[column].tolist() for column in COLUMNS})
            yield frame.assign(**{column: scored[column] for column in RECORD_COLUMNS})


def _make_values_of_record_columns(record: Record) -> tuple[str, str, bool | None]:
    outcome = outcome_of(record)
    excluded = record.verdict.excluded is not None
    return format_record_line(record), outcome.value, None if excluded else outcome is AnswerOutcome.SUCCESS
