from __future__ import annotations

import re
from pathlib import Path

import inspect_ai
import pytest
from inspect_ai.util import registry_info

from eai.benchmark.registry import find_benchmark
from eai.data.store import Store
from eai.errors import InputError
from eai.questions.question import Kind, questions_content
from eai.questions.writer import Wanted, Writer
from eai.run.registry import QUESTIONS
from eai.tasks.source import Source

pytestmark = pytest.mark.filterwarnings("ignore")  # Inspect's are none of ours

FEW = {"kinds": ["forward", "why_not"], "n": 12}


def test_every_benchmark_has_a_task_that_inspect_finds_under_our_name() -> None:
    assert QUESTIONS.keys() == {"virtualhome_questions", "behavior_questions"}
    assert {registry_info(task).name for task in QUESTIONS.values()} == {f"eai/{name}" for name in QUESTIONS}


def test_a_task_asks_what_the_command_writes(data_store: Store, tmp_path: Path) -> None:
    wanted = Wanted((Kind.FORWARD, Kind.WHY_NOT), number=12)
    questions = list(Writer(find_benchmark("behavior"), Source(data_store)).write(wanted))
    file = tmp_path / "questions.jsonl"
    file.write_bytes(questions_content(questions))
    for task in (
        QUESTIONS["behavior_questions"](**FEW),
        QUESTIONS["behavior_questions"](kinds="forward,why_not", n=12),
        QUESTIONS["virtualhome_questions"](file=str(file)),
    ):
        assert [sample.id for sample in task.dataset] == [question.id for question in questions]
        assert [sample.input[0].text for sample in task.dataset] == [q.prompt for q in questions]  # type: ignore[union-attr]


@pytest.mark.parametrize(("model", "share"), [("eai/oracle", 1.0), ("eai/noisy", None)])
def test_answers_are_scored_in_the_log(
    data_store: Store, tmp_path: Path, model: str, share: float | None
) -> None:
    task = QUESTIONS["behavior_questions"](**FEW)
    (log,) = inspect_ai.eval(task, model=model, log_dir=str(tmp_path), display="none", model_args={})
    assert log.status == "success"
    assert log.results is not None
    metrics = {name: value.value for score in log.results.scores for name, value in score.metrics.items()}
    assert metrics.keys() >= {"accuracy", "stderr", "forward", "why_not"}
    if share is not None:
        assert metrics["accuracy"] == metrics["forward"] == share


def test_arguments_that_cannot_be_used_are_refused() -> None:
    for wrong, message in (
        ({"kinds": "foreward"}, "'foreward' is no kind of question: expected one of forward"),
        ({"forms": "essay"}, "'essay' is no form of question: expected one of yes_no, choice, open"),
        ({"file": "none.jsonl"}, "none.jsonl: cannot be read"),
    ):
        with pytest.raises(InputError, match=re.escape(message)):
            QUESTIONS["behavior_questions"](**wrong)
