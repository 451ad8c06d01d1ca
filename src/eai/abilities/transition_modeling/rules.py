"""Rules for judging the operators of an answer. One set of such rules follows the paper.

Each operator that the task asks for counts. If an operator is missing, all its clauses are missed. If its
precondition or effect is unreadable, the clauses of this part are missed. The planner gets exactly the
operators of the answer that the task asks for. Missing operators are not filled in, and operators that the
task does not ask for are left out and reported. An operator with undefined names is an input error, as in any
current planner. A plan succeeds only if it also works with the gold operators. Without this rule, operators
with arbitrary effects would have a plan for every goal.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal, TypeAlias

from eai.abilities.transition_modeling.extraction import (
    OperatorCache,
    ResultCache,
    WrittenOperator,
    read_operators,
)
from eai.abilities.transition_modeling.verdict import OperatorComparisonStatus, OperatorReport
from eai.abilities.verdict import AnswerSpan, ConfusionCounts, ErrorReport, Unreadable, sum_confusion_counts
from eai.pddl.check import PddlDeclarations, PddlFinding, check_action
from eai.pddl.execute import PddlPlanExecutor, PlanStep
from eai.pddl.matching import ComparisonWithGoldOperator, mark_all_clauses_missing, match_operators
from eai.pddl.model import PddlAction
from eai.pddl.planning import (
    PddlPlanner,
    PlannerOutcome,
    PlannerResult,
    PlanningTask,
    make_input_error_result,
)
from eai.tasks.operator_task import TransitionTask
from eai.tasks.task import TaskExclusion
from eai.world.fault import FaultKind


def find_plan_flaw(
    task: TransitionTask, written: Mapping[str, PddlAction], plan: Sequence[PlanStep]
) -> tuple[int, str] | None:
    """Return why a plan fails with the gold operators, or None if it reaches the goal.

    A planner has found the plan with the answer's operators. Each step is executed with the gold operator of
    the same name. The parameters of an operator correspond to the gold operator's parameters of the same
    names. If the answer lacks the name of a gold parameter, parameters correspond by position. A step with
    another number of objects then cannot be executed.

    Args:
        task: the task, which asks for the operators of the plan.
        written: mapping from names to the answer's operators.
        plan: the plan.

    Returns:
        A pair: the number of the step that fails, from 0, and the reason. If the plan only misses the goal,
            the number is that after the last step.
    """
    domain = replace(task.domain.header, actions=tuple(task.gold_operators.values()))
    return PddlPlanExecutor(domain, task.problem).find_failed_step(
        convert_to_gold_operator_steps(task, written, plan)
    )


def convert_to_gold_operator_steps(
    task: TransitionTask, answer_operators: Mapping[str, PddlAction], plan: Sequence[PlanStep]
) -> list[PlanStep]:
    """Return the steps of a plan for an answer's operators as steps of the gold operators.

    Objects go to the parameters with the same names. If a gold operator has a parameter whose name the
    answer's operator lacks, the objects of the step keep their order instead.
    """
    return [
        _convert_to_gold_operator_step(step, answer_operators[step.action], task.gold_operators[step.action])
        for step in plan
    ]


def _convert_to_gold_operator_step(step: PlanStep, written: PddlAction, gold: PddlAction) -> PlanStep:
    objects = {
        parameter.name: name for parameter, name in zip(written.parameters, step.arguments, strict=True)
    }
    wanted = [parameter.name for parameter in gold.parameters]
    has_all = objects.keys() >= set(wanted)
    return PlanStep(gold.name, tuple([objects[name] for name in wanted]) if has_all else step.arguments)


NOT_RUN = PlannerResult(PlannerOutcome.NOT_RUN)
"""Result of planning if no planner is used."""

NO_OPERATORS = PlannerResult(PlannerOutcome.INPUT_ERROR, detail="the answer holds no operator")
"""Result of planning if the answer has no operator that the planner could use."""


@dataclass(frozen=True, slots=True)
class OperatorJudgement:
    """The comparison of an answer's operators with the gold operators, and the result of planning.

    Attributes:
        operators: reports on the operators of the task and the answer.
        literals: mapping from sides (precondition or effect) to the numbers of matched, additional and
            missing literals; None if the rules do not count literals.
        planning: result of the planner.
        plan_works: whether the planner's plan works with the gold operators; None if the rules do not test
            this.
        plan_flaw: number of the step at which the plan fails, and the reason; None without a failed plan.
        repairs: names of the repairs that were needed to read the answer.
        spans: parts of the answer's text, and how each was treated.
        operator_repairs: mapping from names of repaired operators to the names of the repairs.
        matches: comparison of each operator of the task with its gold operator; empty if the rules compare in
            another way.
        error: the reason why the answer cannot be read, or None.
        excluded: the reason why statistics leave the answer out, or None. Only rules that follow a published
            package leave answers out.
    """

    operators: tuple[OperatorReport, ...]
    planning: PlannerResult
    plan_works: bool | None = None
    plan_flaw: tuple[int, str] | None = None
    literals: Mapping[str, ConfusionCounts] | None = None
    repairs: tuple[str, ...] = ()
    spans: tuple[AnswerSpan, ...] = ()
    operator_repairs: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    matches: Mapping[str, ComparisonWithGoldOperator] = field(default_factory=dict)
    error: ErrorReport | None = None
    excluded: TaskExclusion | None = None


def _solve_if_planning_task(
    planner: PddlPlanner, task_or_result: PlanningTask | PlannerResult
) -> PlannerResult:
    return task_or_result if isinstance(task_or_result, PlannerResult) else planner.solve(task_or_result)


ReplacedPart: TypeAlias = Literal["operator", "precondition", "effect"]
"""The part of a gold operator that the answer's operator replaces, for a test of the answer's operator.

If only precondition or effect is replaced, the gold operator keeps its parameters. If the answer names its
parameters differently, the answer's part then has variables that are not parameters.
"""


@dataclass(frozen=True, slots=True)
class OperatorScoringRules(ABC):
    """Rules for reading the operators of answers, comparing them with gold operators, and planning with them.

    Answers to one problem often have the same operators, so results of the planner are cached.

    Attributes:
        planner: the planner that tests operators; None if no planner is used.
        results: cached results of the planner.
        counts_clauses: whether the clauses of operators are compared; False if only the predicates in clauses
            are compared.
    """

    planner: PddlPlanner | None
    results: ResultCache[Hashable, PlannerResult] = field(default_factory=ResultCache)
    counts_clauses: ClassVar[bool] = True

    @abstractmethod
    def judge_answer(self, task: TransitionTask, text: str) -> OperatorJudgement:
        """Return the judgement on an answer, even if the answer cannot be read."""

    @abstractmethod
    def judge_missing_answer(self, task: TransitionTask) -> OperatorJudgement:
        """Return the judgement on a missing answer: each operator of the task is missing."""

    @abstractmethod
    def plan_with_each_operator_of_answer(
        self, task: TransitionTask, answer: str, replaced_part: ReplacedPart
    ) -> dict[str, PlannerResult | None]:
        """Plan once for each operator of the task, with the answer's operator in place of the gold operator.

        Return the planner's results by operator name. All other operators of a planning task are gold
        operators. The result is None for an operator that the answer lacks. The mapping is empty if the
        answer is excluded from all rates.
        """

    @property
    def result_for_answer_without_operators(self) -> PlannerResult:
        """The result of planning for an answer without operators."""
        return NOT_RUN if self.planner is None else NO_OPERATORS

    def plan_with_cache(
        self,
        cache_key: Hashable,
        cache_entry_length: int,
        make_task: Callable[[], PlanningTask | PlannerResult],
    ) -> PlannerResult:
        """Return the planner's result for a planning task, cached under a key.

        Args:
            cache_key: the content of domain and problem.
            cache_entry_length: number of characters of the operators, which counts towards the size of the
                cache.
            make_task: makes the planning task, or returns a result that needs no planner.
        """
        planner = self.planner
        if planner is None:
            return NOT_RUN
        return self.results.get_or_compute(
            cache_key, cache_entry_length, lambda: _solve_if_planning_task(planner, make_task())
        )


_ReadOperator: TypeAlias = tuple[PddlAction | None, tuple[PddlFinding, ...]]
"""A pair: the readable parts of an operator (None if a part is unreadable), and the operator's defects."""


_OperatorComparison: TypeAlias = tuple[OperatorReport, ComparisonWithGoldOperator]
"""A pair: the report on an operator of the task, and the operator's comparison with the gold operator."""


@dataclass(frozen=True, slots=True)
class PaperOperatorScoringRules(OperatorScoringRules):
    """The rules of the paper for one domain. Caches ensure that equal operators are read and compared once.

    Attributes:
        readings: cache of operators that were read.
        compared: cache of comparisons of operators with gold operators.
    """

    readings: OperatorCache = field(default_factory=ResultCache)
    compared: ResultCache[tuple[_ReadOperator | None, str], _OperatorComparison] = field(
        default_factory=ResultCache
    )

    def judge_answer(self, task: TransitionTask, text: str) -> OperatorJudgement:
        """Return the judgement on an answer. An answer without operators misses all operators of the task."""
        written = read_operators(text, self.readings)
        if isinstance(written, Unreadable):
            error = ErrorReport(FaultKind.PARSING, None, written.reason)
            return replace(self.judge_missing_answer(task), error=error, spans=written.spans)
        by_name = written.value
        compared = [self._compare_with_gold(task, name, by_name.get(name)) for name in task.operators]
        reports = tuple([report for report, _ in compared])
        others = tuple(
            OperatorReport(
                name,
                OperatorComparisonStatus.HALLUCINATED,
                offences=self._find_operator_defects(task, operator),
            )
            for name, operator in by_name.items()
            if name not in task.operators
        )
        planning = self._plan_with_all_operators(task, by_name, reports)
        solved = planning.outcome is PlannerOutcome.SOLVED
        unplanned = planning.outcome is PlannerOutcome.NOT_RUN
        actions = {
            name: written_operator.action
            for name, written_operator in by_name.items()
            if written_operator.action is not None
        }
        flaw = find_plan_flaw(task, actions, planning.plan) if solved else None
        return OperatorJudgement(
            operators=(*reports, *others),
            planning=planning,
            plan_works=None if unplanned else solved and flaw is None,
            plan_flaw=flaw,
            literals=_sum_literal_counts(compared),
            repairs=written.repairs,
            spans=written.spans,
            operator_repairs={
                name: operator.repairs for name, operator in by_name.items() if operator.repairs
            },
            matches={report.name: match for report, match in compared},
        )

    def judge_missing_answer(self, task: TransitionTask) -> OperatorJudgement:
        """Return the judgement on a missing answer: each operator of the task is missing."""
        compared = [self._compare_with_gold(task, name, None) for name in task.operators]
        missing = tuple([report for report, _ in compared])
        planning = self.result_for_answer_without_operators
        works = None if planning.outcome is PlannerOutcome.NOT_RUN else False
        return OperatorJudgement(missing, planning, works, literals=_sum_literal_counts(compared))

    def plan_with_each_operator_of_answer(
        self, task: TransitionTask, answer: str, replaced_part: ReplacedPart
    ) -> dict[str, PlannerResult | None]:
        """Plan once for each operator of the task, with the answer's operator in place of the gold operator.

        Return the planner's results by operator name. All other operators of a planning task are gold
        operators. The result is None for an operator that the answer lacks. The mapping is empty if the
        answer is excluded from all rates.
        """
        written = read_operators(answer, self.readings)
        by_name = {} if isinstance(written, Unreadable) else written.value
        return {
            name: self._plan_with_written_operator(
                task,
                _insert_written_part_into_gold_operator(
                    by_name[name], task.gold_operators[name], replaced_part
                ),
            )
            if name in by_name
            else None
            for name in task.operators
        }

    def _plan_with_written_operator(
        self, task: TransitionTask, written_operator: WrittenOperator
    ) -> PlannerResult:
        actions = [
            written_operator.action if name == written_operator.name else gold
            for name, gold in task.gold_operators.items()
        ]
        readable = tuple(action for action in actions if action is not None)
        return self._plan_with_answer_actions(
            task, readable, self._find_operator_defects(task, written_operator), written_operator.size
        )

    def _compare_with_gold(
        self, task: TransitionTask, operator_name: str, written: WrittenOperator | None
    ) -> _OperatorComparison:
        read, size = (None, 0) if written is None else ((written.action, written.unread), written.size)
        return self.compared.get_or_compute(
            (read, operator_name), size, lambda: _compare_read_operator_with_gold(task, operator_name, read)
        )

    def _find_operator_defects(
        self, task: TransitionTask, written: WrittenOperator
    ) -> tuple[PddlFinding, ...]:
        action = written.action
        if action is None:
            return written.unread
        return (*written.unread, *_find_pddl_violations(task, action))

    def _plan_with_all_operators(
        self,
        task: TransitionTask,
        written: Mapping[str, WrittenOperator],
        reports: tuple[OperatorReport, ...],
    ) -> PlannerResult:
        operators = [written[name] for name in task.operators if name in written]
        actions = tuple(operator.action for operator in operators if operator.action is not None)
        findings = tuple(finding for report in reports for finding in report.offences)
        return self._plan_with_answer_actions(
            task, actions, findings, sum(operator.size for operator in operators)
        )

    def _plan_with_answer_actions(
        self,
        task: TransitionTask,
        actions: tuple[PddlAction, ...],
        operator_defects: tuple[PddlFinding, ...],
        text_length: int,
    ) -> PlannerResult:
        refusals = tuple(
            finding for finding in operator_defects if finding.offence.makes_planners_refuse_domain
        )
        key = (task.problem_text, actions, refusals)
        return self.plan_with_cache(
            key, text_length, lambda: _make_planning_task_or_error_result(task, actions, refusals)
        )


def _compare_read_operator_with_gold(
    task: TransitionTask, operator_name: str, read_operator: _ReadOperator | None
) -> _OperatorComparison:
    gold = task.gold_operators[operator_name]
    action, findings = read_operator or (None, ())
    if action is not None:
        status, match = OperatorComparisonStatus.COMPARED, match_operators(action, gold)
        findings = (*findings, *_find_pddl_violations(task, action))
    else:
        status = (
            OperatorComparisonStatus.MISSING if read_operator is None else OperatorComparisonStatus.UNREADABLE
        )
        match = mark_all_clauses_missing(gold)
    return OperatorReport(operator_name, status, match.precondition, match.effect, findings), match


def _find_pddl_violations(task: TransitionTask, action: PddlAction) -> tuple[PddlFinding, ...]:
    return check_action(action, PddlDeclarations.from_domain(task.domain.header))


def _insert_written_part_into_gold_operator(
    written: WrittenOperator, gold: PddlAction, replaced_part: ReplacedPart
) -> WrittenOperator:
    written_action = written.action
    if replaced_part == "operator" or written_action is None:
        return written
    if replaced_part == "precondition":
        action = replace(gold, precondition=written_action.precondition)
    else:
        action = replace(gold, effect=written_action.effect)
    unread = tuple(
        finding for finding in written.unread if finding.place == f"{replaced_part} of {written.name}"
    )
    return replace(written, action=action, unread=unread)


def _sum_literal_counts(compared: Sequence[_OperatorComparison]) -> dict[str, ConfusionCounts]:
    return {
        "precondition": sum_confusion_counts(
            [ConfusionCounts(*match.precondition_literals) for _, match in compared]
        ),
        "effect": sum_confusion_counts([ConfusionCounts(*match.effect_literals) for _, match in compared]),
    }


def _make_planning_task_or_error_result(
    task: TransitionTask, actions: tuple[PddlAction, ...], preventing_findings: tuple[PddlFinding, ...]
) -> PlanningTask | PlannerResult:
    if preventing_findings:
        return make_input_error_result(preventing_findings[0])
    return PlanningTask(replace(task.domain.header, actions=actions), task.problem)
