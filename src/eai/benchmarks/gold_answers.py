"""Answers of the built-in models: gold answers, plans found by search, and gold answers corrupted at random.

The last are those of `eai/noisy`, which mends them where feedback says what is wrong.
"""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.abilities.declaration import declaration_of
from eai.abilities.feedback import REASONS
from eai.abilities.notation.goal_lexicon import read_stated_goals, write_goals
from eai.abilities.notation.plans import QUESTION, refusal
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.goal_test import remaining_goals
from eai.tasks.planning import FindPlan, find_plan, why_no_plan
from eai.tasks.source import USUAL, Source, TaskSet
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.execution import execute

if TYPE_CHECKING:
    from eai.tasks.operator_task import TransitionTask

_Segment: TypeAlias = tuple[tuple[str, ...], tuple[str, ...]]
"""Parts of a gold answer that belong together, and those that stand in their place."""


def noisy_answer(book: AnswerBook, task_id: str, rate: float, seed: str) -> WrittenAnswer:
    """A gold answer in which parts are corrupted, each by itself: a pure function of the arguments.

    A part is dropped, repeated, swapped with the next, or replaced by a part of another task's answer.

    Args:
        book: the gold answers.
        task_id: the id of the task.
        rate: how often a part is corrupted.
        seed: of all that is random.
    """
    return next(corrupted_versions(book, task_id, rate, seed))


def heeding_answer(
    book: AnswerBook, task_id: str, question: str, attempt: int, *, rate: float, seed: str, heed: float
) -> WrittenAnswer:
    """The answer of a noisy model that mends only mistakes that the question names.

    If the question contains its last answer and a reason after it, it mends the first corrupted part of that
    answer with probability ``heed``; otherwise it says the same again.
    """
    versions = list(corrupted_versions(book, task_id, rate, seed))
    place, last = max((question.rfind(version.text), number) for number, version in enumerate(versions))
    if attempt == 1 or place < 0:
        return versions[0]
    has_reason = REASONS in question[place + len(versions[last].text) :]
    heeds = has_reason and chance(f"{seed} {attempt}", task_id).random() < heed
    return versions[min(last + heeds, len(versions) - 1)]


def corrupted_versions(book: AnswerBook, task_id: str, rate: float, seed: str) -> Iterator[WrittenAnswer]:
    """The corrupted answer, then with one more corrupted part mended each time, up to the gold answer."""
    answer = book[task_id]
    segments = list(_segments(book, answer.parts, rate, chance(seed, task_id)))
    yield _written(segments, answer)
    for number, (gold, corrupted) in enumerate(segments):
        if gold != corrupted:
            segments[number] = gold, gold
            yield _written(segments, answer)


def _written(segments: Iterable[_Segment], answer: WrittenAnswer) -> WrittenAnswer:
    return WrittenAnswer(tuple([part for _, parts in segments for part in parts]), answer.join)


def _segments(book: AnswerBook, parts: Iterable[str], rate: float, rng: random.Random) -> Iterator[_Segment]:
    """The parts of a gold answer, some of them corrupted."""
    pending = list(parts)
    while pending:
        part = pending.pop(0)
        if rng.random() >= rate:
            yield (part,), (part,)
            continue
        match rng.choice(("drop", "repeat", "swap", "replace")):
            case "repeat":
                yield (part,), (part, part)
            case "swap" if pending:
                other = pending.pop(0)
                yield (part, other), (other, part)
            case "swap" | "replace":
                foreign = book[rng.choice(tuple(book))].parts
                yield (part,), (rng.choice(foreign) if foreign else part,)
            case _:
                yield (part,), ()


def chance(seed: str, task_id: str) -> random.Random:
    """The source of all that is random in the answer to a task."""
    digest = hashlib.sha256(f"{seed} {task_id}".encode()).digest()
    return random.Random(digest)  # noqa: S311 - chance, not secrets


@dataclass(frozen=True, slots=True)
class WrittenAnswer:
    """An answer as its parts (steps, goals, subgoals, operators) and the function that joins them.

    Attributes:
        parts: the parts.
        join: joins them.
        why_none: why there is no answer; empty if there is one.
    """

    parts: tuple[str, ...]
    join: Callable[[Iterable[str]], str]
    why_none: str = ""

    @property
    def text(self) -> str:
        """Return the text of all parts, or an empty text if the task has no answer."""
        return "" if self.why_none else self.join(self.parts)


AnswerBook: TypeAlias = Mapping[str, WrittenAnswer]
"""The answers to the tasks of a suite by their ids, in the order of these; each is made on first use."""


def book_of(
    benchmark: Benchmark, ability: Ability, source: Source, parts: Callable[[Any], Iterable[str]]
) -> AnswerBook:
    """The answers to an ability whose parts are made of its tasks, joined as answers to it are written."""
    tasks, join = benchmark.tasks_for(ability, source), join_of(benchmark, ability)
    return TaskSet(tasks, lambda task_id: WrittenAnswer(tuple(parts(tasks[task_id])), join), tasks.sha256)


def join_of(benchmark: Benchmark, ability: Ability) -> Callable[[Iterable[str]], str]:
    """How the parts of an answer are joined: as its notation says; an answer of another form is one part."""
    match ability:
        case Ability.GOAL_INTERPRETATION:
            return benchmark.notation.goals.join
        case Ability.SUBGOAL_DECOMPOSITION:
            return benchmark.subgoals().join
        case Ability.ACTION_SEQUENCING:
            return benchmark.notation.plans.join
        case Ability.TRANSITION_MODELING:
            return join_operators
        case _:
            return "".join


def open_answer_book(benchmark: Benchmark, ability: Ability, source: Source = USUAL) -> AnswerBook:
    """The gold answers of a benchmark: those of its data set, or else what the built-in search finds.

    Raises:
        DataError: the data cannot be had.
    """

    def goals(task: Task) -> Iterable[str]:
        return write_goals(task, benchmark.domain, benchmark.notation.goals)

    def operators(task: TransitionTask) -> Iterable[str]:
        return [task.domain.operators[name].pddl for name in task.operators]

    match ability:
        case Ability.GOAL_INTERPRETATION:
            return book_of(benchmark, ability, source, goals)
        case Ability.TRANSITION_MODELING:
            return book_of(benchmark, ability, source, operators)
        case Ability.ACTION_SEQUENCING | Ability.SUBGOAL_DECOMPOSITION:
            return _of_plans(benchmark, ability, source, scripts=True)
    pose, world = declaration_of(ability).interaction.make_question, benchmark.world(source)
    if pose is None:
        raise InputError(f"no right answers are known to {benchmark.name} {ability.value}")
    return book_of(benchmark, ability, source, lambda task: pose(world, task)[1:])


def open_planned_book(
    benchmark: Benchmark,
    ability: Ability,
    source: Source = USUAL,
    limits: Limits | None = None,
    find: FindPlan = find_plan,
) -> AnswerBook:
    """Answers made of plans that the built-in search finds on the declared domain, instead of gold ones.

    If the search finds no plan, there is no answer (`WrittenAnswer.why_none`).

    Args:
        benchmark: the benchmark.
        ability: the ability.
        source: where its data comes from.
        limits: how much the search for a plan of action sequencing may do.
        find: how that is looked for.

    Raises:
        InputError: a plan is no answer to this ability.
        DataError: the data cannot be had.
    """
    match ability:
        case Ability.ACTION_SEQUENCING:
            return _of_plans(benchmark, ability, source, limits=limits, find=find)
        case Ability.SUBGOAL_DECOMPOSITION:
            return _of_plans(benchmark, ability, source)
        case _:
            raise no_answer("planner", benchmark, ability)


def no_answer(model: str, benchmark: Benchmark, ability: Ability) -> InputError:
    """The error that a built-in model answers nothing in a suite."""
    return InputError(f"eai/{model} has no answer to {benchmark.name} {ability.value}")


def believing(benchmark: Benchmark, stated: Mapping[str, str]) -> Benchmark:
    """The benchmark whose tasks have the goals that answers state, by id, as far as they mean something."""

    def believed(task: Task) -> Task:
        answer = stated.get(task.id)
        if answer is None:
            return task
        goals = read_stated_goals(answer, task, benchmark.domain, benchmark.notation.goals)
        return replace(task, goals=goals.meaningful)

    return benchmark.with_changed(believed)


def continuing(benchmark: Benchmark, task_id: str, done: Sequence[Action]) -> Benchmark:
    """Return the benchmark in which some actions have been executed in the world of a task."""

    def now(task: Task) -> Task:
        if task.id != task_id:
            return task
        return replace(task, initial=execute(benchmark.domain, task.initial, done).final)

    return benchmark.with_changed(now)


def lacking(benchmark: Benchmark, task_id: str, done: Sequence[Action]) -> Benchmark:
    """Return the benchmark in which a task has no more action goals that some actions have met."""
    names = [action.operator for action in done]

    def left(task: Task) -> Task:
        return task if task.id != task_id else replace(task, goals=remaining_goals(task, names))

    return benchmark.with_changed(left)


def _of_plans(
    benchmark: Benchmark,
    ability: Ability,
    source: Source,
    *,
    scripts: bool = False,
    limits: Limits | None = None,
    find: FindPlan = find_plan,
) -> AnswerBook:
    """Plans, or subgoals that stand for them: the data set's own, where it has them and they are asked for.

    Else they are what the search finds.
    """
    planner, join = Planner(benchmark.domain), join_of(benchmark, ability)
    tasks, plans = benchmark.tasks_for(ability, source), benchmark.notation.plans

    def write(task: Task, plan: Sequence[Action]) -> Sequence[str]:
        if ability is Ability.SUBGOAL_DECOMPOSITION:
            return tuple(benchmark.subgoals().write(task, plan))
        return plans.write(plan, task.scene)

    def answer(task_id: str) -> WrittenAnswer:
        task = tasks[task_id]
        if scripts and ability is Ability.ACTION_SEQUENCING and task.missing:
            return WrittenAnswer((refusal(plans.encode_names(", ".join(task.missing))),), "".join)
        if scripts and ability is Ability.ACTION_SEQUENCING and task.is_ambiguous:
            return WrittenAnswer((refusal(f"{' or '.join(task.fits or ())}?", QUESTION),), "".join)
        if scripts and (task.script or task.unsolvable is not None):
            return WrittenAnswer(tuple(write(task, task.script)), join)
        found = find(task, planner, limits)
        return WrittenAnswer(tuple(write(task, found.plan)), join, why_no_plan(found.end))

    return TaskSet(tasks, answer, tasks.sha256)


def join_operators(operators: Iterable[str]) -> str:
    """Operators as one answer."""
    return json.dumps({"output": "\n".join(operators)})
