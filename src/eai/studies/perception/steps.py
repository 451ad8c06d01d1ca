"""Count the steps in answers: the actions of plans, or the subgoals of decompositions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from statistics import fmean

from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark, list_benchmarks
from eai.results.record import Record


def compute_mean_steps(records: Sequence[Record]) -> float | None:
    """Return the mean number of steps in the readable answers of a run.

    The mean is None if no answer can be read, or if the ability's answers are not lists of steps.
    """
    first = records[0]
    if first.domain not in list_benchmarks():
        return None
    count = _make_step_counter(find_benchmark(first.domain), first.ability)
    numbers = [] if count is None else list(_count_plan_steps_of_answers(records, count))
    return fmean(numbers) if numbers else None


def _count_plan_steps_of_answers(
    records: Sequence[Record], count_steps: Callable[[str], int | None]
) -> Iterator[int]:
    for record in records:
        if record.unanswered is None and record.verdict.excluded is None:
            number = count_steps(record.response)
            if number is not None:
                yield number


def _make_step_counter(benchmark: Benchmark, ability: Ability) -> Callable[[str], int | None] | None:
    """Return a function that counts an answer's steps; None if the ability's answers have no steps."""
    if ability is Ability.ACTION_SEQUENCING:
        return lambda text: (
            None
            if isinstance(
                plan := benchmark.notation.plans.read(text, benchmark.domain.operator_arities), Unreadable
            )
            else len(plan.steps)
        )
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        notation = benchmark.subgoal_notation()
        return lambda text: (
            None if isinstance(read := notation.read(text), Unreadable) else len(read.subgoals)
        )
    return None
