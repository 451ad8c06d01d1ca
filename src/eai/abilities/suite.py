"""Suites: all tasks of a domain and an ability, ready to score answers under a protocol."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from eai.abilities.protocol import Ability, Domain, Protocol
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import Verdict
from eai.data.progress import Report, silent
from eai.data.store import Store
from eai.errors import InputError
from eai.pddl.planning import PlannerChoice

if TYPE_CHECKING:
    from eai.benchmarks.behavior.tasks import BehaviorTask


@dataclass(frozen=True)
class Suite:
    """The tasks of a domain and an ability under one protocol.

    Attributes:
        task_ids: the ids of all tasks, in the order of the data set.
        data_sha256: digest of the data behind them.
        reopen: opens the same suite once more, say in another process; None if it was not opened by
            `open_suite`.
    """

    domain: Domain
    ability: Ability
    protocol: Protocol
    task_ids: tuple[str, ...]
    data_sha256: str
    _make: Callable[[str], Scorer]
    _made: dict[str, Scorer] = field(default_factory=dict, repr=False)
    reopen: Callable[[], Suite] | None = field(default=None, repr=False)

    def scorer(self, task_id: str) -> Scorer:
        """The scorer of a task; it is made once.

        Raises:
            InputError: there is no such task.
        """
        scorer = self._made.get(task_id)
        if scorer is None:
            if task_id not in self.task_ids:
                raise InputError(f"{self.domain.value} {self.ability.value} has no task {task_id!r}")
            scorer = self._made[task_id] = self._make(task_id)
        return scorer

    def score(self, task_id: str, text: str) -> Verdict:
        """The verdict on an answer to a task."""
        return self.scorer(task_id).score(text)


@dataclass(frozen=True, slots=True)
class Source:
    """What a suite is opened with: a store (the user's if None), who is told of a download, a planner."""

    store: Store | None = None
    report: Report = silent
    planner: PlannerChoice = PlannerChoice.FULL


class Opened(NamedTuple):
    """What is particular to a suite: its tasks in order, the digest of its data, and its scorers."""

    task_ids: tuple[str, ...]
    data_sha256: str
    make: Callable[[str], Scorer]


Opener: TypeAlias = Callable[[Protocol, Sequence[str], Source], Opened]


def open_suite(
    domain: Domain,
    ability: Ability,
    protocol: Protocol = Protocol.STRICT,
    *,
    answers: Sequence[str] = (),
    source: Source | None = None,
) -> Suite:
    """Open a suite; the data set is fetched first if it is not there.

    Args:
        domain: the domain.
        ability: the ability.
        protocol: the rules for scoring.
        answers: the texts that will be scored, where the form of all decides how each is read.
        source: where the data comes from; the user's default store if None.

    Raises:
        DataError: the data cannot be had.
        InputError: there is no such suite.
    """
    opener = _OPENERS.get((domain, ability))
    if opener is None:
        raise InputError(f"{domain.value} has no {ability.value} yet")
    source = source or Source()
    opened = opener(protocol, answers, source)
    again = partial(
        open_suite, domain, ability, protocol, answers=answers, source=replace(source, report=silent)
    )
    return Suite(domain, ability, protocol, *opened, reopen=again)


def available_suites() -> tuple[tuple[Domain, Ability], ...]:
    """Every domain and ability for which there is a suite."""
    return tuple(_OPENERS)


def _virtualhome_action_sequencing(protocol: Protocol, answers: Sequence[str], source: Source) -> Opened:
    from eai.abilities.action_sequencing.virtualhome import ActionSequencing, written_with_ids
    from eai.benchmarks.virtualhome.tasks import open_tasks

    tasks = open_tasks(source.store, report=source.report)
    with_ids = written_with_ids(answers) if answers and protocol is Protocol.EAI_1_0_5 else None
    return Opened(
        tuple(tasks),
        tasks.sha256,
        lambda task_id: ActionSequencing(tasks[task_id], protocol, with_ids=with_ids),
    )


def _virtualhome_goal_interpretation(protocol: Protocol, answers: Sequence[str], source: Source) -> Opened:
    from eai.abilities.goal_interpretation.virtualhome import GoalInterpretation
    from eai.benchmarks.virtualhome.tasks import open_tasks

    tasks = open_tasks(source.store, report=source.report)
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: GoalInterpretation(tasks[task_id], protocol))


def _virtualhome_subgoal_decomposition(protocol: Protocol, answers: Sequence[str], source: Source) -> Opened:
    from eai.abilities.subgoal_decomposition.virtualhome import SubgoalDecomposition
    from eai.benchmarks.virtualhome.tasks import open_tasks

    tasks = open_tasks(source.store, report=source.report)
    with_goal = tuple(task_id for task_id in tasks if tasks[task_id].temporal_goal is not None)
    return Opened(with_goal, tasks.sha256, lambda task_id: SubgoalDecomposition(tasks[task_id], protocol))


def _behavior_action_sequencing(protocol: Protocol, answers: Sequence[str], source: Source) -> Opened:
    from eai.abilities.action_sequencing.behavior import ActionSequencing

    return _behavior(source, lambda task: ActionSequencing(task, protocol))


def _behavior_goal_interpretation(protocol: Protocol, answers: Sequence[str], source: Source) -> Opened:
    from eai.abilities.goal_interpretation.behavior import GoalInterpretation

    return _behavior(source, lambda task: GoalInterpretation(task, protocol))


def _behavior_subgoal_decomposition(protocol: Protocol, answers: Sequence[str], source: Source) -> Opened:
    from eai.abilities.subgoal_decomposition.behavior import SubgoalDecomposition

    return _behavior(source, lambda task: SubgoalDecomposition(task, protocol))


def _behavior(source: Source, make: Callable[[BehaviorTask], Scorer]) -> Opened:
    from eai.benchmarks.behavior.tasks import open_tasks

    tasks = open_tasks(source.store, report=source.report)
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: make(tasks[task_id]))


def _transition_modeling(domain: Domain) -> Opener:
    def open_tasks(protocol: Protocol, answers: Sequence[str], source: Source) -> Opened:
        from eai.abilities.transition_modeling.planners import make_planner
        from eai.abilities.transition_modeling.scorer import TransitionModeling
        from eai.benchmarks import gold_operators

        opener = (
            gold_operators.open_virtualhome if domain is Domain.VIRTUALHOME else gold_operators.open_behavior
        )
        tasks = opener(source.store, report=source.report)
        planner = make_planner(source.planner, gold_operators.PLANNER_SECONDS[domain])
        rules = gold_operators.rules_of(protocol, planner)
        return Opened(tuple(tasks), tasks.sha256, lambda task_id: TransitionModeling(tasks[task_id], rules))

    return open_tasks


_OPENERS: Mapping[tuple[Domain, Ability], Opener] = {
    (Domain.VIRTUALHOME, Ability.GOAL_INTERPRETATION): _virtualhome_goal_interpretation,
    (Domain.VIRTUALHOME, Ability.SUBGOAL_DECOMPOSITION): _virtualhome_subgoal_decomposition,
    (Domain.VIRTUALHOME, Ability.ACTION_SEQUENCING): _virtualhome_action_sequencing,
    (Domain.VIRTUALHOME, Ability.TRANSITION_MODELING): _transition_modeling(Domain.VIRTUALHOME),
    (Domain.BEHAVIOR, Ability.GOAL_INTERPRETATION): _behavior_goal_interpretation,
    (Domain.BEHAVIOR, Ability.SUBGOAL_DECOMPOSITION): _behavior_subgoal_decomposition,
    (Domain.BEHAVIOR, Ability.ACTION_SEQUENCING): _behavior_action_sequencing,
    (Domain.BEHAVIOR, Ability.TRANSITION_MODELING): _transition_modeling(Domain.BEHAVIOR),
}
"""How each suite is opened. What an opener needs is imported by it: scoring plans loads no planner."""
