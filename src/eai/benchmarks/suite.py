"""Suites: all tasks of a benchmark and an ability, ready to score answers under a protocol."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple, TypeAlias

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import Verdict
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark, registered
from eai.benchmarks.source import Source
from eai.data.progress import silent
from eai.errors import InputError

DEFAULT_PROTOCOL = Protocol.STRICT
"""The rules for scoring where nothing else is asked for."""

Form: TypeAlias = bool | None
"""How all answers that are scored together are written, where that decides how each is read; else None."""

FormOf: TypeAlias = Callable[[Sequence[str]], Form]


def _no_form(answers: Sequence[str]) -> Form:
    return None


@dataclass(frozen=True)
class Suite:
    """The tasks of a benchmark and an ability under one protocol.

    Attributes:
        task_ids: the ids of all tasks, in the order of the data set.
        data_sha256: digest of the data behind them.
        reopen: opens the same suite once more, say in another process; None if it was not opened by
            `open_suite`.
    """

    benchmark: Benchmark
    ability: Ability
    protocol: Protocol
    task_ids: tuple[str, ...]
    data_sha256: str
    _make: Callable[[str], Scorer]
    _form_of: FormOf = _no_form
    _made: dict[str, Scorer] = field(default_factory=dict, repr=False)
    reopen: Callable[..., Suite] | None = field(default=None, repr=False)

    @property
    def domain(self) -> str:
        """The name of the benchmark, as records have it."""
        return self.benchmark.name

    def over(self, answers: Sequence[str]) -> Suite:
        """The suite as it scores these answers together: the form of all may decide how each is read."""
        form = self._form_of(answers) if answers else None
        return self if form is None or self.reopen is None else self.reopen(form=form)

    def scorer(self, task_id: str) -> Scorer:
        """The scorer of a task; it is made once.

        Raises:
            InputError: there is no such task.
        """
        scorer = self._made.get(task_id)
        if scorer is None:
            if task_id not in self.task_ids:
                raise InputError(f"{self.domain} {self.ability.value} has no task {task_id!r}")
            scorer = self._made[task_id] = self._make(task_id)
        return scorer

    def score(self, task_id: str, text: str) -> Verdict:
        """The verdict on an answer to a task."""
        return self.scorer(task_id).score(text)


class Opened(NamedTuple):
    """What is particular to a suite: its tasks in order, the digest of its data, and its scorers."""

    task_ids: tuple[str, ...]
    data_sha256: str
    make: Callable[[str], Scorer]
    form_of: FormOf = _no_form


Opener: TypeAlias = Callable[[Benchmark, Protocol, Form, Source], Opened]


def open_suite(
    benchmark: Benchmark | str,
    ability: Ability,
    protocol: Protocol = DEFAULT_PROTOCOL,
    *,
    source: Source | None = None,
    form: Form = None,
) -> Suite:
    """Open a suite; the data set is fetched first if it is not there.

    Args:
        benchmark: the benchmark, or what `find_benchmark` finds it by.
        ability: the ability.
        protocol: the rules for scoring.
        source: where the data comes from; the user's default store if None.
        form: how all answers are written, as `Suite.over` finds out.

    Raises:
        DataError: the data cannot be had.
        InputError: there is no such suite.
    """
    found = find_benchmark(benchmark) if isinstance(benchmark, str) else benchmark
    opener = _OPENERS.get((found.name, ability))
    if opener is None:
        raise InputError(f"{found.name} has no {ability.value} yet")
    source = source or Source()
    opened = opener(found, protocol, form, source)
    again = partial(
        open_suite,
        found.reference or found,
        ability,
        protocol,
        source=replace(source, report=silent),
        form=form,
    )
    return Suite(found, ability, protocol, *opened, reopen=again)


def available_suites() -> tuple[tuple[str, Ability], ...]:
    """Every registered benchmark with each ability."""
    return tuple((name, ability) for name in registered() for ability in Ability)


def _virtualhome_action_sequencing(
    benchmark: Benchmark, protocol: Protocol, form: Form, source: Source
) -> Opened:
    from eai.abilities.action_sequencing.scorer import ActionSequencing
    from eai.benchmarks.reference.virtualhome_plans import VirtualHomeActionSequencing, written_with_ids
    from eai.benchmarks.virtualhome.benchmark import open_tasks as virtualhome_tasks
    from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlans

    tasks = virtualhome_tasks(source)
    if protocol is Protocol.EAI_1_0_5:
        return Opened(
            tuple(tasks),
            tasks.sha256,
            lambda task_id: VirtualHomeActionSequencing(tasks[task_id], with_ids=form),
            written_with_ids,
        )
    notation = VirtualHomePlans()
    return Opened(
        tuple(tasks),
        tasks.sha256,
        lambda task_id: ActionSequencing(tasks[task_id], benchmark.domain, notation),
    )


def _virtualhome_goal_interpretation(
    benchmark: Benchmark, protocol: Protocol, form: Form, source: Source
) -> Opened:
    from eai.abilities.goal_interpretation.scorer import GoalInterpretation
    from eai.benchmarks.reference.virtualhome_goals import ByLargestId
    from eai.benchmarks.virtualhome.goal_notation import VirtualHomeGoals

    tasks, domain = benchmark.tasks_for(Ability.GOAL_INTERPRETATION, source), benchmark.domain
    if protocol is Protocol.EAI_1_0_5:
        return Opened(tuple(tasks), tasks.sha256, lambda task_id: ByLargestId(tasks[task_id], domain))
    notation = VirtualHomeGoals()
    return Opened(
        tuple(tasks), tasks.sha256, lambda task_id: GoalInterpretation(tasks[task_id], domain, notation)
    )


def _virtualhome_subgoal_decomposition(
    benchmark: Benchmark, protocol: Protocol, form: Form, source: Source
) -> Opened:
    from eai.benchmarks.subgoals import virtualhome_subgoals

    tasks = benchmark.tasks_for(Ability.SUBGOAL_DECOMPOSITION, source)
    make = virtualhome_subgoals(protocol)
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: make(tasks[task_id]))


def _behavior_action_sequencing(
    benchmark: Benchmark, protocol: Protocol, form: Form, source: Source
) -> Opened:
    from eai.abilities.action_sequencing.notation import JsonPlans
    from eai.abilities.action_sequencing.scorer import ActionSequencing
    from eai.benchmarks.behavior.benchmark import open_tasks as behavior_tasks
    from eai.benchmarks.reference.behavior_plans import BehaviorActionSequencing

    tasks = behavior_tasks(source)
    if protocol is Protocol.EAI_1_0_5:
        return Opened(tuple(tasks), tasks.sha256, lambda task_id: BehaviorActionSequencing(tasks[task_id]))
    notation = JsonPlans()
    return Opened(
        tuple(tasks),
        tasks.sha256,
        lambda task_id: ActionSequencing(tasks[task_id], benchmark.domain, notation),
    )


def _behavior_goal_interpretation(
    benchmark: Benchmark, protocol: Protocol, form: Form, source: Source
) -> Opened:
    from eai.abilities.goal_interpretation.scorer import GoalInterpretation
    from eai.benchmarks.behavior.benchmark import open_tasks as behavior_tasks
    from eai.benchmarks.behavior.goal_notation import BehaviorGoals
    from eai.benchmarks.reference import behavior_goals as reference

    tasks, domain = behavior_tasks(source), benchmark.domain
    if protocol is Protocol.EAI_1_0_5:
        return Opened(tuple(tasks), tasks.sha256, lambda task_id: reference.ByFirstOption(tasks[task_id]))
    notation = BehaviorGoals()
    return Opened(
        tuple(tasks), tasks.sha256, lambda task_id: GoalInterpretation(tasks[task_id], domain, notation)
    )


def _behavior_subgoal_decomposition(
    benchmark: Benchmark, protocol: Protocol, form: Form, source: Source
) -> Opened:
    from eai.benchmarks.behavior.benchmark import open_tasks as behavior_tasks
    from eai.benchmarks.subgoals import behavior_subgoals

    tasks = behavior_tasks(source)
    make = behavior_subgoals(protocol)
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: make(tasks[task_id]))


def _transition_modeling(benchmark: Benchmark, protocol: Protocol, form: Form, source: Source) -> Opened:
    from eai.abilities.transition_modeling.planners import make_planner
    from eai.abilities.transition_modeling.scorer import TransitionModeling
    from eai.benchmarks.gold_operators import rules_of

    tasks = benchmark.operators(source)
    rules = rules_of(protocol, make_planner(source.planner, benchmark.planner_seconds))
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: TransitionModeling(tasks[task_id], rules))


_OPENERS: Mapping[tuple[str, Ability], Opener] = {
    ("virtualhome", Ability.GOAL_INTERPRETATION): _virtualhome_goal_interpretation,
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION): _virtualhome_subgoal_decomposition,
    ("virtualhome", Ability.ACTION_SEQUENCING): _virtualhome_action_sequencing,
    ("virtualhome", Ability.TRANSITION_MODELING): _transition_modeling,
    ("behavior", Ability.GOAL_INTERPRETATION): _behavior_goal_interpretation,
    ("behavior", Ability.SUBGOAL_DECOMPOSITION): _behavior_subgoal_decomposition,
    ("behavior", Ability.ACTION_SEQUENCING): _behavior_action_sequencing,
    ("behavior", Ability.TRANSITION_MODELING): _transition_modeling,
}
"""How each suite is opened. What an opener needs is imported by it: scoring plans loads no planner."""
