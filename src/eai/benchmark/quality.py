"""Are the annotations of a data set right? Its plans, its goals, its planning problems, each carried out."""

from __future__ import annotations

from collections.abc import Iterator

from eai.abilities.goal_test import GoalTest
from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.abilities.transition_modeling.declaration import OperatorVerdict
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.gold_answers import open_answer_book
from eai.benchmark.suite import open_suite
from eai.tasks.source import Finding, Source


def check_annotations(benchmark: Benchmark, source: Source) -> Iterator[Finding]:
    """Find errors in the annotations of a benchmark, as far as carrying them out can tell.

    That is: plans that do not reach their goals, goals that do not hold where the data set says that its plan
    ends, and gold operators with which a planner does not solve their problem. What is in no statistics of
    plans is passed over.

    Raises:
        DataError: the data cannot be had.
    """
    for ability in (Ability.ACTION_SEQUENCING, Ability.TRANSITION_MODELING):
        suite = open_suite(benchmark, ability, source=source)
        book = open_answer_book(benchmark, ability, source)
        for task_id in suite.task_ids:
            task = suite.tasks.get(task_id)
            if ability is Ability.ACTION_SEQUENCING and task is not None:
                if not task.script:
                    continue
                yield from _of_goals(benchmark.name, task)
            yield from _of_gold(benchmark.name, task_id, suite.score(task_id, book.gold(task_id).text))


def _of_goals(name: str, task: Task) -> Iterator[Finding]:
    if task.annotated_final is None or task.left_out is not None:
        return
    held = GoalTest(task.at_the_end).reached(task.annotated_final, [step.operator for step in task.script])
    if not all(held):
        missed = len(held) - sum(held)
        yield Finding(
            name, f"{task.id}: {missed} of {len(held)} goals do not hold where its plan is said to end"
        )


def _of_gold(name: str, task_id: str, verdict: Verdict) -> Iterator[Finding]:
    if verdict.excluded is not None:
        return
    match verdict:
        case PlanVerdict(success=False):
            why = verdict.error.detail if verdict.error is not None else "a goal is missed"
            yield Finding(name, f"{task_id}: the plan fails: {why}")
        case OperatorVerdict(success=False):
            outcome = "no answer" if verdict.planner is None else verdict.planner.value
            yield Finding(name, f"{task_id}: the gold operators do not solve their problem: {outcome}")
        case _:
            return
