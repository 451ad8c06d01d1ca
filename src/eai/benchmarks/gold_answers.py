"""What the built-in models answer: gold answers, and gold answers spoilt at random."""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import TypeAlias

from eai.abilities.action_sequencing.notation import JsonPlans, PlanNotation
from eai.abilities.goal_interpretation.gold import write_goals
from eai.abilities.planning import find_plan
from eai.abilities.protocol import Ability
from eai.abilities.subgoal_decomposition.notation import SubgoalNotation
from eai.abilities.task import Task
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior import tasks as behavior_tasks
from eai.benchmarks.behavior.goal_notation import BehaviorGoals
from eai.benchmarks.behavior.subgoal_notation import BehaviorSubgoals
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_operators import TransitionTasks, open_behavior, open_virtualhome
from eai.benchmarks.source import Source
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome import tasks as virtualhome_tasks
from eai.benchmarks.virtualhome.goal_notation import VirtualHomeGoals
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlans
from eai.benchmarks.virtualhome.subgoal_notation import VirtualHomeSubgoals
from eai.data.store import Store
from eai.errors import InputError
from eai.planning.planner import Planner


@dataclass(frozen=True, slots=True)
class WrittenAnswer:
    """An answer as its parts (steps, goals, subgoals, operators) and the function that joins them."""

    parts: tuple[str, ...]
    join: Callable[[Iterable[str]], str]

    @property
    def text(self) -> str:
        """The whole answer."""
        return self.join(self.parts)


@dataclass(frozen=True, slots=True)
class AnswerBook:
    """The gold answers of a suite: the ids of its tasks in order, and the answer to each."""

    task_ids: tuple[str, ...]
    gold: Callable[[str], WrittenAnswer]


def open_answer_book(benchmark: Benchmark, ability: Ability, source: Source | None = None) -> AnswerBook:
    """The gold answers of a benchmark to an ability.

    Raises:
        InputError: there are none.
        DataError: the data cannot be had.
    """
    opener = _BOOKS.get((benchmark.name, ability))
    if opener is None:
        raise InputError(f"{benchmark.name} has no {ability.value} yet")
    return opener((source or Source()).store)


def open_planned_book(benchmark: Benchmark, ability: Ability, source: Source | None = None) -> AnswerBook:
    """Answers made of plans that the built-in search finds on the declared domain, instead of gold ones.

    An answer is empty where the search finds no plan.

    Raises:
        InputError: a plan is no answer to this ability, or the domain has no writer for it.
        DataError: the data cannot be had.
    """
    opener = _PLANNED_BOOKS.get((benchmark.name, ability))
    if opener is None:
        raise InputError(f"eai/planner has no answer to {benchmark.name} {ability.value}")
    return opener((source or Source()).store)


def noisy_answer(book: AnswerBook, task_id: str, *, rate: float, seed: str) -> WrittenAnswer:
    """A gold answer in which each part is spoilt with probability ``rate``: a pure function of the arguments.

    A spoilt part is dropped, repeated, swapped with the next, or replaced by a part of another task's answer.
    """
    answer = book.gold(task_id)
    rng = random.Random(hashlib.sha256(f"{seed} {task_id}".encode()).digest())  # noqa: S311 - noise, not secrets
    parts: list[str] = []
    pending = list(answer.parts)
    while pending:
        part = pending.pop(0)
        if rng.random() >= rate:
            parts.append(part)
            continue
        match rng.choice(("drop", "repeat", "swap", "replace")):
            case "repeat":
                parts += [part, part]
            case "swap" if pending:
                parts += [pending.pop(0), part]
            case "swap" | "replace":
                foreign = book.gold(rng.choice(book.task_ids)).parts
                parts.append(rng.choice(foreign) if foreign else part)
            case _:
                pass
    return replace(answer, parts=tuple(parts))


def _virtualhome_plans(store: Store | None) -> AnswerBook:
    return _scripts(virtualhome_tasks.open_tasks(store), VirtualHomePlans())


def _behavior_plans(store: Store | None) -> AnswerBook:
    return _scripts(behavior_tasks.open_tasks(store), JsonPlans())


def _scripts(tasks: Mapping[str, Task], notation: PlanNotation) -> AnswerBook:
    """The data set's own plans."""

    def gold(task_id: str) -> WrittenAnswer:
        task = tasks[task_id]
        return WrittenAnswer(notation.write(task.script, task.scene), notation.join)

    return AnswerBook(tuple(tasks), gold)


def _virtualhome_goals(store: Store | None) -> AnswerBook:
    tasks = virtualhome_tasks.open_tasks(store)
    domain, notation = virtualhome.as_meant(), VirtualHomeGoals()
    return AnswerBook(
        tuple(tasks),
        lambda task_id: WrittenAnswer(write_goals(tasks[task_id], domain, notation), notation.join),
    )


def _virtualhome_subgoals(store: Store | None) -> AnswerBook:
    """The data set has no subgoals of its own: those of a plan that the built-in search finds, if it does."""
    tasks = virtualhome_tasks.open_tasks(store)
    words = VirtualHomeSubgoals()
    return _planned_subgoals({i: t for i, t in tasks.items() if t.temporal_goal is not None}, words)


def _planned_subgoals(tasks: Mapping[str, Task], notation: SubgoalNotation) -> AnswerBook:
    """The subgoals of plans that the built-in search finds."""
    planner = notation.planner()

    @cache
    def planned(task_id: str) -> WrittenAnswer:
        task = tasks[task_id]
        return WrittenAnswer(notation.planned(task, planner), notation.join)

    return AnswerBook(tuple(tasks), planned)


def _behavior_goals(store: Store | None) -> AnswerBook:
    tasks = behavior_tasks.open_tasks(store)
    domain, notation = behavior.as_meant(), BehaviorGoals()
    return AnswerBook(
        tuple(tasks),
        lambda task_id: WrittenAnswer(write_goals(tasks[task_id], domain, notation), notation.join),
    )


def _behavior_subgoals(store: Store | None) -> AnswerBook:
    """The data set has no subgoals of its own: what its plans bring about."""
    tasks = behavior_tasks.open_tasks(store)
    words = BehaviorSubgoals()

    def gold(task_id: str) -> WrittenAnswer:
        task = tasks[task_id]
        return WrittenAnswer(words.write(task, task.script), words.join)

    return AnswerBook(tuple(tasks), gold)


def _operators(open_transition_tasks: Callable[[Store | None], TransitionTasks]) -> Opener:
    def open_book(store: Store | None) -> AnswerBook:
        tasks = open_transition_tasks(store)

        def gold(task_id: str) -> WrittenAnswer:
            task = tasks[task_id]
            parts = tuple(task.domain.operators[name].pddl for name in task.operators)
            return WrittenAnswer(parts, lambda operators: json.dumps({"output": "\n".join(operators)}))

        return AnswerBook(tuple(tasks), gold)

    return open_book


def _planned_virtualhome_plans(store: Store | None) -> AnswerBook:
    return _plans(virtualhome_tasks.open_tasks(store), Planner(virtualhome.as_meant()), VirtualHomePlans())


def _planned_behavior_plans(store: Store | None) -> AnswerBook:
    return _plans(behavior_tasks.open_tasks(store), Planner(behavior.as_meant()), JsonPlans())


def _plans(tasks: Mapping[str, Task], planner: Planner, notation: PlanNotation) -> AnswerBook:
    """Plans that are searched for."""

    def planned(task_id: str) -> WrittenAnswer:
        task = tasks[task_id]
        return WrittenAnswer(notation.write(find_plan(task, planner).plan, task.scene), notation.join)

    return AnswerBook(tuple(tasks), planned)


def _planned_behavior_subgoals(store: Store | None) -> AnswerBook:
    return _planned_subgoals(behavior_tasks.open_tasks(store), BehaviorSubgoals())


Opener: TypeAlias = Callable[[Store | None], AnswerBook]

_BOOKS: Mapping[tuple[str, Ability], Opener] = {
    ("virtualhome", Ability.GOAL_INTERPRETATION): _virtualhome_goals,
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION): _virtualhome_subgoals,
    ("virtualhome", Ability.ACTION_SEQUENCING): _virtualhome_plans,
    ("virtualhome", Ability.TRANSITION_MODELING): _operators(open_virtualhome),
    ("behavior", Ability.GOAL_INTERPRETATION): _behavior_goals,
    ("behavior", Ability.SUBGOAL_DECOMPOSITION): _behavior_subgoals,
    ("behavior", Ability.ACTION_SEQUENCING): _behavior_plans,
    ("behavior", Ability.TRANSITION_MODELING): _operators(open_behavior),
}

_PLANNED_BOOKS: Mapping[tuple[str, Ability], Opener] = {
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION): _virtualhome_subgoals,
    ("virtualhome", Ability.ACTION_SEQUENCING): _planned_virtualhome_plans,
    ("behavior", Ability.SUBGOAL_DECOMPOSITION): _planned_behavior_subgoals,
    ("behavior", Ability.ACTION_SEQUENCING): _planned_behavior_plans,
}
