"""A lookup table as a baseline: the plan of the public task with the most similar goals, objects renamed.

Whoever has seen the public answers can do as much without deciding anything. The task itself is left out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import eai.logic.formula as f
from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import AnswerBook, WrittenAnswer
from eai.benchmarks.source import Source
from eai.errors import InputError
from eai.logic.ltl_printer import print_ltl
from eai.logic.renaming import rename_objects, rename_variables
from eai.logic.traversal import objects
from eai.world.domain import Domain
from eai.world.execution import Action


@dataclass(frozen=True, slots=True)
class _Entry:
    """A task of the table, and its goals with objects by category."""

    task: Task
    goals: Counter[str]


def open_lookup_book(benchmark: Benchmark, ability: Ability, source: Source | None = None) -> AnswerBook:
    """What the lookup table answers.

    Raises:
        InputError: the table has no answers to this ability.
        DataError: the data cannot be had.
    """
    if ability is not Ability.ACTION_SEQUENCING:
        raise InputError(
            f"eai/lookup has no answer to {benchmark.name} {ability.value}: its table is of plans"
        )
    source = source or Source()
    tasks = benchmark.tasks_for(ability, source)
    public = tasks if benchmark.open_public is None else benchmark.open_public(source)
    table = LookupTable(public.values(), benchmark.domain)

    @cache
    def answer(task_id: str) -> WrittenAnswer:
        task = tasks[task_id]
        return WrittenAnswer(benchmark.plans.write(table.plan(task), task.scene), benchmark.plans.join)

    return AnswerBook(tuple(tasks), answer)


class LookupTable:
    """The tasks whose plans are known.

    Args:
        public: the tasks; those without a plan are passed over.
        domain: the declaration.
    """

    def __init__(self, public: Iterable[Task], domain: Domain) -> None:
        self._entries = [_Entry(task, _lifted(task)) for task in public if task.script]
        self._arities = domain.arities

    def plan(self, task: Task) -> tuple[Action, ...]:
        """The plan of the nearest other task, about this one's objects; steps of no operator are left out."""
        nearest = _nearest(task, self._entries)
        plan = () if nearest is None else tuple(_renamed(nearest.task, task))
        return tuple([each for each in plan if self._arities.get(each.operator) == len(each.arguments)])


def _lifted(task: Task) -> Counter[str]:
    """The goals of a task with objects by category."""
    return Counter([text for _, text in _goals(task)])


def _goals(task: Task) -> Iterator[tuple[f.Formula, str]]:
    """The goals of a task, each also as a text in which objects go by their category."""
    category = {thing.name: thing.category for thing in task.scene.objects}
    for goal in task.goals:
        named = {name: category[name] for name in objects(goal.formula)}
        yield goal.formula, print_ltl(rename_variables(rename_objects(goal.formula, named)))


def _nearest(task: Task, table: Sequence[_Entry]) -> _Entry | None:
    """The entry of another task that shares most goals, of those of either; the first of several."""
    goals = _lifted(task)
    others = [entry for entry in table if entry.task.id != task.id]
    return max(others, key=lambda entry: _similarity(goals, entry.goals), default=None)


def _similarity(goals: Counter[str], others: Counter[str]) -> int:
    """How near goals are to each other: the share of common ones among all, in millionths."""
    return 1_000_000 * (goals & others).total() // max(1, (goals | others).total())


def _renamed(known: Task, asked: Task) -> Iterator[Action]:
    """The plan of a known task about the objects of another, without steps about what the other lacks."""
    meant = _correspondence(known, asked)
    for action in known.script:
        arguments = [meant.get(index) for index in action.arguments]
        found = tuple([index for index in arguments if index is not None])
        if len(found) == len(arguments):
            yield Action(action.operator, found)


def _correspondence(known: Task, asked: Task) -> Mapping[int, int]:
    """For each object of a known task's plan one of another task: of the same goal, or category and name."""
    meant: dict[int, int] = {}
    goals = list(_goals(asked))
    for formula, text in _goals(known):
        same = next((i for i, (_, other) in enumerate(goals) if other == text), None)
        if same is not None:
            there = objects(goals.pop(same)[0])
            pairs = zip(objects(formula), there, strict=False)
            meant |= {known.scene.index[a]: asked.scene.index[b] for a, b in pairs}
    relevant = dict.fromkeys((*asked.relevant, *range(len(asked.scene.objects))))
    for index in dict.fromkeys(i for action in known.script for i in action.arguments):
        thing = known.scene.objects[index]
        if index not in meant:
            alike = [i for i in relevant if asked.scene.objects[i].category == thing.category]
            free = [i for i in alike if i not in meant.values()] or alike
            same_name = [i for i in free if asked.scene.objects[i].name == thing.name]
            if free:
                meant[index] = (same_name or free)[0]
    return meant
