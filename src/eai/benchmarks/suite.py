"""Suites: a suite has all tasks of a benchmark for an ability, and scores answers by chosen rules."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import (
    DEFAULT_PROTOCOL,
    PAPER_ABILITIES,
    Ability,
    Protocol,
    find_protocol_entry_points,
)
from eai.abilities.scorer import Assessment, Scorer, assess_or_report_failure
from eai.abilities.task_features import TaskFeatures
from eai.abilities.unread_cause import add_cause_of_unreadability, find_cause_of_unreadability
from eai.abilities.verdict import Unreadable, Verdict
from eai.base.errors import InputError, did_you_mean
from eai.base.store import ignore_progress
from eai.benchmarks.benchmark import Benchmark, Opener
from eai.benchmarks.errata import Errata
from eai.benchmarks.names import TaskReference
from eai.benchmarks.protocols import find_implementation
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import ErrataChoice, Source, TaskSet
from eai.tasks.task import Task
from eai.world.fault import FaultKind


def open_scorers(benchmark: Benchmark, ability: Ability, source: Source) -> TaskSet[Scorer]:
    """Return the scorers of a benchmark's tasks for an ability, by the protocol ``strict``."""
    tasks = benchmark.tasks_for(ability, source)
    make = get_declaration(ability).interaction.scorers(benchmark.collect_domain_and_notation(source))
    return TaskSet(tasks, lambda task_id: make(tasks[task_id]), tasks.sha256, source.kept)


@dataclass(frozen=True)
class Suite:
    """The tasks of a benchmark for one ability, such as action sequencing, and one set of scoring rules.

    Attributes:
        benchmark: the benchmark.
        ability: the ability.
        protocol: the protocol, which is the set of rules for scoring.
        scorers: task id -> scorer of answers, in the order of the data set.
        reopen: opens an equal suite, for example in another process.
        tasks: task id -> task of the benchmark; empty for a suite that is made only of scorers.
        source: the source of the data, the planner, and whether errata are used.
    """

    benchmark: Benchmark
    ability: Ability
    protocol: Protocol
    scorers: TaskSet[Scorer] = field(repr=False)
    reopen: Callable[..., Suite] = field(repr=False)
    tasks: Mapping[str, Task] = field(default_factory=dict, repr=False)
    _features: dict[str, TaskFeatures] = field(default_factory=dict, repr=False)
    source: Source = field(default_factory=Source)

    def __reduce__(self) -> tuple[Callable[[bytes], Suite], tuple[bytes]]:
        """Pickle a suite as a call that opens an equal suite; functions of domains cannot be pickled."""
        if not self.is_openable_by_reference:
            raise InputError(f"{self.domain}: only a suite opened by name or module:object can be pickled")
        return _open_suite_once, (pickle.dumps(self.reopen),)

    @cached_property
    def task_ids(self) -> tuple[str, ...]:
        """Ids of all tasks, in the order of the data set."""
        return tuple(self.scorers)

    @property
    def data_sha256(self) -> str:
        """SHA-256 of the data with which answers are scored."""
        return self.scorers.sha256

    @cached_property
    def _known_task_ids(self) -> frozenset[str]:
        return frozenset(self.task_ids)

    @property
    def is_openable_by_reference(self) -> bool:
        """Whether another process can open the suite, because a text (reference) names its benchmark."""
        return bool(self.benchmark.reference)

    @property
    def domain(self) -> str:
        """Name of the benchmark, which stored verdicts contain as ``domain``."""
        return self.benchmark.name

    @property
    def answers_are_plans(self) -> bool:
        """Whether answers are executed, because they are plans or subgoals."""
        return get_declaration(self.ability).answers_are_plans

    def reference(self, task_id: str) -> str:
        """Return the reference to a task, such as ``virtualhome/action_sequencing/27_2``."""
        return str(TaskReference(self.benchmark.reference or self.domain, self.ability, task_id))

    @property
    def errata(self) -> Errata:
        """The errata that apply to the suite's data."""
        return self.benchmark.get_errata(self.source)

    def choose_suite_for_answers(self, answers: Iterable[str]) -> Suite:
        """Return the suite that scores these answers of a model: this suite, or a copy with other scorers.

        Under some protocols (scoring rules), the form of all answers of a model decides how each is read.
        """
        implementation = find_implementation(self.protocol.value)
        if implementation is None or implementation.choose_suite_for_answers is None:
            return self
        opener = implementation.choose_suite_for_answers(self.benchmark, self.ability, answers)
        return self if opener is None else self.reopen(opener=opener)

    def scorer(self, task_id: str) -> Scorer:
        """Return the scorer of answers to a task. It is made once, on first use.

        Raises:
            InputError: the suite has no such task.
        """
        if task_id not in self._known_task_ids:
            hint = did_you_mean(task_id, self.task_ids)
            raise InputError(f"{self.domain} {self.ability.value} has no task {task_id!r}{hint}")
        return self.scorers[task_id]

    def features(self, task_id: str) -> TaskFeatures | None:
        """Return the features of a task, or None if the task asks only for operators."""
        features_of_task = self._features.get(task_id)
        compute = get_declaration(self.ability).interaction.features
        if features_of_task is None and compute is not None:
            task = self.benchmark.tasks_for(self.ability, self.source)[task_id]
            features_of_task = self._features[task_id] = compute(task)
        if features_of_task is None and (task := self.tasks.get(task_id)) is not None:
            features_of_task = self._features[task_id] = TaskFeatures.from_task(task)
        return features_of_task

    def assess(self, task_id: str, text: str) -> Assessment:
        """Return the verdict on an answer with an explanation. If the scorer raises, the answer fails.

        Raises:
            InputError: there is no such task, or the answer is not a text.
        """
        if not isinstance(text, str):  # a mistake of the caller must not look like a wrong answer
            raise InputError(f"expected an answer to {task_id} as a text, found {type(text).__name__}")
        scorer, empty = self.scorer(task_id), get_declaration(self.ability).verdict()
        return self.add_cause_if_unreadable(
            text, assess_or_report_failure(scorer, empty, lambda: scorer.assess(text))
        )

    def add_cause_if_unreadable(self, text: str, assessment: Assessment) -> Assessment:
        """Return an assessment, with the reason added to its explanation if the answer cannot be read.

        No reason is added for readable answers, or under scoring rules other than ``strict``.
        """
        error = assessment.verdict.error
        is_unread = error is not None and error.kind is FaultKind.PARSING and error.step is None
        if not is_unread or self.protocol is not DEFAULT_PROTOCOL:
            return assessment
        other_ability = partial(find_ability_answered_instead, self.benchmark, self.ability, text)
        return add_cause_of_unreadability(
            assessment,
            find_cause_of_unreadability(text, self.benchmark.domain.operator_arities, other_ability),
        )

    def score(self, task_id: str, text: str) -> Verdict:
        """Return the verdict on an answer to a task. An exception in the scorer makes the answer fail."""
        return self.assess(task_id, text).verdict

    def score_missing_answer(self, task_id: str) -> Verdict:
        """Return the verdict on a task without an answer: a failure, unless the task is excluded."""
        return self.scorer(task_id).score_missing_answer()


def open_suite(
    benchmark: Benchmark | str,
    ability: Ability,
    protocol: Protocol = DEFAULT_PROTOCOL,
    *,
    source: Source | None = None,
    opener: Opener | None = None,
) -> Suite:
    """Open a suite (tasks of a benchmark for an ability); download the data set first if it is missing.

    Args:
        benchmark: the benchmark, or a reference for `find_benchmark`.
        ability: the ability.
        protocol: the rules for scoring.
        source: the source of the data; the user's default store if None. Only the default protocol uses
            errata; other protocols score the published data.
        opener: function that returns the scorers; that of the protocol if None.
            `Suite.choose_suite_for_answers` passes another function.

    Raises:
        DataError: the data cannot be obtained.
        InputError: there is no such benchmark, or the protocol does not score it.
    """
    benchmark_ = find_benchmark(benchmark) if isinstance(benchmark, str) else benchmark
    source = source or Source()
    if protocol is not DEFAULT_PROTOCOL:
        source = replace(source, errata=ErrataChoice.NONE)
    scorers = (opener or _get_suite_opener(protocol))(benchmark_, ability, source)
    tasks = benchmark_.tasks(source)
    source = replace(source, report=ignore_progress)
    reopen = partial(
        open_suite, benchmark_.reference or benchmark_, ability, protocol, source=source, opener=opener
    )
    return Suite(benchmark_, ability, protocol, scorers, reopen, tasks, source=source)


@lru_cache(maxsize=8)
def _open_suite_once(pickled_opener: bytes) -> Suite:
    """Open a pickled suite once in a process, so that all models share its tasks and cached results."""
    opener: Callable[[], Suite] = pickle.loads(pickled_opener)  # noqa: S301 - of a process of this program
    return opener()


def find_ability_answered_instead(benchmark: Benchmark, asked: Ability, answer: str) -> Ability | None:
    """Return the other ability of the paper for which a text has the form of an answer, or None.

    Args:
        benchmark: the benchmark, which has the notations of answers.
        asked: the ability of the question.
        answer: the answer.
    """
    if asked not in PAPER_ABILITIES or not any(bracket in answer for bracket in "{[("):
        return None
    if "(:action" in answer:
        return None if asked is Ability.TRANSITION_MODELING else Ability.TRANSITION_MODELING
    actions = benchmark.domain.operator_arities
    plan = benchmark.notation.plans.read(answer, actions)
    if not isinstance(plan, Unreadable) and any(
        benchmark.notation.plans.to_operator_name(step.action) in actions for step in plan.steps
    ):
        return None if asked is Ability.ACTION_SEQUENCING else Ability.ACTION_SEQUENCING
    subgoals = benchmark.subgoal_notation().read(answer)
    if not isinstance(subgoals, Unreadable) and subgoals.subgoals:
        return None if asked is Ability.SUBGOAL_DECOMPOSITION else Ability.SUBGOAL_DECOMPOSITION
    goals = benchmark.notation.goals.read(answer)
    is_goal = not isinstance(goals, Unreadable) and goals.goals and "goals" in answer
    return Ability.GOAL_INTERPRETATION if is_goal and asked is not Ability.GOAL_INTERPRETATION else None


def _get_suite_opener(protocol: Protocol) -> Opener:
    """Return the function that makes the scorers of a suite under a protocol (rules for scoring).

    Raises:
        InputError: the protocol is not implemented.
    """
    if protocol is DEFAULT_PROTOCOL:
        return open_scorers
    implementation = find_implementation(protocol.value)
    if implementation is None:
        names = ", ".join((DEFAULT_PROTOCOL.value, *find_protocol_entry_points()))
        raise InputError(f"protocol {protocol.value} is not installed: expected one of {names}")
    return implementation.open_suite
