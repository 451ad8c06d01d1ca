"""Looks up features of tasks in the data set, and finds likely reasons for wrong goals in answers.

The paper says that models state conditions on the way to a goal, or at the start, instead of the goal
(section "Goal interpretation"). Therefore each wrong goal in an answer is tested in every state of the data
set's own plan, up to the plan's first invalid step. The first `WrongGoalReason` that fits counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from functools import cache, cached_property
from itertools import product, takewhile

from eai.abilities.explanation import AtomOrAction
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.features import compute_features
from eai.logic.formula import Atom, Constant
from eai.results.lines import WrongGoalReason
from eai.tasks.goal_test import list_actions_that_meet_goal
from eai.tasks.source import Source
from eai.tasks.task import GoalKind
from eai.world.condition import ConditionCompiler
from eai.world.execution import execute_plan
from eai.world.frame import SlotAllocator
from eai.world.state import State


class TaskLookup:
    """Finds features of a benchmark's tasks, and reasons why goals in answers are wrong. Caches results."""

    def __init__(self, benchmark: Benchmark, source: Source) -> None:
        self._benchmark, self._domain = benchmark, benchmark.domain
        self._tasks = benchmark.tasks(source)
        self._words = benchmark.notation.goals.map_spellings_to_predicate_names(benchmark.domain)
        self._spellings = {word for word, _ in self._words}
        self._names = cache(lambda task_id: benchmark.notation.goals.list_object_names(self._tasks[task_id]))
        self._states = cache(self._find_plan_states)
        self.features = cache(self._compute_task_features)
        self.reason = cache(self._find_wrong_goal_reason)

    def _compute_task_features(self, task_id: str) -> Mapping[str, int | str | None]:
        """Return the features of a task by the names of table columns; empty if the task is unknown."""
        if task_id in self._tasks:
            return asdict(compute_features(self._tasks[task_id], self._benchmark))
        return {}

    def _find_wrong_goal_reason(self, task_id: str, stated_goal: AtomOrAction) -> WrongGoalReason | None:
        """Return the likely reason for a wrong goal in an answer; None if the benchmark lacks the task.

        Args:
            task_id: the task. The stated goal is not among its goals.
            stated_goal: the stated goal, with the names that answers use.
        """
        if task_id not in self._tasks:
            return None
        if stated_goal.arguments is None:
            if stated_goal.name not in self._domain.operator_arities:
                return "unknown"
            return "other" if stated_goal.name in self._actions_demanded_by_goals else "procedural"
        if stated_goal.name not in self._spellings:
            return "unknown"
        held = self._test_goal_in_plan_states(task_id, stated_goal)
        if not any(held):
            return "other"
        if held[0]:
            return "initial"
        return "final" if held[-1] else "intermediate"

    @cached_property
    def _actions_demanded_by_goals(self) -> frozenset[str]:
        """Names of the actions that are goals of at least one task of the benchmark."""
        goals = (goal for task in self._tasks.values() for goal in task.get_goals_of_kind(GoalKind.ACTION))
        return frozenset(action for goal in goals for action in list_actions_that_meet_goal(goal))

    def _find_plan_states(self, task_id: str) -> tuple[State, ...]:
        task, arities = self._tasks[task_id], self._domain.operator_arities
        valid_steps = takewhile(lambda step: arities.get(step.operator) == len(step.arguments), task.script)
        return execute_plan(self._domain, task.initial, valid_steps).states

    def _test_goal_in_plan_states(self, task_id: str, goal: AtomOrAction) -> list[bool]:
        """Return for each state of the data set's own plan whether a stated goal holds in it.

        The goal holds if objects with the stated names satisfy it; it never holds if its predicate is
        unknown.
        """
        scene, states, arguments = self._tasks[task_id].scene, self._states(task_id), goal.arguments or ()
        vocabulary = scene.vocabulary
        predicate = self._words.get((goal.name, len(arguments)))
        held = [False] * len(states)
        if predicate is None or vocabulary.find_arity(predicate) != len(arguments):
            return held
        for objects in product(*(self._find_objects_by_name(task_id, name) for name in arguments)):
            frame = SlotAllocator()
            truth = ConditionCompiler(vocabulary, frame).compile_test(
                Atom(predicate, objects), wanted=goal.positive
            )
            binding = frame.bind_arguments(scene, ())
            held = [before or truth(s, binding.copy()) for before, s in zip(held, states, strict=True)]
        return held

    def _find_objects_by_name(self, task_id: str, name: str) -> Iterator[Constant]:
        """Yield the objects of a task with this name, which is their name in answers or in the scene."""
        task, names = self._tasks[task_id], self._names(task_id)
        for index in task.relevant:
            full_name = task.scene.objects[index].name
            if name in (names[index], full_name):
                yield Constant(full_name)
