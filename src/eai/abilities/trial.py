"""Trials: a task that is tried in one attempt after the other, in a world where actions may slip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from eai.abilities.attempt import Attempt
from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.explanation import GoalReport
from eai.abilities.notation.plans import Course
from eai.abilities.reports import goal_reports
from eai.abilities.scorer import PlanScorer, assess_or_fail
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import DomainError
from eai.logic.traversal import object_names
from eai.tasks.goal_test import GoalTest, remaining_goals
from eai.tasks.task import Goal, Task
from eai.world.action import Action
from eai.world.episode import Episode, Slip, SlipSampler


class Trial:
    """A task that is tried until an answer succeeds, or until no attempts are left.

    All attempts share one stream of luck, so that what becomes of answers is a function of them and of the
    arguments. The scorer holds the task as it is, whatever an agent is shown of it.

    Args:
        scorer: the scorer of the task.
        options: how many attempts there are, and in what world.
        epoch: which of several repetitions of the trial this is.
        stated: the task with the goals that questions state instead of its own; None for its own.

    Attributes:
        attempts: those made so far.
        told: of each attempt, the reports on the goals that questions state.
        scorer: the scorer of the task.
        luck: which actions slip; None if none does.
        episode: the world of the present attempt.
    """

    def __init__(
        self, scorer: PlanScorer, options: AttemptOptions, epoch: int = 1, stated: Task | None = None
    ) -> None:
        self.options = options
        self.attempts: list[Attempt] = []
        self.told: list[Sequence[GoalReport]] = []
        self._stated = None if stated is None else _StatedGoals.of(scorer.task, stated)
        self.scorer = scorer
        self.luck = None
        if options.slip:
            seed, notice = options.slip_seed or 0, options.notice
            self.luck = SlipSampler(options.slip, scorer.task.id, seed=seed, epoch=epoch, notice=notice)
        self.episode = self.begin()

    @property
    def task(self) -> Task:
        """The task as it is."""
        return self.scorer.task

    @property
    def over(self) -> bool:
        """Whether nothing more is to be tried.

        A task that is in no statistics is tried once.
        """
        if not self.attempts:
            return False
        verdict = self.attempts[-1].verdict
        used_up = len(self.attempts) > self.options.replans
        return used_up or bool(verdict.success) or verdict.excluded is not None

    @property
    def done(self) -> tuple[Action, ...]:
        """The actions that have been executed in the world in which the next attempt begins."""
        return self.episode.trajectory.executed if self.options.world == "continue" else ()

    @property
    def remaining(self) -> Task:
        """The task as the next attempt finds it: from the present state, what is still to be done.

        Its goals are those that questions state.
        """
        task = self.task if self._stated is None else replace(self.task, goals=self._stated.goals, hazards=())
        if self.options.world == "restart":
            return task
        return replace(task, initial=self.episode.state, goals=remaining_goals(task, _names(self.done)))

    def take(self, text: str) -> Attempt:
        """Try an answer.

        Raises:
            ValueError: the trial is over.
        """
        if self.over:
            raise ValueError(f"the trial of {self.task.id} is over")
        if self.attempts and self.options.world == "restart":
            self.episode = self.begin()
        start = len(self.episode.trajectory.steps)
        scorer, empty = self.scorer, PlanVerdict()
        assessment = assess_or_fail(scorer, empty, lambda: scorer.assess_course(text, self.carry_out))
        explanation, verdict = assessment.explain(), assessment.verdict
        if not isinstance(verdict, PlanVerdict):
            raise TypeError(f"{self.task.id}: only plans can be carried out")
        slipped = [i for i, step in enumerate(self.episode.trajectory_from(start).steps) if step.slipped]
        attempt = Attempt(
            text,
            verdict,
            slipped_at=slipped[0] if slipped else None,
            goal_held_at=None if verdict.excluded else self._goal_held_at(start),
            explanation=explanation,
        )
        self.attempts.append(attempt)
        self.told.append(explanation.goals if self._stated is None else self._stated.reports(self.episode))
        return attempt

    def begin(self) -> Episode:
        """The world at the beginning."""
        return Episode(self.scorer.domain, self.task.initial, self.luck)

    def carry_out(self, actions: tuple[Action, ...]) -> Course:
        """The course of a plan in the world as it is now."""
        start, before = len(self.episode.trajectory.steps), self.episode.trajectory.executed
        until = self.reached if self.options.until == "goal" else None
        ended = self.episode.run(actions, until)
        trajectory, slipped = self.episode.trajectory_from(start), isinstance(ended, Slip)
        return Course(trajectory, _names(before), slipped=slipped, whole=self.episode.trajectory)

    def reached(self, episode: Episode) -> bool:
        """Whether all goals hold in an episode now."""
        course = episode.trajectory
        return all(self.scorer.goals.reached(episode.state, _names(course.executed), course))

    def _goal_held_at(self, start: int) -> int | None:
        """After how many of the steps since a step all goals held for the first time."""
        whole, goals = self.episode.trajectory, self.scorer.goals
        taken = _names(whole.executed)
        executed = [step.executed for step in self.episode.trajectory_from(start).steps]
        done = len(taken) - sum(executed)
        for number in [0, *[number for number, is_done in enumerate(executed, 1) if is_done]]:
            course = whole.prefix(done) if goals.watches else None
            if all(goals.reached(whole.states[done], taken[:done], course)):
                return number
            done += 1
        return None


def _names(actions: Sequence[Action]) -> tuple[str, ...]:
    return tuple([action.operator for action in actions])


@dataclass(frozen=True, slots=True)
class _StatedGoals:
    """Goals that questions state instead of the task's own, tested in the world as it is.

    Attributes:
        goals: the goals, in order.
        known: the task with those of them that name nothing unknown.
        test: tests these.
    """

    goals: tuple[Goal, ...]
    known: Task
    test: GoalTest

    @classmethod
    def of(cls, task: Task, stated: Task) -> _StatedGoals:
        known = [goal for goal in stated.goals if _can_be_tested(goal, task)]
        true_world = replace(task, goals=tuple(known), hazards=(), untold=False)
        return cls(stated.goals, true_world, GoalTest(true_world))

    def reports(self, episode: Episode) -> list[GoalReport]:
        """Return a report on each goal; a goal that names something unknown is never met."""
        course = episode.trajectory
        reached = self.test.reached(episode.state, _names(course.executed), course)
        met = dict(zip(self.known.goals, reached, strict=True))
        stated = replace(self.known, goals=self.goals)
        return [*goal_reports(stated, [met.get(goal, False) for goal in self.goals], course)]


def _can_be_tested(goal: Goal, task: Task) -> bool:
    if not set(object_names(goal.formula)) <= task.scene.index.keys():
        return False
    try:
        GoalTest(replace(task, goals=(goal,), hazards=()))
    except DomainError:
        return False
    return True
