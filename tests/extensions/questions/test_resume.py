from __future__ import annotations

from pathlib import Path

from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions.question import questions_to_bytes
from eai.extensions.questions.writer import QuestionGenerator
from eai.tasks.source import Source
from run.test_resume import TASKS, must_stop_after_one_more_answer


def test_a_built_in_model_answers_one_more_question_at_most_after_an_interrupt(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    questions = QuestionGenerator(find_benchmark("virtualhome"), Source(data_store)).write_questions(
        number=TASKS
    )
    file = tmp_path / "questions.jsonl"
    file.write_bytes(questions_to_bytes(list(questions)))
    must_stop_after_one_more_answer("eai/oracle", "world_model", str(file), tmp_path / "out")
