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
from eai.studies.items.study import Flag, TellsFlags
from eai.tasks.source import Source, TaskSet
from eai.world.execution import Action


def item_flags(source: Source) -> TellsFlags:
    """A function that looks tasks up in the data set; of unsolved ones it asks whether there is a plan.

    That there is one means that an answer is right by the rules that the models were scored by: the gold
    answer, or else one that is made of a plan that the built-in planner finds.

    Args:
        source: where the data set is.
    """

    @cache
    def opened(name: str) -> _Domain | None:
        return _Domain(find_benchmark(name), source) if name in registered() else None

    def flags(suite: SuiteKey, task: str, unsolved: bool) -> Iterator[Flag]:
        domain = opened(suite.domain)
        found = None if domain is None else domain.tasks.get(task)
        if domain is None or found is None or not declaration_of(Ability(suite.ability)).has_plans:
            if unsolved:
                yield "unsolved"
            return
        if unsolved:
            yield domain.of_unsolved(suite, found)
        if _is_ambiguous(found, domain.benchmark):
            yield "ambiguous names"

    return flags


class _Domain:
    """A benchmark with its tasks, suites and a planner."""

    def __init__(self, benchmark: Benchmark, source: Source) -> None:
        self.benchmark = benchmark
        self.tasks: TaskSet[Task] = benchmark.tasks(source)
        self._source = source
        self._suite = cache(self._open_suite)
        self._planner = Planner(benchmark.domain)
        self._found: dict[str, SearchResult[Action]] = {}

    def of_unsolved(self, key: SuiteKey, task: Task) -> Flag:
        """The flag of a task that no model solves."""
        suite, books = self._suite(key)
        for book in books:
            answer = book[task.id].text
            verdict = suite.over([answer]).score(task.id, answer)
            if isinstance(verdict, PlanVerdict) and verdict.success:
                return "unsolved: plan exists"
        end = self._find(task, self._planner).end
        return "unsolved: no plan" if end is SearchEnd.UNREACHABLE else "unsolved"

    def _open_suite(self, key: SuiteKey) -> tuple[Suite, tuple[AnswerBook, ...]]:
        """A suite, its gold answers, and answers that are made of the built-in planner's plans."""
        ability, protocol = Ability(key.ability), Protocol(key.protocol)
        suite = open_suite(self.benchmark, ability, protocol, source=self._source)
        gold = open_answer_book(self.benchmark, ability, self._source)
        planned = open_planned_book(self.benchmark, ability, self._source, find=self._find)
        return suite, (gold, planned)

    def _find(self, task: Task, planner: Planner, limits: Limits | None = None) -> SearchResult[Action]:
        """The result of the search for a plan of a task, which several suites ask for."""
        if task.id not in self._found:
            self._found[task.id] = find_plan(task, planner, limits)
        return self._found[task.id]


def _is_ambiguous(task: Task, benchmark: Benchmark) -> bool:
    """Whether two goals about states differ only in which of several objects of one name they are about."""
    names = (thing.name for thing in task.scene.objects)
    called = dict(zip(names, benchmark.goals.names(task), strict=True))
    goals = dict.fromkeys(goal.formula for goal in task.goals_of(GoalKind.STATE))
    asked = Counter(print_ltl(rename_objects(goal, called)) for goal in goals)
    return any(times > 1 for times in asked.values())
