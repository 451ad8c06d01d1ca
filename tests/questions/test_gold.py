"""Every gold answer is what a naive engine makes of the prompt alone."""

from __future__ import annotations

import pytest

from eai.abilities.task import GoalKind
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.source import Source
from eai.data.store import Store
from eai.logic.traversal import objects
from eai.questions.question import Form, Kind, Question
from eai.questions.writer import Wanted, Writer
from questions.naive import answer_of, read_world

CELLS = len(Kind) * len(Form)


def recomputed(question: Question, benchmark: Benchmark, source: Source) -> frozenset[str]:
    task = benchmark.tasks(source)[question.task]
    names = read_world(question.prompt, benchmark.domain).scene.index.keys()
    goals = [
        goal.formula
        for goal in task.goals
        if goal.kind is not GoalKind.ACTION and set(objects(goal.formula)) <= names
    ]
    return answer_of(question, benchmark.domain, goals)


def differing(benchmark: Benchmark, source: Source, wanted: Wanted) -> list[str]:
    questions = list(Writer(benchmark, source).write(wanted))
    assert {question.kind for question in questions} == set(wanted.kinds)
    return [
        f"{question.id}: {sorted(question.answer)} is {sorted(naive)}"
        for question in questions
        if frozenset(question.answer) != (naive := recomputed(question, benchmark, source))
    ]


def test_in_a_world_of_ones_own(lamps: Benchmark) -> None:
    assert differing(lamps, Source(), Wanted(number=4 * CELLS)) == []


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_in_households(domain: str, data_store: Store) -> None:
    assert differing(find_benchmark(domain), Source(data_store), Wanted(number=CELLS, seed=1)) == []
