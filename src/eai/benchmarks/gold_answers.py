"""Answers of the built-in models: gold answers, planned answers, and randomly corrupted gold answers.

The model `eai/noisy` gives corrupted answers. If feedback names an error, the model repairs it.
"""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.abilities.declaration import get_declaration
from eai.abilities.declining import write_expected_declining_answer
from eai.abilities.feedback import REASONS_PREFIX
from eai.abilities.notation.goal_lexicon import read_stated_goals, write_goals
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.goal_test import find_remaining_goals
from eai.tasks.planning import FindPlan, explain_missing_plan, find_plan
from eai.tasks.source import USUAL_SOURCE, Source, TaskSet
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.execution import execute_plan

if TYPE_CHECKING:
    from eai.tasks.operator_task import TransitionTask

_GoldAndCorruptedParts: TypeAlias = tuple[tuple[str, ...], tuple[str, ...]]
"""A pair: consecutive parts of a gold answer, and the parts that replace them in the corrupted answer."""


def make_noisy_answer(answers: AnswersByTask, task_id: str, rate: float, seed: str) -> AnswerInParts:
    """Return a gold answer with randomly corrupted parts. Equal arguments give equal answers.

    Parts are steps, goals, subgoals or operators. Corruption deletes or repeats a part, swaps it with the
    next part, or replaces it by a part of another task's answer. Parts are corrupted independently.

    Args:
        answers: the gold answers.
        task_id: the id of the task.
        rate: probability that a part is corrupted.
        seed: seed of all random choices.
    """
    return next(yield_corrupted_answer_and_repaired_versions(answers, task_id, rate, seed))


def make_noisy_answer_heeding_feedback(
    answers: AnswersByTask,
    task_id: str,
    question: str,
    attempt: int,
    *,
    error_rate: float,
    seed: str,
    repair_probability: float,
) -> AnswerInParts:
    """Return the answer of a built-in model that makes random errors, and repairs an error that is named.

    The question may contain the model's last answer and the reason for its failure. The model then repairs
    the first wrong part (such as a step) of that answer with probability ``repair_probability``.
    Otherwise the model repeats its answer.
    """
    versions = list(yield_corrupted_answer_and_repaired_versions(answers, task_id, error_rate, seed))
    # Every text contains an empty answer. It counts as the last answer only if no other answer is found.
    position, last = max(
        (question.rfind(version.text) if version.text else 0, number)
        for number, version in enumerate(versions)
    )
    if attempt == 1 or position < 0:
        return versions[0]
    has_reason = REASONS_PREFIX in question[position + len(versions[last].text) :]
    heeds = has_reason and make_random_generator(f"{seed} {attempt}", task_id).random() < repair_probability
    return versions[min(last + heeds, len(versions) - 1)]


def yield_corrupted_answer_and_repaired_versions(
    answers: AnswersByTask, task_id: str, error_rate: float, seed: str
) -> Iterator[AnswerInParts]:
    """Yield a corrupted answer, then versions of this answer with 1, 2, ... repaired parts, such as steps.

    The last version is the gold answer.
    """
    answer = answers[task_id]
    segments = list(
        _corrupt_answer_parts(answers, answer.parts, error_rate, make_random_generator(seed, task_id))
    )
    yield _make_answer_from_corrupted_parts(segments, answer)
    for number, (gold, corrupted) in enumerate(segments):
        if gold != corrupted:
            segments[number] = gold, gold
            yield _make_answer_from_corrupted_parts(segments, answer)


def _make_answer_from_corrupted_parts(
    segments: Iterable[_GoldAndCorruptedParts], answer: AnswerInParts
) -> AnswerInParts:
    return replace(answer, parts=tuple([part for _, parts in segments for part in parts]))


def _corrupt_answer_parts(
    answers: AnswersByTask, parts: Iterable[str], rate: float, rng: random.Random
) -> Iterator[_GoldAndCorruptedParts]:
    pending = list(parts)
    while pending:
        gold_part = pending.pop(0)
        if rng.random() >= rate:
            yield (gold_part,), (gold_part,)
            continue
        match rng.choice(("drop", "repeat", "swap", "replace")):
            case "repeat":
                yield (gold_part,), (gold_part, gold_part)
            case "swap" if pending:
                other = pending.pop(0)
                yield (gold_part, other), (other, gold_part)
            case "swap" | "replace":
                foreign = answers[rng.choice(tuple(answers))].parts
                yield (gold_part,), (rng.choice(foreign) if foreign else gold_part,)
            case _:
                yield (gold_part,), ()


def make_random_generator(seed: str, task_id: str) -> random.Random:
    """Return the random generator for the answer to a task, given the seed of all answers."""
    digest = hashlib.sha256(f"{seed} {task_id}".encode()).digest()
    return random.Random(digest)  # noqa: S311 - chance, not secrets


@dataclass(frozen=True, slots=True)
class AnswerInParts:
    """An answer: its parts (steps, goals, subgoals or operators) and the function that joins them.

    Attributes:
        parts: the parts of the answer.
        join: joins the parts to a text.
        why_none: reason why the task has no answer; empty if it has an answer.
    """

    parts: tuple[str, ...]
    join: Callable[[Iterable[str]], str]
    why_none: str = ""

    @property
    def text(self) -> str:
        """Text of the whole answer; empty if the task has no answer."""
        return "" if self.why_none else self.join(self.parts)


AnswersByTask: TypeAlias = Mapping[str, AnswerInParts]
"""Mapping from task id to answer, in the order of the benchmark's tasks. Each answer is made on first use."""


def make_answers_by_task(
    benchmark: Benchmark,
    ability: Ability,
    source: Source,
    make_answer_parts_of_task: Callable[[Any], Iterable[str]],
) -> AnswersByTask:
    """Return a mapping from task id to answer.

    The function `make_answer_parts_of_task` makes the parts of an answer, such as steps, which are joined as
    the ability requires.
    """
    tasks = benchmark.tasks_for(ability, source)
    join = get_function_that_joins_answer_parts(benchmark, ability)
    return TaskSet(
        tasks,
        lambda task_id: AnswerInParts(tuple(make_answer_parts_of_task(tasks[task_id])), join),
        tasks.sha256,
        source.kept,
    )


def get_function_that_joins_answer_parts(
    benchmark: Benchmark, ability: Ability
) -> Callable[[Iterable[str]], str]:
    """Return the function that joins the parts of an answer (goals, subgoals, steps or operators) to a text.

    Answers to other abilities have only one part.
    """
    match ability:
        case Ability.GOAL_INTERPRETATION:
            return benchmark.notation.goals.join
        case Ability.SUBGOAL_DECOMPOSITION:
            return benchmark.subgoal_notation().join
        case Ability.ACTION_SEQUENCING:
            return benchmark.notation.plans.join
        case Ability.TRANSITION_MODELING:
            return join_operators_as_answer
        case _:
            return "".join


def open_gold_answers(benchmark: Benchmark, ability: Ability, source: Source = USUAL_SOURCE) -> AnswersByTask:
    """Return the gold answers of a benchmark. For tasks without a plan, the built-in search finds one.

    Raises:
        DataError: the data cannot be obtained.
    """

    def write_gold_goals(task: Task) -> Iterable[str]:
        return write_goals(task, benchmark.domain, benchmark.notation.goals)

    def write_gold_operators(task: TransitionTask) -> Iterable[str]:
        return [task.domain.operators[name].write_pddl for name in task.operators]

    match ability:
        case Ability.GOAL_INTERPRETATION:
            return make_answers_by_task(benchmark, ability, source, write_gold_goals)
        case Ability.TRANSITION_MODELING:
            return make_answers_by_task(benchmark, ability, source, write_gold_operators)
        case Ability.ACTION_SEQUENCING | Ability.SUBGOAL_DECOMPOSITION:
            return _make_correct_answers_from_plans(benchmark, ability, source, prefers_annotated_plans=True)
    pose = get_declaration(ability).interaction.make_question
    world = benchmark.collect_domain_and_notation(source)
    if pose is None:
        raise InputError(
            f"{benchmark.name} {ability.value}: gold answers are unknown; choose another ability"
        )
    return make_answers_by_task(benchmark, ability, source, lambda task: pose(world, task)[1:])


def open_answers_of_planner(
    benchmark: Benchmark,
    ability: Ability,
    source: Source = USUAL_SOURCE,
    limits: Limits | None = None,
    find: FindPlan = find_plan,
) -> AnswersByTask:
    """Return answers made from plans of the built-in search, never from plans of the data set.

    The search uses the declared domain of the benchmark.
    If the search finds no plan, the answer is empty, and `AnswerInParts.why_none` states the reason.

    Args:
        benchmark: the benchmark.
        ability: the ability.
        source: the source of the data.
        limits: limits of the search, for action sequencing.
        find: the search for plans, for action sequencing.

    Raises:
        InputError: answers to this ability are not made from plans.
        DataError: the data cannot be obtained.
    """
    match ability:
        case Ability.ACTION_SEQUENCING:
            return _make_correct_answers_from_plans(
                benchmark, ability, source, limits=limits, search_plan=find
            )
        case Ability.SUBGOAL_DECOMPOSITION:
            return _make_correct_answers_from_plans(benchmark, ability, source)
        case _:
            raise make_no_answer_error(model="planner", benchmark=benchmark, ability=ability)


def make_no_answer_error(model: str, benchmark: Benchmark, ability: Ability) -> InputError:
    """Return the error to raise if a built-in model has no answers to a benchmark's tasks for an ability."""
    return InputError(f"eai/{model} has no answer to {benchmark.name} {ability.value}")


def replace_goals_by_answers(benchmark: Benchmark, answers: Mapping[str, str]) -> Benchmark:
    """Return a benchmark whose tasks have the goals that answers state.

    `answers` maps task ids to answers. Goals with unknown names are left out. Tasks without an answer keep
    their goals.
    """

    def replace_goals_by_goals_stated_in_answer(task: Task) -> Task:
        answer = answers.get(task.id)
        if answer is None:
            return task
        goals = read_stated_goals(answer, task, benchmark.domain, benchmark.notation.goals)
        return task.replace_goals(goals.meaningful)

    return benchmark.with_changed_tasks(replace_goals_by_goals_stated_in_answer)


def make_benchmark_starting_after_actions(
    benchmark: Benchmark, task_id: str, done: Sequence[Action]
) -> Benchmark:
    """Return a copy of the benchmark in which one task starts in the state after some actions."""

    def start_chosen_task_after_actions(task: Task) -> Task:
        if task.id != task_id:
            return task
        return replace(task, initial=execute_plan(benchmark.domain, task.initial, done).final_state)

    return benchmark.with_changed_tasks(start_chosen_task_after_actions)


def make_benchmark_without_reached_goals(
    benchmark: Benchmark, task_id: str, executed_actions: Sequence[Action]
) -> Benchmark:
    """Return a copy of the benchmark in which one task has only its remaining goals.

    Goals for actions that the executed actions have reached are left out.
    """
    names = [action.operator for action in executed_actions]

    def drop_goals(task: Task) -> Task:
        return task if task.id != task_id else replace(task, goals=find_remaining_goals(task, names))

    return benchmark.with_changed_tasks(drop_goals)


def _make_correct_answers_from_plans(
    benchmark: Benchmark,
    ability: Ability,
    source: Source,
    *,
    prefers_annotated_plans: bool = False,
    limits: Limits | None = None,
    search_plan: FindPlan = find_plan,
) -> AnswersByTask:
    """Return right answers made from plans: plans for action sequencing, or subgoals of plans.

    If ``prefers_annotated_plans`` is true, the data set's own plans are used.
    For tasks without such a plan, a plan is searched.
    """
    planner, join = Planner(benchmark.domain), get_function_that_joins_answer_parts(benchmark, ability)
    tasks, plans = benchmark.tasks_for(ability, source), benchmark.notation.plans

    def write_steps_or_subgoals_of_plan(task: Task, plan: Sequence[Action]) -> Sequence[str]:
        if ability is Ability.SUBGOAL_DECOMPOSITION:
            return tuple(benchmark.subgoal_notation().write(task, plan))
        return plans.write(plan, task.scene)

    def make_answer(task_id: str) -> AnswerInParts:
        task = tasks[task_id]
        may_decline = prefers_annotated_plans and ability is Ability.ACTION_SEQUENCING
        if may_decline and (declining := write_expected_declining_answer(task, plans)) is not None:
            return AnswerInParts((declining,), "".join)
        if prefers_annotated_plans and (task.script or task.unsolvable is not None):
            return AnswerInParts(tuple(write_steps_or_subgoals_of_plan(task, task.script)), join)
        search = search_plan(task, planner, limits)
        return AnswerInParts(
            tuple(write_steps_or_subgoals_of_plan(task, search.plan)), join, explain_missing_plan(search.end)
        )

    return TaskSet(tasks, make_answer, tasks.sha256)


def join_operators_as_answer(operators: Iterable[str]) -> str:
    """Return one answer that contains these operators."""
    return json.dumps({"output": "\n".join(operators)})
