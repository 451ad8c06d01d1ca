"""Tasks without end: each is a pure function of a specification and a seed, or a reason why there is none."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.goal_test import GoalTest
from eai.abilities.protocol import Ability
from eai.abilities.task import Task, goal
from eai.abilities.verdict import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generated import fingerprint
from eai.benchmarks.generated.goals import Proposals, clash, subjects_of
from eai.benchmarks.generated.over_time import Seeker
from eai.benchmarks.generated.prior import Prior, prior_of
from eai.benchmarks.generated.reader import Reader
from eai.benchmarks.generated.scene import closed_scene, with_guests
from eai.benchmarks.generated.spec import CANARY, LENGTHS, Spec, Tier, tier_of
from eai.benchmarks.generated.usage import Usage
from eai.benchmarks.generated.walk import Walk, certificate, lower_bound, posed
from eai.benchmarks.generated.words import Words
from eai.benchmarks.lookup import LookupTable
from eai.benchmarks.source import Source
from eai.benchmarks.task_lines import plan_of
from eai.errors import InputError
from eai.planning.planner import Planner
from eai.world.execution import Action, execute
from eai.world.relation import bits
from eai.world.state import State

_TRIES = 12
"""How many goals are proposed for one that is wanted, where scenes are rich ten times as many."""

_GIVEN_UP = 5
"""After so many goals in a row that are not reached, a scene has no more to offer."""

_RICH = (Tier.L, Tier.XL, Tier.XXL)
"""The tiers that ask for scenes with more in them than those of the data set."""

_LEAST_STEPS = 3
"""How short a certificate may be where nothing else is asked for."""

_USUAL_STEPS = 5
"""How long a plan is taken to be where the data set has none."""

_LONGER = 6
"""How many steps more a certificate may have for the sake of a goal over time."""

_IN_VAIN = 300
"""After so many seeds in a row that give no task there are no more."""

_RENEWED = 200
"""After so many tasks the planner begins anew: it keeps every formula that it has read."""


class Reason(str, Enum):
    """Why a seed gives no task."""

    NO_GOALS = "no goal was reached"
    TOO_SHORT = "the certificate is too short"
    TOO_LONG = "the certificate is too long"
    HOLDS_ALREADY = "a goal holds at the start"
    ONE_ACTION = "one action solves it"
    NO_CERTIFICATE = "the certificate does not solve it"
    AMBIGUOUS = "the instruction does not say exactly the goals"
    NO_ORDER = "no goal over time was found that matters"
    PUBLIC = "a public task has the same goals"
    PUBLIC_PLAN = "the plan of a public task with similar goals solves it"
    COPY = "another generated task is the same"


@dataclass(frozen=True, slots=True)
class Rejected:
    """No task, and why."""

    seed: str
    reason: Reason


@dataclass(frozen=True, slots=True)
class Generated:
    """A task with its certificate, which is its script, and what is known of it."""

    task: Task
    about: Mapping[str, Json]


Outcome: TypeAlias = "Generated | Rejected"


@dataclass
class Generator:
    """Makes tasks.

    Args:
        benchmark: whose world they are in.
        spec: what is wanted.
        source: where the data set comes from.
    """

    benchmark: Benchmark
    spec: Spec
    source: Source
    _made: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._tasks = list(self.benchmark.tasks(self.source).values())
        self.prior: Prior = prior_of(self.benchmark, self._tasks)
        self._public = {fingerprint.of_goals(_formulas(task), task.scene) for task in self._tasks}
        self._table = LookupTable(self._tasks, self.benchmark.domain)
        self._usage = Usage(self.benchmark.domain, self.prior)
        self._planner = Planner(self._usage.domain)
        listings = self.benchmark.wording(Ability.ACTION_SEQUENCING).listings
        self._seeker = Seeker(self.benchmark.domain, self._usage.domain, self.prior, listings)

    def task(self, seed: str) -> Outcome:
        """The task of a seed: the same on every machine."""
        self._made += 1
        if self._made % _RENEWED == 0:
            self._planner = Planner(self._usage.domain)
        rng = self.spec.rng(seed)
        base = rng.choice(self._tasks)
        initial = self._scene(base, rng)
        least, most = self._window(base)
        walk = self._walk(initial, rng, least, most)
        if not walk.goals:
            return Rejected(seed, Reason.NO_GOALS)
        goals = list(walk.goals)
        words = self._words(self._usage.original(initial))
        task = posed(
            f"{self.benchmark.name}-{self.spec.sha256[:6]}-{seed}",
            words.instruction(goals, rng),
            self._usage.original(initial),
            goals,
            certificate(walk, initial),
        )
        about: dict[str, Json] = {}
        reason = self._objection(task, least, most)
        if reason is None and self.spec.over_time:
            found = self._seeker.find(task, initial, self._planner, self._proposals(initial), rng)
            if found is None:
                return Rejected(seed, Reason.NO_ORDER)
            told = words.instruction([*goals, found.goal], rng)
            asked = (*task.goals, goal(found.goal))
            task = replace(task, goals=asked, script=tuple(found.plan), instruction=told)
            about["temptation"] = plan_of(replace(task, script=tuple(found.temptation)))
            reason = self._objection(task, least, most + _LONGER)
        if reason is not None:
            return Rejected(seed, reason)
        about["lower_bound"] = least = lower_bound(task, self.benchmark.domain, self.spec.depth)
        if least == 1:
            return Rejected(seed, Reason.ONE_ACTION)
        return Generated(task, {**self._about(task, seed), **about})

    def _about(self, task: Task, seed: str) -> dict[str, Json]:
        """What is known of a task."""
        of_goals, of_scene = fingerprint.of_task(task)
        return {
            "tier": tier_of(len(task.script)).value,
            "distractors": len(task.scene.objects) - len(_needed(task)),
            "operators": len({action.operator for action in task.script}),
            "goals_fingerprint": of_goals,
            "scene_fingerprint": of_scene,
            "spec": self.spec.sha256[:16],
            "seed": seed,
            "canary": CANARY,
        }

    def _scene(self, base: Task, rng: random.Random) -> State:
        """A closed scene in which some things were done before, none of which leaves anything in a hand."""
        most = self.spec.most_objects
        rich = self.spec.tier in _RICH
        found = closed_scene(base, self.prior, rng, most, rich=rich)
        if rich:
            found = with_guests(found, self._tasks, self.prior, rng, most)
        closed = self._usage.state(*found)
        proposals = self._proposals(closed)
        walk = Walk(self._usage.domain, self._planner, closed)
        for _ in range(rng.randint(0, self.spec.disturbances)):
            wanted, before = proposals.literal(rng), walk.state
            if wanted is not None:
                walk.reach(wanted)
                walk.conditions.clear()
            if self._held(walk.state) - self._held(before):
                walk.state = before
        return self._usage.state(walk.state.scene, walk.state.facts())

    def _held(self, state: State) -> set[int]:
        """The objects in hands."""
        held: set[int] = set()
        for name in self.prior.holding:
            if name in state.scene.vocabulary.binary_slots:
                held.update(pair.target for pair in state.relation(name).pairs())
            else:
                held.update(bits(state.those(name)))
        return held

    def _window(self, base: Task) -> tuple[int, int]:
        """The least and the greatest length of the certificate."""
        if self.spec.tier is not Tier.DATA:
            return LENGTHS[self.spec.tier]
        length = len(base.script) or _USUAL_STEPS
        return max(_LEAST_STEPS, round(0.5 * length)), max(2 * _LEAST_STEPS, round(1.4 * length))

    def _proposals(self, state: State) -> Proposals:
        return Proposals.for_scene(state.scene, self.prior, self.spec.forms, actions=self.spec.actions)

    def _walk(self, initial: State, rng: random.Random, least: int, most: int) -> Walk:
        """A walk about as long as is wanted."""
        scene, proposals = initial.scene, self._proposals(initial)
        walk = Walk(self._usage.domain, self._planner, initial)
        wanted = rng.randint((least + most) // 2, most)
        tried: set[f.Formula] = set()
        ending = proposals.ending(rng)
        failures = 0  # one after the other
        tries = _TRIES * (10 if self.spec.tier in _RICH else 1)
        for _ in range(tries * max(2, wanted // 3)):
            if len(walk.trail) >= wanted or failures == max(_GIVEN_UP, wanted // 3):
                break
            goal = proposals.goal(rng)
            if goal is None or goal in tried or walk.holds(goal, initial):
                continue
            tried.add(goal)
            if not any(clash(goal, other, scene) for other in (*walk.goals, *ending)):
                reached = self._reach_and_leave(walk, goal)
                failures = 0 if reached else failures + 1
        for goal in ending:  # last, as the agent would go on from there otherwise
            if not walk.holds(goal, initial):
                walk.reach(goal)
        return walk

    def _reach_and_leave(self, walk: Walk, goal: f.Formula) -> bool:
        """Reach a goal more, but not by keeping in hand what it is about."""
        subjects, before = subjects_of(goal, walk.state.scene), walk.mark()
        if not walk.reach(goal, len(subjects)):
            return False
        if subjects.isdisjoint(self._held(walk.state)):
            return True
        walk.back_to(before)
        return False

    def _objection(self, task: Task, least: int, most: int) -> Reason | None:
        """Why a task is not to be asked."""
        test = GoalTest(task)
        if len(task.script) < least:
            return Reason.TOO_SHORT
        if len(task.script) > most:
            return Reason.TOO_LONG
        reached = zip(task.goals, test.reached(task.initial, ()), strict=True)
        if any(holds for each, holds in reached if not each.is_over_time):
            return Reason.HOLDS_ALREADY
        if not self._is_solved(task, task.script):
            return Reason.NO_CERTIFICATE
        if not self._says_its_goals(task):
            return Reason.AMBIGUOUS
        if fingerprint.of_task(task)[0] in self._public:
            return Reason.PUBLIC
        if self._is_solved(task, self._table.plan(task)):
            return Reason.PUBLIC_PLAN
        return None

    def _is_solved(self, task: Task, plan: Sequence[Action]) -> bool:
        """Whether a plan runs to its end and reaches all goals."""
        trajectory = execute(self.benchmark.domain, task.initial, plan)
        operators = [action.operator for action in trajectory.executed]
        return trajectory.failure is None and all(
            GoalTest(task).reached(trajectory.final, operators, trajectory)
        )

    def _words(self, initial: State) -> Words:
        return Words.of(self.benchmark, initial, by_place=self.spec.by_place)

    def _says_its_goals(self, task: Task) -> bool:
        """Whether the instruction, read again, gives the goals back."""
        try:
            return Reader(self._words(task.initial)).goals(task.instruction) == _formulas(task)
        except InputError:
            return False


def _needed(task: Task) -> set[int]:
    """The objects that the goals name or range over, that the certificate uses, and the agent."""
    used = {index for action in task.script for index in action.arguments}
    asked = {index for each in task.goals for index in fingerprint.spoken_of(each.formula, task.scene)}
    return used | asked | {i for i in (task.scene.agent,) if i is not None}


def _formulas(task: Task) -> tuple[f.Formula, ...]:
    return tuple([each.formula for each in task.goals])


def generate(
    generator: Generator, seeds: Iterator[str], number: int, known: set[tuple[str, str]]
) -> Iterator[Outcome]:
    """So many tasks by seeds in order, and what was rejected on the way.

    Raises:
        InputError: there are no more tasks to be had: very many seeds in a row gave none.

    Args:
        generator: makes them.
        seeds: as many as it takes.
        number: how many tasks.
        known: the fingerprints of tasks that there are already; those of the new ones are added.
    """
    found = in_vain = 0
    while found < number:
        if in_vain == _IN_VAIN:
            raise InputError(f"only {found} of {number} tasks found: the last {in_vain} seeds gave none")
        outcome = generator.task(next(seeds))
        if isinstance(outcome, Generated):
            prints = fingerprint.of_task(outcome.task)
            if prints in known:
                outcome = Rejected(str(outcome.about["seed"]), Reason.COPY)
            else:
                known.add(prints)
                found += 1
        in_vain = 0 if isinstance(outcome, Generated) else in_vain + 1
        yield outcome
