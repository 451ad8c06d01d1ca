"""The questions of a seed, of every kind and form, are those that they have been."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions.question import Question, QuestionForm, QuestionKind, questions_to_bytes
from eai.extensions.questions.writer import QuestionGenerator
from golden_files import assert_golden

CELLS = len(QuestionKind) * len(QuestionForm)


def told(questions: Sequence[Question]) -> list[str]:
    return [
        f"{question.id}: {len(question.answer)} of {len(question.prompt)} characters, "
        f"{hashlib.sha256(questions_to_bytes([question])).hexdigest()[:12]}"
        for question in questions
    ]


def written(benchmark: Benchmark, each: int) -> list[str]:
    return told(list(QuestionGenerator(benchmark).write_questions(number=each * CELLS, seed=1)))


def test_questions_about_the_example_world_match_the_golden_file(lamps: Benchmark) -> None:
    assert_golden(Path(__file__).with_name("golden_lamps.txt"), written(lamps, 2))


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_questions_about_households_match_the_golden_files(domain: str, data_store: DataPackStore) -> None:
    assert_golden(Path(__file__).with_name(f"golden_{domain}.txt"), written(find_benchmark(domain), 4))
