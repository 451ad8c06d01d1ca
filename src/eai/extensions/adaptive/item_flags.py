"""Flags of tasks that follow from the data set: whether a plan exists, and whether names are ambiguous."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import AnswersByTask, open_answers_of_planner, open_gold_answers
from eai.benchmarks.registry import find_benchmark, list_benchmarks
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.adaptive.flag import Flag, FlagReader
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import rename_objects
from eai.planning.planner import get_planner
from eai.planning.search import SearchEndReason, SearchResult
from eai.results.lines import SuiteKey
from eai.tasks.planning import find_plan
from eai.tasks.source import Source
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action


def make_function_that_flags_doubtful_tasks(source: Source) -> FlagReader:
    """Return a function that yields flags of a task: reasons to use its answers with caution.

    For a task that no model solves, the function looks for a plan. A plan exists if one of two answers is
    right: the gold answer, or an answer made from a plan of the built-in planner. Both answers are scored by
    the same rules (protocol) as the models' answers.

    Args:
        source: access to the data set.
    """

    @cache
    def open_tasks(domain: str) -> Mapping[str, Task]:
        return find_benchmark(domain).tasks(source) if domain in list_benchmarks() else {}

    @cache
    def search_plan(domain: str, task_id: str) -> SearchResult[Action]:
        """Search for a plan of a task. Results are cached, because several suites need them."""
        return find_plan(open_tasks(domain)[task_id], get_planner(find_benchmark(domain).domain))

    @cache
    def open_suite_and_answers(key: SuiteKey) -> tuple[Suite, tuple[AnswersByTask, ...]]:
        """Return a suite (tasks with scoring), gold answers, and answers made from the planner's plans."""
        benchmark, ability = find_benchmark(key.domain), Ability(key.ability)
        gold = open_gold_answers(benchmark, ability, source)
        planned = open_answers_of_planner(
            benchmark, ability, source, find=lambda task, *_: search_plan(key.domain, task.id)
        )
        return open_suite(benchmark, ability, Protocol(key.protocol), source=source), (gold, planned)

    def flag_whether_unsolved_task_has_plan(key: SuiteKey, task_id: str) -> Flag:
        suite, books = open_suite_and_answers(key)
        for book in books:
            answer = book[task_id].text
            verdict = suite.choose_suite_for_answers([answer]).score(task_id, answer)
            if isinstance(verdict, PlanVerdict) and verdict.success:
                return "unsolved: plan exists"
        is_impossible = search_plan(key.domain, task_id).end is SearchEndReason.UNREACHABLE
        return "unsolved: no plan" if is_impossible else "unsolved"

    def find_flags_of_task(key: SuiteKey, task_id: str, unsolved: bool) -> Iterator[Flag]:
        task = open_tasks(key.domain).get(task_id)
        has_plans = task is not None and get_declaration(Ability(key.ability)).answers_are_plans
        if unsolved:
            yield flag_whether_unsolved_task_has_plan(key, task_id) if has_plans else "unsolved"
        if task is not None and has_plans and _has_ambiguous_goals(task, find_benchmark(key.domain)):
            yield "ambiguous names"

    return find_flags_of_task


def _has_ambiguous_goals(task: Task, benchmark: Benchmark) -> bool:
    """Whether two state goals of a task become equal when each object is replaced by its name in answers."""
    names = (thing.name for thing in task.scene.objects)
    called = dict(zip(names, benchmark.notation.goals.list_object_names(task), strict=True))
    goals = dict.fromkeys(goal.formula for goal in task.get_goals_of_kind(GoalKind.STATE))
    asked = Counter(format_ltl(rename_objects(goal, called)) for goal in goals)
    return any(times > 1 for times in asked.values())
