"""Trials: a model may answer a task several times (in attempts), and actions may slip (have no effect)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from eai.abilities.attempt import Attempt
from eai.abilities.explanation import GoalReport
from eai.abilities.notation.plans import Execution
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.reports import report_goals
from eai.abilities.scorer import PlanScorer, assess_or_report_failure
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import DomainError
from eai.logic.traversal import find_object_names
from eai.tasks.goal_test import GoalTest, find_remaining_goals
from eai.tasks.task import Goal, Task
from eai.world.action import Action
from eai.world.episode import Episode, Slip, SlipSampler


class MultiAttemptTrial:
    """A task that a model may attempt several times, until an answer succeeds or no attempts are left.

    All attempts share one random sequence of slips (possible actions without effect). So outcomes depend only
    on the answers and the arguments. The scorer has the true task. The question may state other goals or
    another scene.

    Args:
        scorer: the scorer of the task.
        options: the number of attempts, the state in which each begins, and the feedback.
        epoch: number of this trial among the repetitions for the same task, from 1.
        task_with_stated_goals: the task with the goals that questions state. A model may have got these
            wrong. None if questions state the task's own goals.

    Attributes:
        attempts: the attempts so far.
        goal_reports: for each attempt, the reports on the goals that questions state.
        scorer: the scorer of the task.
        slip_sampler: draws which actions slip; None without slips.
        episode: the world in which the present answer is executed.
    """

    def __init__(
        self,
        scorer: PlanScorer,
        options: ReplanningOptions,
        epoch: int = 1,
        task_with_stated_goals: Task | None = None,
    ) -> None:
        self.options = options
        self.attempts: list[Attempt] = []
        self.goal_reports: list[Sequence[GoalReport]] = []
        self._question_goals = (
            None
            if task_with_stated_goals is None
            else _GoalsStatedInQuestions.from_tasks(scorer.task, task_with_stated_goals)
        )
        self.scorer = scorer
        self.slip_sampler = None
        if options.slip:
            seed, notice = options.slip_seed or 0, options.notice
            self.slip_sampler = SlipSampler(
                options.slip, scorer.task.id, seed=seed, epoch=epoch, notice=notice
            )
        self.episode = self.start_episode()

    @property
    def task(self) -> Task:
        """The scorer's task. Questions may show another scene or state other goals than this task."""
        return self.scorer.task

    @property
    def has_no_attempt_left(self) -> bool:
        """Whether the task may not be tried again. A task that is excluded from scoring gets one attempt."""
        if not self.attempts:
            return False
        verdict = self.attempts[-1].verdict
        used_up = len(self.attempts) > self.options.replans
        return used_up or bool(verdict.success) or verdict.excluded is not None

    @property
    def executed_actions(self) -> tuple[Action, ...]:
        """The actions executed so far in the world in which the next attempt begins."""
        return self.episode.trajectory.executed_actions if self.options.world == "continue" else ()

    @property
    def task_in_next_question(self) -> Task:
        """The task of the next question.

        Its goals are the goals that questions state. If each attempt begins where the previous one ended,
        this task begins in the present state and has only the goals that remain.
        """
        stated = self._question_goals
        task = self.task if stated is None else self.task.replace_goals(stated.goals)
        if self.options.world == "restart":
            return task
        return replace(
            task,
            initial=self.episode.state,
            goals=find_remaining_goals(task, _get_operator_names(self.executed_actions)),
        )

    def try_answer(self, text: str) -> Attempt:
        """Execute an answer, and return the answer with its verdict as an `Attempt`.

        Raises:
            ValueError: the trial is over.
            TypeError: the scorer gives another verdict than a `PlanVerdict`.
        """
        if self.has_no_attempt_left:
            raise ValueError(f"the trial of {self.task.id} is over: no further answer can be tried")
        if self.attempts and self.options.world == "restart":
            self.episode = self.start_episode()
        start = len(self.episode.trajectory.steps)
        scorer, empty = self.scorer, PlanVerdict()
        assessment = assess_or_report_failure(
            scorer, empty, lambda: scorer.assess_execution(text, self.execute_plan)
        )
        explanation, verdict = assessment.explain(), assessment.verdict
        if not isinstance(verdict, PlanVerdict):
            raise TypeError(
                f"{self.task.id}: a trial needs a scorer that gives a PlanVerdict, "
                f"but the scorer gave a {type(verdict).__name__}"
            )
        slipped = [i for i, step in enumerate(self.episode.trajectory_from(start).steps) if step.slipped]
        attempt = Attempt(
            text,
            verdict,
            slipped_at=slipped[0] if slipped else None,
            goal_held_at=None if verdict.excluded else self._count_steps_to_goals(start),
            explanation=explanation,
        )
        self.attempts.append(attempt)
        self.goal_reports.append(
            explanation.goals
            if self._question_goals is None
            else self._question_goals.report_stated_goals(self.episode)
        )
        return attempt

    def start_episode(self) -> Episode:
        """Return a new episode, which begins in the task's initial state."""
        return Episode(self.scorer.domain, self.task.initial, self.slip_sampler)

    def execute_plan(self, actions: tuple[Action, ...]) -> Execution:
        """Execute a plan in the present world, which earlier plans may have changed."""
        start = len(self.episode.trajectory.steps)
        until = self.is_goal_reached if self.options.until == "goal" else None
        ended = self.episode.run(actions, until)
        return Execution(
            self.episode.trajectory_from(start), self.episode.trajectory, slipped=isinstance(ended, Slip)
        )

    def is_goal_reached(self, episode: Episode) -> bool:
        """Whether all goals are reached in the present state of an episode."""
        trajectory = episode.trajectory
        return all(
            self.scorer.goals.evaluate_each_goal(
                episode.state, _get_operator_names(trajectory.executed_actions), trajectory
            )
        )

    def _count_steps_to_goals(self, first_step: int) -> int | None:
        """Return the number of steps from ``first_step`` until all goals first held, or None."""
        whole, goals = self.episode.trajectory, self.scorer.goals
        taken = _get_operator_names(whole.executed_actions)
        executed = [step.is_executed for step in self.episode.trajectory_from(first_step).steps]
        done = len(taken) - sum(executed)
        for number in [0, *[number for number, is_done in enumerate(executed, 1) if is_done]]:
            trajectory = whole.prefix(done) if goals.has_goals_over_time else None
            if all(goals.evaluate_each_goal(whole.states[done], taken[:done], trajectory)):
                return number
            done += 1
        return None


def _get_operator_names(actions: Sequence[Action]) -> tuple[str, ...]:
    return tuple([action.operator for action in actions])


@dataclass(frozen=True, slots=True)
class _GoalsStatedInQuestions:
    """Goals that questions state instead of the task's own goals.

    They are tested in the task's scene, even if questions show another scene.

    Attributes:
        goals: the stated goals, in order.
        known_task: the task with those stated goals that can be tested, because the task has their names.
        test: the test of the goals of `known_task`.
    """

    goals: tuple[Goal, ...]
    known_task: Task
    test: GoalTest

    @classmethod
    def from_tasks(cls, task: Task, task_with_stated_goals: Task) -> _GoalsStatedInQuestions:
        testable = [
            goal for goal in task_with_stated_goals.goals if _can_goal_be_evaluated_in_task(goal, task)
        ]
        true_world = task.replace_goals(tuple(testable))
        return cls(task_with_stated_goals.goals, true_world, GoalTest(true_world))

    def report_stated_goals(self, episode: Episode) -> list[GoalReport]:
        """Return a report on each stated goal. A goal with an unknown name counts as missed."""
        trajectory = episode.trajectory
        reached = self.test.evaluate_each_goal(
            episode.state, _get_operator_names(trajectory.executed_actions), trajectory
        )
        met = dict(zip(self.known_task.goals, reached, strict=True))
        stated = replace(self.known_task, goals=self.goals)
        return [*report_goals(stated, [met.get(goal, False) for goal in self.goals], trajectory)]


def _can_goal_be_evaluated_in_task(goal: Goal, task: Task) -> bool:
    if not set(find_object_names(goal.formula)) <= task.scene.index.keys():
        return False
    try:
        GoalTest(task.replace_goals((goal,)))
    except DomainError:
        return False
    return True
