"""Check a benchmark: its domain by random walks, its tasks' goals and plans, and its annotations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias, cast

import eai.logic.formula as f
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.base.errors import InputError, did_you_mean
from eai.base.grouping import MapItems, map_one_by_one
from eai.base.store import ignore_progress
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic.traversal import get_bound_variables, walk_subformulas
from eai.planning.planner import Planner
from eai.planning.search import Limits, SearchEndReason
from eai.tasks.goal_test import GoalTest
from eai.tasks.goal_text import check_goal_names
from eai.tasks.planning import find_plan
from eai.tasks.source import DataMistake, Source
from eai.tasks.task import NO_GOALS, Task
from eai.tasks.task_files import find_mistakes_in_task
from eai.world.conformance import check_domain
from eai.world.derived import DefinedPredicate
from eai.world.domain import Domain
from eai.world.operator import find_operator_conditions

if TYPE_CHECKING:
    from eai.abilities.transition_modeling.verdict import OperatorVerdict

_EXECUTED_ABILITIES = (Ability.ACTION_SEQUENCING, Ability.TRANSITION_MODELING)
"""Abilities whose gold (right) answers are checked by executing them, or by giving them to a planner."""

MAX_CHECKED_INITIAL_STATES = 5
"""Maximum number of initial states from which random actions test the domain's declaration."""

_LIMITS = Limits(looks=150_000)
"""Limits of the search for a task's plan. The search takes about a second on a usual processor."""


def check_benchmark(
    benchmark: Benchmark, source: Source, map_items: MapItems = map_one_by_one
) -> tuple[list[DataMistake], Counter[SearchEndReason]]:
    """Return all problems of a benchmark, and counts of the searches for plans by how they ended.

    A plan is searched for each task without an annotated plan, except for tasks excluded as unsolvable.

    Args:
        benchmark: the benchmark.
        source: the source of its tasks.
        map_items: applies a function to the ids of tasks, for example in several processes.
    """
    domain, tasks = benchmark.domain, benchmark.tasks(source)
    initial_states = [tasks[task_id].initial for task_id in list(tasks)[:MAX_CHECKED_INITIAL_STATES]]
    findings = [DataMistake(domain.name, defect) for defect in check_domain(domain, initial_states)]
    kinds = {kind for task in tasks.values() for kind in task.scene.object_mask_by_kind}
    for subject, formulas in _list_domain_formulas(domain):
        for kind in dict.fromkeys(chain.from_iterable(map(_list_quantified_categories, formulas))):
            if kind not in kinds:
                problem = f"no task has an object of the kind {kind}{did_you_mean(kind, kinds)}"
                findings.append(DataMistake(domain.name, f"{subject}: {problem}"))
    ends, task_ids = Counter[SearchEndReason](), list(tasks)
    check_tasks = _TaskChecker(benchmark, replace(source, report=ignore_progress))
    if not benchmark.reference:  # other processes open a benchmark by its reference
        map_items = map_one_by_one
    for task_id, (problems, end) in zip(task_ids, map_items(check_tasks, task_ids), strict=True):
        ends.update([] if end is None else [end])
        findings += [DataMistake(task_id, problem) for problem in problems]
    return findings, ends


_CheckedTask: TypeAlias = tuple[list[str], "SearchEndReason | None"]
"""The mistakes in a task's data, and the reason why the search for a plan ended; None without a search."""


@dataclass(frozen=True)
class _TaskChecker:
    """Checks tasks, given their ids.

    Another process that unpickles a checker opens the benchmark again, by its reference.
    """

    benchmark: Benchmark
    source: Source

    def __reduce__(self) -> tuple[Callable[[str, Source], _TaskChecker], tuple[str, Source]]:
        return _open_task_checker, (self.benchmark.reference, self.source)

    @cached_property
    def _planner(self) -> Planner:
        return Planner(self.benchmark.domain)

    def __call__(self, task_ids: Sequence[str]) -> list[_CheckedTask]:
        tasks = self.benchmark.tasks(self.source)
        return [self._check_task(tasks[task_id]) for task_id in task_ids]

    def _check_task(self, task: Task) -> _CheckedTask:
        problems = list(_find_task_problems(task, self.benchmark.domain))
        if problems or task.script or task.unsolvable is not None:
            return problems, None
        end = find_plan(task, self._planner, _LIMITS).end
        return ["no plan reaches its goals"] if end is SearchEndReason.UNREACHABLE else [], end


def _open_task_checker(reference: str, source: Source) -> _TaskChecker:
    return _TaskChecker(find_benchmark(reference), source)


def _find_task_problems(task: Task, domain: Domain) -> Iterator[str]:
    """Yield the problems of a task, such as a plan that misses the goals."""
    if not task.goals:
        yield NO_GOALS
        return
    for number, goal in enumerate(task.goals):
        try:
            check_goal_names(goal.formula, task.scene)
        except InputError as error:
            yield f"goals.{number}: {error}"
            return
    yield from find_mistakes_in_task(task, domain)


def _list_domain_formulas(domain: Domain) -> Iterator[tuple[str, Iterable[f.Formula]]]:
    for operator in domain.operators:
        yield f"operator {operator.name}", find_operator_conditions(operator)
    for derived in domain.vocabulary.derived:
        if isinstance(derived, DefinedPredicate):
            yield f"derived predicate {derived.name}", [derived.definition]


def _list_quantified_categories(formula: f.Formula) -> Iterator[str]:
    for subformula in walk_subformulas(formula):
        yield from filter(None, [variable.category for variable in get_bound_variables(subformula)])


def check_annotations(benchmark: Benchmark, source: Source) -> Iterator[DataMistake]:
    """Yield errors in the annotations of a benchmark, found by executing the annotations.

    The errors are these:

    - plans that miss their goals,
    - goals that are false in the annotated final state,
    - gold (right) operators with which a planner does not solve the problem.

    Tasks excluded from statistics of plans are skipped.

    Raises:
        DataError: the data cannot be obtained.
    """
    for ability in [supported for supported in PAPER_ABILITIES if supported in _EXECUTED_ABILITIES]:
        suite = open_suite(benchmark, ability, source=source)
        book = open_gold_answers(benchmark, ability, source)
        for task_id in suite.task_ids:
            task = suite.tasks.get(task_id)
            if ability is Ability.ACTION_SEQUENCING and task is not None:
                if not task.script:
                    continue
                yield from _check_goals_in_annotated_final_state(benchmark.name, task)
            yield from _report_failed_gold_answer(
                benchmark.name, task_id, suite.score(task_id, book[task_id].text)
            )


def _check_goals_in_annotated_final_state(benchmark_name: str, task: Task) -> Iterator[DataMistake]:
    if task.annotated_final is None or task.unplannable_reason is not None:
        return
    held = GoalTest(task.without_goals_over_time).evaluate_each_goal(
        task.annotated_final, [step.operator for step in task.script]
    )
    if not all(held):
        missed = len(held) - sum(held)
        yield DataMistake(
            benchmark_name,
            f"{task.id}: {missed} of {len(held)} goals do not hold in the annotated final state",
        )


def _report_failed_gold_answer(benchmark_name: str, task_id: str, verdict: Verdict) -> Iterator[DataMistake]:
    if verdict.excluded is not None:
        return
    if isinstance(verdict, PlanVerdict):
        if verdict.success is False:
            reason = verdict.error.detail if verdict.error is not None else "a goal is missed"
            yield DataMistake(benchmark_name, f"{task_id}: the plan fails: {reason}")
        return
    operators = cast("OperatorVerdict", verdict)
    if operators.success is False:
        outcome = "no answer" if operators.planner is None else operators.planner.value
        yield DataMistake(
            benchmark_name, f"{task_id}: the gold operators do not solve their problem: {outcome}"
        )
