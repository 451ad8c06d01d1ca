"""The scorer of action sequencing: from the text of a plan to its verdict."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

from eai.abilities.declining import read_declining_answer
from eai.abilities.explanation import SLIPPED, VerdictExplanation, write_repair_notes
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.notation.plans import Execution, PlanExecutor, PlanNotation, resolve_plan
from eai.abilities.repair import SmallestPlanRepair
from eai.abilities.reports import report_goals, report_steps
from eai.abilities.scorer import Assessment, PlanScorer, make_error_report
from eai.abilities.verdict import ErrorReport, PlanVerdict, Unreadable, Verdict
from eai.base.errors import InputError
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import Share
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain, make_declared_effects_simulator
from eai.world.episode import Episode, KnownOutcomes
from eai.world.fault import FaultKind
from eai.world.state import State

if TYPE_CHECKING:
    from eai.abilities.plan_repairer import PlanRepairer

_MAX_STEPS_BEFORE_CLEARING_OUTCOMES = 200
"""Number of tried steps after which a task clears its cached outcomes. An outcome takes up to 2 kB."""


class ActionSequencingScorer(PlanScorer):
    """The scorer of the plans for one task.

    Three tests come before any step is executed: whether all steps can be read, whether all names are
    known, and whether each action has the right number of objects. A plan that fails a test is not executed
    and reaches no goal. Any other plan is executed. It succeeds if it runs to its end and reaches all goals.

    Args:
        task: the task.
        domain: the domain in which plans are executed.
        notation: the notation of plans.
        goals: the test of the task's goals; by default `GoalTest`.
    """

    def __init__(
        self, task: Task, domain: Domain, notation: PlanNotation, goals: GoalTest | None = None
    ) -> None:
        self.task = task
        self.domain = domain
        self.notation = notation
        self.goals = goals or GoalTest(task)
        self.excluded = task.unplannable_reason
        self._object = notation.make_object_lookup(task)
        self._outcomes: KnownOutcomes = {}
        self._tried = 0

    def assess(self, text: str) -> Assessment:
        """Return the assessment of a plan that runs from the task's initial state.

        No action slips (lacks its effect).
        """
        assessment = self.assess_execution(text, self._execute_from_start)
        repair = partial(self._add_repair_to_verdict, text, assessment.verdict)
        if self._uses_default_execution_and_goal_test:
            return assessment._replace(analyze_failure=repair)
        return assessment

    @property
    def _uses_default_execution_and_goal_test(self) -> bool:
        """Whether the domain's operators execute plans, and `GoalTest` tests goals.

        The search for the smallest repair of a plan assumes both.
        """
        if self.domain.begin is not make_declared_effects_simulator:
            return False
        return type(self) is ActionSequencingScorer and type(self.goals) is GoalTest

    def compute_closeness_to_success(self, text: str) -> float | None:
        """Return the closeness of a plan to success, from 0 to 1; 0 if the plan cannot be read.

        Return None if the closeness is unknown (`PlanRepairer.why_distance_unknown`).

        Raises:
            InputError: answers are scored by rules other than the paper's (``strict``).
        """
        if not self._uses_default_execution_and_goal_test:
            raise InputError(
                "the closeness of a plan to success is computed only under the protocol strict: use strict"
            )
        declined = read_declining_answer(self.task, text, self.notation)
        if declined is not None or self.task.has_no_plan:  # no edits lead to a plan
            return float(declined is not None and declined.is_right)
        plan = self.read(text)
        if isinstance(plan, Unreadable):
            return 0.0
        return self.repairer.compute_closeness_to_success(self.repairer.read_steps(plan))

    def _add_repair_to_verdict(self, text: str, verdict: Verdict, max_tried_steps: int) -> Verdict:
        if verdict.excluded is not None or not isinstance(verdict, PlanVerdict):
            return verdict
        if verdict.is_task_declined_by_answer and verdict.success:
            return replace(verdict, repair=SmallestPlanRepair(at_most=0))
        plan = self.read(text)
        if verdict.is_task_declined_by_answer or isinstance(plan, Unreadable):
            return replace(verdict, repair=SmallestPlanRepair(why_null="unreadable"))
        return replace(verdict, repair=self.repairer.find_smallest_repair(plan, verdict, max_tried_steps))

    @cached_property
    def repairer(self) -> PlanRepairer:
        """The `PlanRepairer` that finds the smallest repairs of answers to the task."""
        from eai.abilities.plan_repairer import PlanRepairer

        return PlanRepairer(self.task, self.domain, self.notation)

    def assess_execution(self, text: str, execute: PlanExecutor) -> Assessment:
        """Return the assessment of a plan.

        If the task is excluded from scoring, the plan is executed only when `Assessment.explain` is called.

        Args:
            text: the answer.
            execute: function that executes the plan. It is called at most once.
        """
        if self.excluded is None:
            return self._assess_even_if_task_is_excluded(text, execute)
        left_out = PlanVerdict(excluded=self.excluded)
        return Assessment(left_out, lambda: self._assess_even_if_task_is_excluded(text, execute).explain())

    def _assess_even_if_task_is_excluded(self, text: str, execute: PlanExecutor) -> Assessment:
        """Return the assessment of an answer, even if the task is excluded from scoring."""
        declined = read_declining_answer(self.task, text, self.notation)
        if declined is not None:
            return self._assess_declining_answer(*declined)
        plan = self.read(text)
        if isinstance(plan, Unreadable):
            error = ErrorReport(FaultKind.PARSING, plan.step, plan.reason)
            return self._assess_rejected_plan(error, WrittenPlan((), spans=plan.spans), execute)
        actions = self.resolve_names(plan)
        if isinstance(actions, ErrorReport):
            return self._assess_rejected_plan(actions, plan, execute)
        return self._execute_and_assess(plan, actions, execute)

    def read(self, text: str) -> WrittenPlan | Unreadable:
        """Return the plan in an answer, or the reason why the answer cannot be read.

        A plan without steps is readable only if all goals hold at the start.
        """
        plan = self.notation.read(text, self.domain.operator_arities)
        if isinstance(plan, Unreadable) or plan.steps or self._is_goal_reached_at_start:
            return plan
        return Unreadable("the plan has no steps, and not all goals hold at the start", spans=plan.spans)

    @cached_property
    def _is_goal_reached_at_start(self) -> bool:
        return all(self._test_goals(self._execute_from_start(())))

    def resolve_names(self, plan: WrittenPlan) -> tuple[Action, ...] | ErrorReport:
        """Return the actions on objects that a plan means, or the first error in its names.

        Unknown names are reported before wrong numbers of arguments.
        """
        return resolve_plan(plan, self.domain, self.notation, self._object)

    def _assess_declining_answer(
        self, reason: str, is_declining_correct: bool, explanation_notes: tuple[str, str]
    ) -> Assessment:
        reached = self.goals.none_reached
        verdict = self._make_verdict(reached, WrittenPlan(()), success=is_declining_correct, refused=reason)
        return Assessment(
            verdict, lambda: VerdictExplanation(explanation_notes, goals=report_goals(self.task, reached))
        )

    def _assess_rejected_plan(
        self, error: ErrorReport, plan: WrittenPlan, execute: PlanExecutor
    ) -> Assessment:
        step = f"step {error.step + 1}: " if error.step is not None else ""
        reason = f"{error.kind.value}: {step}{error.detail}"
        verdict = self._make_rejection_verdict(error, plan, execute)

        def explain_rejected_plan() -> VerdictExplanation:
            goals = report_goals(self.task, verdict.goals_satisfied)
            return VerdictExplanation(
                (*self._write_notes_on_repairs_and_task_exclusion(plan.repairs), reason), goals=goals
            )

        return Assessment(verdict, explain_rejected_plan)

    def _make_rejection_verdict(
        self, error: ErrorReport, plan: WrittenPlan, execute: PlanExecutor
    ) -> PlanVerdict:
        reached = self._get_goals_met_by_rejected_answer(execute)
        return self._make_verdict(reached, plan, success=False, error=error)

    def _execute_from_start(self, actions: tuple[Action, ...]) -> Execution:
        episode = Episode(self.domain, self.task.initial, known_outcomes=self._outcomes)
        episode.run(actions)
        trajectory = episode.trajectory
        self._tried += len(trajectory.steps)
        if self._tried > _MAX_STEPS_BEFORE_CLEARING_OUTCOMES:
            self._outcomes, self._tried = {}, 0
        return Execution(trajectory, trajectory)

    def _execute_and_assess(
        self, plan: WrittenPlan, actions: tuple[Action, ...], execute: PlanExecutor
    ) -> Assessment:
        execution = execute(actions)
        verdict = self._judge_execution(execution, plan)
        return Assessment(verdict, partial(self._explain, verdict, execution))

    def _judge_execution(self, execution: Execution, plan: WrittenPlan) -> PlanVerdict:
        reached = self._test_goals(execution)
        trajectory, failure = execution.trajectory, execution.trajectory.failure
        error = None
        number = len(trajectory.steps) - 1
        if failure is not None:
            action = trajectory.steps[-1].action
            error = make_error_report(failure, number, self.domain, action, self.task.scene)
        elif execution.slipped:
            error = ErrorReport(FaultKind.SLIP, number, SLIPPED)
        success, additional = self._is_success(error, reached), trajectory.needless_step_count
        return self._make_verdict(
            reached,
            plan,
            success=success,
            error=error,
            additional_steps=additional,
            partial=self.goals.find_partial_success(
                self._get_final_state(execution), execution.names_of_all_executed_actions, reached
            ),
        )

    def _make_verdict(
        self,
        reached: tuple[bool, ...],
        plan: WrittenPlan,
        *,
        success: bool,
        error: ErrorReport | None = None,
        additional_steps: int = 0,
        refused: str | None = None,
        partial: Share | None = None,
    ) -> PlanVerdict:
        """Return the verdict on a plan. `reached` says for each goal whether the plan reaches it.

        `partial` is the share of the goals' conditions that the plan meets; None if the plan was not
        executed.
        """
        return PlanVerdict(
            executable=error is None and refused is None,
            success=success,
            error=error,
            additional_steps=additional_steps,
            goals=self.goals.tally_by_kind(reached),
            repairs=plan.repairs,
            spans=plan.spans,
            goals_satisfied=reached,
            partial=partial or self.goals.partial_success_of_unexecuted_answer,
            refused=refused,
        )

    def _explain(self, verdict: PlanVerdict, execution: Execution) -> VerdictExplanation:
        return VerdictExplanation(
            self._write_notes_on_repairs_and_task_exclusion(verdict.repairs),
            report_steps(self.task, self.domain, execution.trajectory),
            report_goals(self.task, verdict.goals_satisfied, execution.whole_trajectory),
        )

    def _write_notes_on_repairs_and_task_exclusion(self, repairs: tuple[str, ...]) -> tuple[str, ...]:
        excluded = () if self.excluded is None else (f"excluded: {self.excluded}",)
        return (*write_repair_notes(repairs), *excluded)

    def _test_goals(self, execution: Execution) -> tuple[bool, ...]:
        """Return for each goal, in order, whether the executed plan reaches it."""
        return self.goals.evaluate_each_goal(
            self._get_final_state(execution),
            execution.names_of_all_executed_actions,
            execution.whole_trajectory,
        )

    def _get_final_state(self, execution: Execution) -> State:
        return execution.trajectory.final_state

    def _get_goals_met_by_rejected_answer(self, execute: PlanExecutor) -> tuple[bool, ...]:
        """Return False for each goal, because the answer is not executed.

        A subclass may count goals that hold in the initial state as reached.
        """
        return self.goals.none_reached

    def _is_success(self, error: ErrorReport | None, reached: tuple[bool, ...]) -> bool:
        return error is None and all(reached)
