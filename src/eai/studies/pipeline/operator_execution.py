"""Test a model's operators: plan with them, execute the plan in the world, and find the stage that fails.

The plan is translated to actions of the world, and scored as an answer to action sequencing. The planner's
problems leave out some goals and preconditions of the world. So even the data set's own operators can fail.
They are tested too, for comparison.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TypeAlias

from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.transition_modeling.extraction import OperatorCache, ResultCache, read_operators
from eai.abilities.transition_modeling.rules import convert_to_gold_operator_steps
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import PlanVerdict, Unreadable, make_rate_contribution_of_answer
from eai.base.errors import InputError
from eai.benchmarks.gold_answers import AnswersByTask, open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.execute import PlanStep
from eai.pddl.planning import PlannerOutcome
from eai.results.certainty import TaskRateContribution
from eai.results.lines import MODEL, SUITE
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.summary import find_task_name
from eai.results.table import Cell, Estimate, Row, Table, collect_rows_in_table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis
from eai.tasks.source import Source
from eai.tasks.task import GoalKind

OperatorTestOutcome: TypeAlias = tuple[str, str]
"""Outcome of an operator test: the stage that failed, and the reason.

An operator test plans with the operators of an answer, and executes the plan in the world. If the plan
succeeds, the stage is `NOWHERE` and the reason is empty. Otherwise, the reason is the planner's outcome, the
kind of error, or the kind of missed goals.
"""

OPERATORS, PLANNER, TRANSLATION = "operators", "planner", "translation"
EXECUTION, GOAL, NOWHERE = "execution", "goal", "nowhere"
_STAGES = (OPERATORS, PLANNER, TRANSLATION, EXECUTION, GOAL, NOWHERE)
"""Stages at which a test of operators can fail, in order; then `NOWHERE`, the value if no stage fails."""

SUCCESS: OperatorTestOutcome = (NOWHERE, "")
UNTRANSLATED: OperatorTestOutcome = (TRANSLATION, "no_action")
"""Outcome of a test of operators if a step of the planner's plan corresponds to no action of the world."""
ONLY_ACTIONS_MISSED: OperatorTestOutcome = (GOAL, "only_actions")
"""Outcome of a test of operators if the plan misses only action goals (actions that must be executed).

The planner is not given such goals.
"""
CONDITIONS_MISSED: OperatorTestOutcome = (GOAL, "conditions")


@dataclass(frozen=True, slots=True)
class _OperatorTesterByPlanExecution:
    """Tests operators in answers: executes the plans that a planner found with these operators.

    Attributes:
        operators: the suite of transition modeling, in which models write operators.
        plans: the suite of action sequencing, in which models write plans for the same tasks.
    """

    operators: Suite
    plans: Suite
    _true_answers: AnswersByTask
    _readings: OperatorCache = field(default_factory=ResultCache)

    @staticmethod
    def open_operator_tester(domain: str, source: Source) -> _OperatorTesterByPlanExecution:
        """Return a tester of operators in answers to a benchmark's tasks, under the default scoring rules."""
        benchmark, ability = find_benchmark(domain), Ability.TRANSITION_MODELING
        return _OperatorTesterByPlanExecution(
            open_suite(benchmark, ability, source=source),
            open_suite(benchmark, Ability.ACTION_SEQUENCING, source=source),
            open_gold_answers(benchmark, ability, source),
        )

    def find_failed_stage_and_reason(
        self, task_id: str, answer: str, verdict: OperatorVerdict
    ) -> OperatorTestOutcome | None:
        """Return the first stage at which an answer's operators fail, such as planning, and the reason.

        The result is None if the task is excluded, or if no planner was run to score the answer.

        Args:
            task_id: the task.
            answer: the answer to transition modeling.
            verdict: the verdict on the answer by the default scoring rules.

        Raises:
            InputError: the verdict has a plan with operators that the answer does not have.
        """
        outcome = verdict.planner
        if (
            verdict.excluded
            or outcome in (None, PlannerOutcome.NOT_RUN)
            or not self._has_action_sequencing_task(task_id)
        ):
            return None
        if verdict.error is not None:
            return (OPERATORS, verdict.error.kind.value)
        if outcome is PlannerOutcome.INPUT_ERROR:
            return (OPERATORS, outcome.value)
        if outcome is not None and outcome is not PlannerOutcome.SOLVED:
            return (PLANNER, outcome.value)
        plan = self.format_planner_plan_as_answer(task_id, answer, verdict)
        return UNTRANSLATED if plan is None else self._execute_plan_and_get_outcome(task_id, plan)

    def format_planner_plan_as_answer(
        self, task_id: str, operator_answer: str, verdict: OperatorVerdict
    ) -> str | None:
        """Return the planner's plan in a verdict as an answer to action sequencing, or None.

        The result is None if a step corresponds to no action, or if a step and its operator differ in the
        number of objects.

        Raises:
            InputError: the verdict has a plan with operators that the answer does not have.
        """
        scorer, written = self.operators.scorer(task_id), read_operators(operator_answer, self._readings)
        if not isinstance(scorer, TransitionModelingScorer):
            raise TypeError(f"{task_id}: expected a scorer of transition modeling, found {scorer}")
        by_name = {} if isinstance(written, Unreadable) else written.value
        actions = {name: item.action for name, item in by_name.items() if item.action is not None}
        plan = [PlanStep(name, tuple(objects)) for name, *objects in map(str.split, verdict.plan)]
        task, transition = self.plans.tasks[task_id], scorer.task
        if any(step.action not in actions or step.action not in transition.gold_operators for step in plan):
            raise InputError(
                f"task {task_id}: the plan in the record has operators that the answer "
                "lacks; score the answer again"
            )
        steps = convert_to_gold_operator_steps(transition, actions, plan)
        arities = [len(transition.gold_operators[step.action].parameters) for step in plan]
        if arities != [len(step.arguments) for step in steps]:
            return None
        meant = transition.actions_of(task, steps)
        notation = self.plans.benchmark.notation.plans
        return notation.join(notation.write(meant, task.scene)) if len(meant) == len(steps) else None

    def _has_action_sequencing_task(self, task_id: str) -> bool:
        """Whether the suite of action sequencing has the task and does not exclude the task."""
        plans = self.plans
        return task_id in plans.scorers and plans.scorer(task_id).find_exclusion() is None

    def _execute_plan_and_get_outcome(self, task_id: str, plan: str) -> OperatorTestOutcome:
        """Execute a translated plan in the world. Return success, the error, or the kind of missed goals."""
        verdict = self.plans.score(task_id, plan)
        if verdict.error is not None:
            return (EXECUTION, verdict.error.kind.value)
        if not isinstance(verdict, PlanVerdict):
            raise TypeError(f"{task_id}: expected a verdict on a plan (action sequencing), found {verdict}")
        if verdict.success:
            return SUCCESS
        goals = zip(self.plans.tasks[task_id].goals, verdict.goals_satisfied, strict=True)
        missed = {goal.kind for goal, is_reached in goals if not is_reached}
        return ONLY_ACTIONS_MISSED if missed == {GoalKind.ACTION} else CONDITIONS_MISSED

    def find_outcome_of_gold_operator_test(self, task_id: str) -> OperatorTestOutcome | None:
        """Return the outcome of planning with the data set's own operators and executing the plan.

        The result is None if the task is excluded, or if no planner was run.
        """
        suite = self.operators
        answer = self._true_answers[task_id].text
        return self.find_failed_stage_and_reason(
            task_id, answer, _require_operator_verdict(suite.score(task_id, answer))
        )


def _require_operator_verdict(verdict: object) -> OperatorVerdict:
    if not isinstance(verdict, OperatorVerdict):
        raise TypeError(f"expected a verdict on operators (transition modeling), found {verdict}")
    return verdict


@dataclass(frozen=True, slots=True)
class _RunWithOperatorTestOutcomes:
    """A run of transition modeling, with the outcome of the operator test of each answer.

    Attributes:
        key: model, protocol (scoring rules), domain and ability of the run.
        records: the stored verdicts on its answers, without excluded tasks.
        outcomes: for each record, the stage at which its operators failed, and why.
        gold_outcomes: for each record, the same for the data set's own operators; None if no planner was run.
    """

    key: RunKey
    records: Sequence[Record]
    outcomes: Sequence[OperatorTestOutcome]
    gold_outcomes: Sequence[OperatorTestOutcome | None]


def _test_operators_of_runs(
    runs: Sequence[Run], records: StudyRecords
) -> Iterator[_RunWithOperatorTestOutcomes]:
    """Yield runs of transition modeling, each with the stages at which its operators fail.

    Runs with other scoring rules than the default are left out, and the user gets a note.
    """
    tester_of = cache(
        lambda domain: _OperatorTesterByPlanExecution.open_operator_tester(domain, records.source)
    )
    gold_outcome_of = cache(
        lambda domain, task_id: tester_of(domain).find_outcome_of_gold_operator_test(task_id)
    )
    for run in sorted(runs, key=lambda run: run.key.sort_key):
        key = run.key
        if key.ability is not Ability.TRANSITION_MODELING:
            continue
        if key.protocol is not DEFAULT_PROTOCOL:
            records.note(f"left out, because operators are only executed under strict: {key}")
            continue
        tester = tester_of(key.domain)
        outcomes = [
            (
                record,
                tester.find_failed_stage_and_reason(
                    record.task_id, record.response, _require_operator_verdict(record.verdict)
                ),
            )
            for record in run.records
        ]
        planned = [(record, outcome) for record, outcome in outcomes if outcome is not None]
        if not planned:
            records.note(f"left out, because no planner was run: {key}")
            continue
        yield _RunWithOperatorTestOutcomes(
            key,
            [record for record, _ in planned],
            [outcome for _, outcome in planned],
            [gold_outcome_of(key.domain, record.task_id) for record, _ in planned],
        )


def analyze_operators(runs: Sequence[Run], records: StudyRecords) -> Iterator[Analysis]:
    """Yield one analysis of all runs of transition modeling, or nothing without such runs."""
    tested = list(_test_operators_of_runs(runs, records))
    if tested:
        table = _make_operators_table(tested)
        yield Analysis([table], screen_tables=[_replace_rates_by_counts(table)])


def _replace_rates_by_counts(table: Table) -> Table:
    """Return the table with counts, such as 3/20, instead of rates."""
    return replace(table, rows=tuple([tuple(map(_format_count_cell, row)) for row in table.rows]))


def _format_count_cell(cell: Cell) -> Cell:
    return f"{cell.numerator:g}/{cell.denominator:g}" if isinstance(cell, Estimate) else cell


@collect_rows_in_table("operators", (*SUITE, MODEL, "breaks at", "reason", "share", "true operators"))
def _make_operators_table(runs: Sequence[_RunWithOperatorTestOutcomes]) -> Iterator[Row]:
    """Tests of operators.

    A planner finds a plan with the model's operators, and the plan is executed in the world. Tasks are
    counted by the stage that fails, in percent. operators: they cannot be read or used for planning. planner:
    no plan is found. translation: a step of the plan is no action of the world. execution: an action fails.
    goal: not all goals are reached (only_actions: all missed goals are actions, which planning problems
    cannot state).
    nowhere: success. true operators: tasks with the data set's operators instead of the model's.
    """
    for run in runs:
        outcomes = {*run.outcomes, *[each for each in run.gold_outcomes if each is not None], SUCCESS}
        for outcome in sorted(outcomes, key=lambda outcome: (_STAGES.index(outcome[0]), outcome[1])):
            shares = [
                _estimate_share_of_outcome(run.records, side, outcome)
                for side in (run.outcomes, run.gold_outcomes)
            ]
            yield (*run.key.protocol_domain_ability_and_name, *outcome, *shares)


def _estimate_share_of_outcome(
    records: Sequence[Record], outcomes: Sequence[OperatorTestOutcome | None], outcome: OperatorTestOutcome
) -> Estimate:
    """Return the percentage of answers whose operator test has a given outcome."""
    cases = [
        TaskRateContribution(
            record.task_id, find_task_name(record), make_rate_contribution_of_answer(actual == outcome)
        )
        for record, actual in zip(records, outcomes, strict=True)
        if actual is not None
    ]
    return Estimate.from_task_rate_contributions(cases)
