"""World-model questions in Inspect: one task, to which ``-T domain=`` names a file."""

from __future__ import annotations

from pathlib import Path

import inspect_ai
import pytest

from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions.question import QuestionKind, questions_to_bytes
from eai.extensions.questions.writer import QuestionGenerator
from eai.run.registry import TASKS
from eai.tasks.source import Source

pytestmark = pytest.mark.filterwarnings("ignore")  # Inspect's are none of ours


def test_a_task_asks_the_questions_of_a_file_and_scores_in_the_log(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    writer = QuestionGenerator(find_benchmark("behavior"), Source(data_store))
    questions = list(writer.write_questions((QuestionKind.FORWARD, QuestionKind.WHY_NOT), number=12))
    file = tmp_path / "questions.jsonl"
    file.write_bytes(questions_to_bytes(questions))
    task = TASKS["world_model"](domain=str(file))
    assert [sample.id for sample in task.dataset] == [question.id for question in questions]
    assert [sample.input[0].text for sample in task.dataset] == [q.prompt for q in questions]  # type: ignore[union-attr]
    (log,) = inspect_ai.eval(task, model="eai/oracle", log_dir=str(tmp_path), display="none")
    assert log.status == "success"
    assert log.results is not None
    metrics = {name: value.value for score in log.results.scores for name, value in score.metrics.items()}
    assert metrics["accuracy"] == metrics["forward"] == metrics["right"] == 1.0


def test_a_file_that_cannot_be_used_is_refused() -> None:
    with pytest.raises(InputError, match=r"none\.jsonl"):
        TASKS["world_model"](domain="none.jsonl")
