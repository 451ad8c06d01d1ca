"""The scorer of subgoal decomposition: from the text of an answer to its verdict, in any domain.

A search tries ways to execute the subgoals. The scorer turns the result of the search into a verdict.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial

from eai.abilities.explanation import VerdictExplanation, write_repair_notes
from eai.abilities.notation.subgoals import SubgoalNotation
from eai.abilities.reports import report_goal_parts, report_goals, report_steps
from eai.abilities.scorer import Assessment, Scorer, make_error_report
from eai.abilities.subgoal_decomposition.program import CompiledSubgoalAnswer, RejectedAnswer
from eai.abilities.subgoal_decomposition.program_builder import SubgoalProgramCompiler
from eai.abilities.subgoal_decomposition.refinement import SubgoalRefiner
from eai.abilities.subgoal_decomposition.search import (
    ExplorationLimits,
    ExplorationResult,
    GoalProgress,
    SubgoalExecutionBranch,
    explore_subgoal_program,
)
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.verdict import ErrorReport
from eai.logic.formula import Formula, Then
from eai.logic.ltl import read_formula
from eai.logic.ltl_printer import format_ltl
from eai.logic.traversal import find_object_names
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import Share
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.state import Scene


def classify_answer_by_exploration(outcome: ExplorationResult) -> SubgoalAnswerCategory:
    """Return the category of an answer, given the result of trying all ways to execute the answer."""
    if outcome.success:
        return SubgoalAnswerCategory.CORRECT
    return SubgoalAnswerCategory.GOAL_UNREACHABLE if outcome.executable else SubgoalAnswerCategory.RUNTIME


def find_branch_error(branch: SubgoalExecutionBranch, domain: Domain, scene: Scene) -> ErrorReport | None:
    """Return the error that ended a branch of the search, or None.

    The step in this error is the number of the failed subgoal, from 0.
    """
    failure = branch.failure
    if failure is None:
        return None
    last = branch.tried
    if last is not None and last.step.fault is failure:
        return make_error_report(failure, branch.subgoal, domain, last.step.action, scene)
    check = failure.check
    return ErrorReport(
        failure.kind, branch.subgoal, check.reason, check.id, find_object_names(check.condition)
    )


class SubgoalDecompositionScorer(Scorer):
    """The scorer of the subgoals for one task.

    Two tests come before any action is executed: whether all subgoals of the answer can be read, and
    whether all names are known. Then a search explores all ways to execute the answer
    (`explore_subgoal_program`). Each way is a branch. An answer succeeds if one branch reaches the goal. The
    parts of the task's temporal goal, or else its action goals, must be met in order. All goals about
    states must hold at the end, and all goals over time during the execution. The verdict has the
    errors of the reported branch, and the goals of the branch that reaches most goals. An answer that
    is not executed reaches no goal.

    Args:
        task: the task.
        domain: the domain in which subgoals are executed.
        notation: the notation of subgoals; by default the names that the domain declares.
        refinement: finds the actions for subgoals; by default `SubgoalRefiner`.
        goals: the test of the task's goals; by default `GoalTest`.
        limits: limits of the search. Only answers that can be executed in very many ways reach them.
    """

    def __init__(
        self,
        task: Task,
        domain: Domain,
        notation: SubgoalNotation | None = None,
        refinement: SubgoalRefiner | None = None,
        *,
        goals: GoalTest | None = None,
        limits: ExplorationLimits | None = None,
    ) -> None:
        self.task = task
        self.domain = domain
        self.notation = notation or SubgoalNotation(domain)
        self._refinement = refinement
        self.goals = goals or GoalTest(task)
        self.excluded = task.unplannable_reason
        self.lexicon = self.notation.make_lexicon_of_names_in_subgoals(task.scene)
        self.temporal_goal = self._read_temporal_goal()
        self._goal = self._make_goal_progress()
        self._limits = limits or ExplorationLimits()

    def assess(self, text: str) -> Assessment:
        """Return the assessment of an answer.

        Its explanation shows the steps of one way to execute the answer (`ExplorationResult.reported`).
        """
        assessment = self._assess_even_if_task_is_excluded(text)
        if self.excluded is None:
            return assessment
        return Assessment(SubgoalVerdict(excluded=self.excluded), assessment.explain)

    def compile_answer(self, text: str) -> CompiledSubgoalAnswer | RejectedAnswer:
        """Return the answer as a program for the search, or the reason why the answer cannot be executed."""
        return self._program_compiler.compile_subgoals(self.notation.read(text))

    @cached_property
    def _program_compiler(self) -> SubgoalProgramCompiler:
        refinement = self._refinement or SubgoalRefiner(self.domain)
        return SubgoalProgramCompiler(self.task, self.lexicon, refinement, self._goal.actions)

    def _assess_even_if_task_is_excluded(self, text: str) -> Assessment:
        """Return the assessment of an answer, even if the task is excluded from scoring."""
        compiled = self.compile_answer(text)
        if isinstance(compiled, RejectedAnswer):
            return self._assess_rejected_answer(compiled, compiled.repairs)
        outcome = self._explore_executions_of_subgoals(compiled)
        if isinstance(outcome, RejectedAnswer):
            return self._assess_rejected_answer(outcome, compiled.repairs)
        return Assessment(
            self._judge_exploration(compiled, outcome), partial(self._explain, compiled, outcome)
        )

    def _read_temporal_goal(self) -> Formula | None:
        text = self.task.temporal_goal
        if text is None:
            return None
        return self.lexicon.replace_lexicon_names_by_domain_names(
            read_formula(text, self.lexicon.signature)[0]
        )

    def _make_goal_progress(self) -> GoalProgress:
        actions = Then(tuple([goal.formula for goal in self.task.get_goals_of_kind(GoalKind.ACTION)]))
        on_course = self.goals.meets_goals_over_time if self.goals.has_goals_over_time else None
        return GoalProgress(
            self.temporal_goal or actions, self.task.scene, self.goals.meets_goals_about_states, on_course
        )

    def _explore_executions_of_subgoals(
        self, compiled: CompiledSubgoalAnswer
    ) -> ExplorationResult | RejectedAnswer:
        return explore_subgoal_program(
            self.domain, self.task.initial, compiled.program, self._goal, self._limits
        )

    def _judge_exploration(
        self, compiled: CompiledSubgoalAnswer, outcome: ExplorationResult
    ) -> SubgoalVerdict:
        branch, best = outcome.reported, self._find_best_branch(outcome)
        reached = self._test_goals(best)
        kinds = tuple([fault.kind for fault in branch.faults])
        return SubgoalVerdict(
            executable=outcome.executable,
            success=outcome.success,
            error=find_branch_error(branch, self.domain, self.task.scene),
            additional_steps=kinds.count(FaultKind.ADDITIONAL_STEP),
            category=classify_answer_by_exploration(outcome),
            goals=self.goals.tally_by_kind(reached),
            repairs=compiled.repairs,
            spans=compiled.spans,
            goals_satisfied=reached,
            partial=self._find_largest_partial_success_of_branches(outcome),
            goals_elsewhere=best is not branch,
            errors=kinds,
            search=outcome.end,
            tried_actions=outcome.attempts,
            refined=branch.refined,
            added_actions=_count_actions_beyond_one_per_subgoal(branch),
            errors_elsewhere=() if best is branch else tuple([fault.kind for fault in best.faults]),
            added_elsewhere=None if best is branch else _count_actions_beyond_one_per_subgoal(best),
        )

    def _assess_rejected_answer(self, rejected: RejectedAnswer, repairs: tuple[str, ...]) -> Assessment:
        verdict = self._make_rejection_verdict(rejected)
        return Assessment(verdict, partial(self._explain_rejection, verdict, rejected, repairs))

    def _make_rejection_verdict(self, rejected: RejectedAnswer) -> SubgoalVerdict:
        reached = self._get_goals_met_by_rejected_answer()
        return SubgoalVerdict(
            executable=False,
            success=False,
            error=rejected.error,
            additional_steps=0,
            category=rejected.category,
            goals=self.goals.tally_by_kind(reached),
            repairs=rejected.repairs,
            spans=rejected.spans,
            goals_satisfied=reached,
            partial=self.goals.partial_success_of_unexecuted_answer,
            offences=tuple(dict.fromkeys([misuse.kind for _, misuse in rejected.misused_names])),
        )

    def _find_best_branch(self, outcome: ExplorationResult) -> SubgoalExecutionBranch:
        """Return the way to execute the answer (branch) that reaches most goals.

        Among equal branches, the branch whose errors the verdict reports is preferred.

        The paper takes the maximum over all sequences of actions (section "Ability Module 2: Subgoal
        Decomposition"). Goals are tested in the state in which a sequence stops. So a failed branch counts,
        too.
        """
        return max(
            self._select_execution_branches_to_judge(outcome),
            key=lambda branch: sum(self._test_goals(branch)),
        )

    def _find_largest_partial_success_of_branches(self, outcome: ExplorationResult) -> Share:
        best = Share(0, 0)
        for branch in self._select_execution_branches_to_judge(outcome):
            share = self.goals.find_partial_success(
                branch.state, list_operators_of_executed_actions(branch), self._test_goals(branch)
            )
            if (
                share.numerator * best.denominator > best.numerator * share.denominator
                or not best.denominator
            ):
                best = share
            if best.numerator == best.denominator:
                break
        return best

    def _select_execution_branches_to_judge(
        self, outcome: ExplorationResult
    ) -> tuple[SubgoalExecutionBranch, ...]:
        """Return all ways to execute the answer. The way whose errors the verdict reports comes first."""
        return (outcome.reported, *outcome.ended)

    def _test_goals(self, branch: SubgoalExecutionBranch) -> tuple[bool, ...]:
        """Return for each goal, in order, whether a branch (one execution of the subgoals) reaches it."""
        trajectory = branch.trajectory if self.goals.has_goals_over_time else None
        return self.goals.evaluate_each_goal(
            branch.state, list_operators_of_executed_actions(branch), trajectory
        )

    def _get_goals_met_by_rejected_answer(self) -> tuple[bool, ...]:
        """Return False for each goal, because the answer is not executed.

        A subclass may count goals that hold in the initial state as reached.
        """
        return self.goals.none_reached

    def _explain(self, compiled: CompiledSubgoalAnswer, outcome: ExplorationResult) -> VerdictExplanation:
        branch, best = outcome.reported, self._find_best_branch(outcome)
        notes = [classify_answer_by_exploration(outcome).value, *write_repair_notes(compiled.repairs)]
        notes += [f"subgoal {i + 1}: {format_ltl(f)}" for i, f in enumerate(compiled.subgoals)]
        if outcome.end != "complete":
            notes.append(f"the search was ended: {outcome.end}")
        error = find_branch_error(branch, self.domain, self.task.scene)
        steps = report_steps(self.task, self.domain, branch.trajectory)
        if error is not None and error.step is not None:
            why = error.detail
            if steps and steps[-1].outcome == error.kind.value:
                why = steps[-1].reason
            notes.append(f"subgoal {error.step + 1} fails: {error.kind.value}, {why}")
            named = find_object_names(
                self.lexicon.replace_lexicon_names_by_domain_names(compiled.subgoals[error.step])
            )
            if error.kind is FaultKind.AFFORDANCE and not {*error.objects} <= {*named}:
                notes.append(f"subgoal {error.step + 1} leaves open which object: only the task's were tried")
        if best is not branch:
            notes.append("the goals are those of another way to carry out the subgoals, which reaches more")
        return VerdictExplanation(
            tuple(notes),
            steps,
            report_goals(self.task, self._test_goals(best), best.trajectory),
            report_goal_parts(self.temporal_goal, branch.trajectory),
        )

    def _explain_rejection(
        self, verdict: SubgoalVerdict, rejected: RejectedAnswer, repairs: Sequence[str]
    ) -> VerdictExplanation:
        wrong = [
            f"subgoal {n + 1}, {misuse.primitive}: {misuse.detail}" for n, misuse in rejected.misused_names
        ]
        if not wrong:
            error = rejected.error
            wrong = [error.detail if error.step is None else f"subgoal {error.step + 1}: {error.detail}"]
        return VerdictExplanation(
            (rejected.category.value, *write_repair_notes(repairs), *wrong),
            goals=report_goals(self.task, verdict.goals_satisfied),
        )


def _count_actions_beyond_one_per_subgoal(branch: SubgoalExecutionBranch) -> int:
    return len(list_operators_of_executed_actions(branch)) - branch.refined


def list_operators_of_executed_actions(branch: SubgoalExecutionBranch) -> Sequence[str]:
    """Return the operators of the executed actions of a branch (one execution of the subgoals), in order."""
    return [step.action.operator for step in branch.steps if step.fault is None]
