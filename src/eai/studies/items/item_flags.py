"""Flags of tasks from the data set: whether there is a plan, whether names are clear."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import cache

from eai.abilities.declaration import declaration_of
from eai.abilities.planning import find_plan
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task import GoalKind, Task
from eai.abilities.verdict import PlanVerdict
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.gold_answers import AnswerBook, open_answer_book, open_planned_book
from eai.benchmark.registry import find_benchmark, registered
from eai.benchmark.suite import Suite, open_suite
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rename_objects
from eai.planning.planner import Planner
from eai.planning.search import Limits, SearchEnd, SearchResult
from eai.results.lines import SuiteKey
from eai.studies.items.analysis import Flag
from eai.tasks.source import Source, TaskSet
from eai.world.execution import Action


class ItemFlags:
    """Looks tasks up in the data set; of those that no model solves, it asks whether there is a plan.

    That there is one means that an answer is right by the rules that the models were scored by: the gold
    answer, or else one that is made of a plan that the built-in planner finds.

    Args:
        source: where the data set is.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._domain = cache(self._open_domain)
        self._opened = cache(self._open_suite)

    def __call__(self, suite: SuiteKey, task: str, unsolved: bool) -> Iterator[Flag]:
        """The flags of a task."""
        domain = self._domain(suite.domain)
        found = None if domain is None else domain.tasks.get(task)
        if domain is None or found is None or not declaration_of(Ability(suite.ability)).has_plans:
            if unsolved:
                yield Flag.UNSOLVED
            return
        if unsolved:
            yield self._of_unsolved(domain, suite, found)
        if _is_ambiguous(found, domain.benchmark):
            yield Flag.AMBIGUOUS

    def _of_unsolved(self, domain: _Domain, key: SuiteKey, task: Task) -> Flag:
        suite, books = self._opened(key, domain)
        for book in books:
            answer = book[task.id].text
            verdict = suite.over([answer]).score(task.id, answer)
            if isinstance(verdict, PlanVerdict) and verdict.success:
                return Flag.PLAN_EXISTS
        return Flag.NO_PLAN if domain.end(task) is SearchEnd.UNREACHABLE else Flag.UNSOLVED

    def _open_suite(self, key: SuiteKey, domain: _Domain) -> tuple[Suite, tuple[AnswerBook, ...]]:
        """A suite, its gold answers, and answers that are made of the built-in planner's plans."""
        ability, protocol = Ability(key.ability), Protocol(key.protocol)
        suite = open_suite(domain.benchmark, ability, protocol, source=self._source)
        gold = open_answer_book(domain.benchmark, ability, self._source)
        planned = open_planned_book(domain.benchmark, ability, self._source, find=domain.find)
        return suite, (gold, planned)

    def _open_domain(self, name: str) -> _Domain | None:
        return _Domain(find_benchmark(name), self._source) if name in registered() else None


class _Domain:
    """A benchmark with its tasks and a planner."""

    def __init__(self, benchmark: Benchmark, source: Source) -> None:
        self.benchmark = benchmark
        self.tasks: TaskSet[Task] = benchmark.tasks(source)
        self._planner = Planner(benchmark.domain)
        self._found: dict[str, SearchResult[Action]] = {}

    def find(self, task: Task, planner: Planner, limits: Limits | None = None) -> SearchResult[Action]:
        """The result of the search for a plan of a task, which several suites ask for."""
        if task.id not in self._found:
            self._found[task.id] = find_plan(task, planner, limits)
        return self._found[task.id]

    def end(self, task: Task) -> SearchEnd:
        """How that search ends."""
        return self.find(task, self._planner).end


def _is_ambiguous(task: Task, benchmark: Benchmark) -> bool:
    """Whether two goals about states differ only in which of several objects of one name they are about."""
    names = (thing.name for thing in task.scene.objects)
    called = dict(zip(names, benchmark.goals.names(task), strict=True))
    goals = dict.fromkeys(goal.formula for goal in task.goals_of(GoalKind.STATE))
    asked = Counter(print_ltl(rename_objects(goal, called)) for goal in goals)
    return any(times > 1 for times in asked.values())
