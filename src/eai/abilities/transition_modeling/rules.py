"""How operators are judged: what rules say of an answer, and the rules of the paper.

Every operator that is asked for counts: one that is missing misses all its clauses, and a side that cannot be
read misses its own.
The planner gets the operators that are asked for, as the answer has them, and nothing else: what the answer
lacks is not filled in, and what was not asked for is left out (and reported). An operator that uses
undefined names is an input error of the answer, as any current planner has it. A plan succeeds if it works
with the gold operators: operators that promise everything have a plan for everything.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal, TypeAlias

from eai.abilities.transition_modeling.extraction import OperatorCache, ResultCache, WrittenOperator, extract
from eai.abilities.transition_modeling.verdict import OperatorReport, OperatorStatus
from eai.abilities.verdict import Confusion, ErrorReport, Span, Unreadable, add_confusions
from eai.pddl.check import Declarations, PddlFinding, check_action
from eai.pddl.execute import Executor, PlanStep
from eai.pddl.matching import OperatorMatch, match_operators, missing_operator
from eai.pddl.model import PddlAction
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlannerResult, PlanningTask, refusal
from eai.tasks.operator_task import TransitionTask
from eai.tasks.task import TaskExclusion
from eai.world.fault import FaultKind


def plan_flaw(
    task: TransitionTask, written: Mapping[str, PddlAction], plan: Sequence[PlanStep]
) -> tuple[int, str] | None:
    """Why the gold operators cannot execute a plan from the start of the task to its goal; None if they can.

    Each parameter of a gold operator stands for the object that the step has for the parameter of that name;
    where the answer does not use all of the names, parameters correspond by position, and a step with
    another number of objects cannot be executed.

    Args:
        task: the task, which asks for the operators of the plan.
        written: the answer's operators by name.
        plan: the plan.
    """
    domain = replace(task.domain.header, actions=tuple(task.gold.values()))
    return Executor(domain, task.problem).flaw(to_gold_steps(task, written, plan))


def to_gold_steps(
    task: TransitionTask, written: Mapping[str, PddlAction], plan: Sequence[PlanStep]
) -> list[PlanStep]:
    """Return the steps of a plan as steps of gold operators, with parameters paired as by `plan_flaw`."""
    return [_to_gold_step(step, written[step.action], task.gold[step.action]) for step in plan]


def _to_gold_step(step: PlanStep, written: PddlAction, gold: PddlAction) -> PlanStep:
    """A step as the gold operator takes it."""
    objects = {
        parameter.name: name for parameter, name in zip(written.parameters, step.arguments, strict=True)
    }
    wanted = [parameter.name for parameter in gold.parameters]
    known = objects.keys() >= set(wanted)
    return PlanStep(gold.name, tuple([objects[name] for name in wanted]) if known else step.arguments)


NOT_RUN = PlannerResult(PlannerOutcome.NOT_RUN)
"""The result where no planner is asked."""

NO_OPERATORS = PlannerResult(PlannerOutcome.INPUT_ERROR, detail="the answer holds no operator")
"""The result where there is nothing to plan with."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """The operators of an answer compared with the gold ones, and what a planner can do with them.

    Attributes:
        operators: those that are asked for or written.
        literals: literals matched, additional and missing, by side; None where the rules do not count them.
        planning: what the planner made of them.
        plan_works: whether its plan works with the gold operators; None where the rules do not ask.
        plan_flaw: the step at which it does not, and why; None if it does, or there is no plan.
        repairs: the names of the repairs that reading made.
        spans: what became of the parts of the answer's text.
        repaired: those of them that were made of single operators, by operator.
        matches: how the operators that are asked for compare with the gold ones; none where rules do not say.
        error: why nothing could be read, or None.
        excluded: why the answer is left out of all statistics, as a published package does it; else None.
    """

    operators: tuple[OperatorReport, ...]
    planning: PlannerResult
    plan_works: bool | None = None
    plan_flaw: tuple[int, str] | None = None
    literals: Mapping[str, Confusion] | None = None
    repairs: tuple[str, ...] = ()
    spans: tuple[Span, ...] = ()
    operator_repairs: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    matches: Mapping[str, OperatorMatch] = field(default_factory=dict)
    error: ErrorReport | None = None
    excluded: TaskExclusion | None = None


def _solve_if_needed(planner: PddlPlanner, task: PlanningTask | PlannerResult) -> PlannerResult:
    return task if isinstance(task, PlannerResult) else planner.solve(task)


ReplacedPart: TypeAlias = Literal["operator", "precondition", "effect"]
"""The part of a gold operator that the answer's replaces, where one operator is tried among gold ones.

With one side alone the parameters stay the gold ones, so that an answer that calls them otherwise has unbound
variables.
"""


@dataclass(frozen=True, slots=True)
class MatchingRules(ABC):
    """How answers are read, compared and planned with.

    Answers to one problem are often the same operators in other words or the same words, so that what the
    planner finds is remembered.

    Attributes:
        planner: judges operators; None if no planner is asked.
        results: what it found.
        counts_clauses: whether operators are compared clause by clause; else what is compared are predicates.
    """

    planner: PddlPlanner | None
    results: ResultCache[Hashable, PlannerResult] = field(default_factory=ResultCache)
    counts_clauses: ClassVar[bool] = True

    @abstractmethod
    def judge(self, task: TransitionTask, text: str) -> Judgement:
        """The judgement on an answer, also on one that cannot be read."""

    @abstractmethod
    def judge_missing_answer(self, task: TransitionTask) -> Judgement:
        """The judgement where there is no answer: every operator that is asked for is missing."""

    @abstractmethod
    def plan_one_at_a_time(
        self, task: TransitionTask, text: str, replaced: ReplacedPart
    ) -> dict[str, PlannerResult | None]:
        """The result of each operator that is asked for among gold operators, by name.

        An operator that the answer does not have has none. Empty for an answer that the rules leave out.
        """

    @property
    def empty_result(self) -> PlannerResult:
        """The result of an answer without operators."""
        return NOT_RUN if self.planner is None else NO_OPERATORS

    def solve(
        self, key: Hashable, size: int, make: Callable[[], PlanningTask | PlannerResult]
    ) -> PlannerResult:
        """The remembered result for a key, or that of what ``make`` makes: a task, or a foregone result.

        Args:
            key: the content of domain and problem.
            size: how many characters its operators take.
            make: makes what is to be solved.
        """
        planner = self.planner
        if planner is None:
            return NOT_RUN
        return self.results.get_or_compute(key, size, lambda: _solve_if_needed(planner, make()))


_ReadOperator: TypeAlias = tuple[PddlAction | None, tuple[PddlFinding, ...]]
"""An operator as far as it can be read, and what is wrong with the rest."""


_OperatorComparison: TypeAlias = tuple[OperatorReport, OperatorMatch]
"""The report on an operator that is asked for, and how it compares with the gold one."""


@dataclass(frozen=True, slots=True)
class PaperRules(MatchingRules):
    """The rules of the paper with what they remember about one domain: equal operators are compared once."""

    readings: OperatorCache = field(default_factory=ResultCache)
    compared: ResultCache[tuple[_ReadOperator | None, str], _OperatorComparison] = field(
        default_factory=ResultCache
    )

    def judge(self, task: TransitionTask, text: str) -> Judgement:
        """The judgement on an answer; one without any operator misses all that are asked for."""
        written = extract(text, self.readings)
        if isinstance(written, Unreadable):
            error = ErrorReport(FaultKind.PARSING, None, written.reason)
            return replace(self.judge_missing_answer(task), error=error, spans=written.spans)
        by_name = written.value
        compared = [self._compare(task, name, by_name.get(name)) for name in task.operators]
        asked = tuple([report for report, _ in compared])
        others = tuple(
            OperatorReport(name, OperatorStatus.HALLUCINATED, offences=self._findings(task, operator))
            for name, operator in by_name.items()
            if name not in task.operators
        )
        planning = self._plan(task, by_name, asked)
        solved = planning.outcome is PlannerOutcome.SOLVED
        unplanned = planning.outcome is PlannerOutcome.NOT_RUN
        actions = {name: each.action for name, each in by_name.items() if each.action is not None}
        flaw = plan_flaw(task, actions, planning.plan) if solved else None
        return Judgement(
            operators=(*asked, *others),
            planning=planning,
            plan_works=None if unplanned else solved and flaw is None,
            plan_flaw=flaw,
            literals=_sum_literals(compared),
            repairs=written.repairs,
            spans=written.spans,
            operator_repairs={
                name: operator.repairs for name, operator in by_name.items() if operator.repairs
            },
            matches={report.name: match for report, match in compared},
        )

    def judge_missing_answer(self, task: TransitionTask) -> Judgement:
        """The judgement where there is no answer: all that is asked for is missing."""
        compared = [self._compare(task, name, None) for name in task.operators]
        missing = tuple([report for report, _ in compared])
        planning = self.empty_result
        works = None if planning.outcome is PlannerOutcome.NOT_RUN else False
        return Judgement(missing, planning, works, literals=_sum_literals(compared))

    def plan_one_at_a_time(
        self, task: TransitionTask, text: str, replaced: ReplacedPart
    ) -> dict[str, PlannerResult | None]:
        """The result of each operator that is asked for, among the other gold ones that are asked for."""
        written = extract(text, self.readings)
        by_name = {} if isinstance(written, Unreadable) else written.value
        return {
            name: self._plan_with(task, _replace_part(by_name[name], task.gold[name], replaced))
            if name in by_name
            else None
            for name in task.operators
        }

    def _plan_with(self, task: TransitionTask, tried: WrittenOperator) -> PlannerResult:
        actions = [tried.action if name == tried.name else gold for name, gold in task.gold.items()]
        readable = tuple(each for each in actions if each is not None)
        return self._solve(task, readable, self._findings(task, tried), tried.size)

    def _compare(
        self, task: TransitionTask, name: str, written: WrittenOperator | None
    ) -> _OperatorComparison:
        read, size = (None, 0) if written is None else ((written.action, written.unread), written.size)
        return self.compared.get_or_compute((read, name), size, lambda: _compare_operator(task, name, read))

    def _findings(self, task: TransitionTask, written: WrittenOperator) -> tuple[PddlFinding, ...]:
        action = written.action
        if action is None:
            return written.unread
        return (*written.unread, *_check_operator(task, action))

    def _plan(
        self,
        task: TransitionTask,
        written: Mapping[str, WrittenOperator],
        reports: tuple[OperatorReport, ...],
    ) -> PlannerResult:
        asked = [written[name] for name in task.operators if name in written]
        actions = tuple(each.action for each in asked if each.action is not None)
        findings = tuple(finding for report in reports for finding in report.offences)
        return self._solve(task, actions, findings, sum(each.size for each in asked))

    def _solve(
        self,
        task: TransitionTask,
        actions: tuple[PddlAction, ...],
        findings: tuple[PddlFinding, ...],
        size: int,
    ) -> PlannerResult:
        refusals = tuple(finding for finding in findings if finding.offence.stops_planner)
        key = (task.problem_text, actions, refusals)
        return self.solve(key, size, lambda: _make_planning_task(task, actions, refusals))


def _compare_operator(task: TransitionTask, name: str, read: _ReadOperator | None) -> _OperatorComparison:
    gold = task.gold[name]
    action, findings = read or (None, ())
    if action is not None:
        status, match = OperatorStatus.COMPARED, match_operators(action, gold)
        findings = (*findings, *_check_operator(task, action))
    else:
        status = OperatorStatus.MISSING if read is None else OperatorStatus.UNREADABLE
        match = missing_operator(gold)
    return OperatorReport(name, status, match.precondition, match.effect, findings), match


def _check_operator(task: TransitionTask, action: PddlAction) -> tuple[PddlFinding, ...]:
    """The offences of an operator, whatever the gold one."""
    return check_action(action, Declarations.of(task.domain.header))


def _replace_part(written: WrittenOperator, gold: PddlAction, replaced: ReplacedPart) -> WrittenOperator:
    """An operator of an answer, of which only what is to replace the gold one's is its own."""
    own = written.action
    if replaced == "operator" or own is None:
        return written
    if replaced == "precondition":
        action = replace(gold, precondition=own.precondition)
    else:
        action = replace(gold, effect=own.effect)
    unread = tuple(each for each in written.unread if each.place == f"{replaced} of {written.name}")
    return replace(written, action=action, unread=unread)


def _sum_literals(compared: Sequence[_OperatorComparison]) -> dict[str, Confusion]:
    """The literals of several operators together, by side."""
    return {
        "precondition": add_confusions([Confusion(*match.precondition_literals) for _, match in compared]),
        "effect": add_confusions([Confusion(*match.effect_literals) for _, match in compared]),
    }


def _make_planning_task(
    task: TransitionTask, actions: tuple[PddlAction, ...], refusals: tuple[PddlFinding, ...]
) -> PlanningTask | PlannerResult:
    """The planning task, or what is wrong with the answer's operators."""
    if refusals:
        return refusal(refusals[0])
    return PlanningTask(replace(task.domain.header, actions=actions), task.problem)
