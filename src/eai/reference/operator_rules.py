"""The rules of eai-eval 1.0.5 (protocol ``eai-1.0.5``).

Besides the quirks of `operator_extraction` and `operator_matching`: operators that are asked for
and not written are neither counted nor missed by the planner, which gets the gold ones in their place and
all other operators of the domain besides (``complete_pddl_domain``); hallucinated operators take part in
planning; predicates without a category are not counted; the planner is that of `planner_of_2024`. Where the
reference would raise a KeyError and lose the run (a matched predicate without a category), the predicate is
ignored.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

from eai.abilities.transition_modeling.judgement import NOT_RUN, UNREADABLE, Judgement, PlanMemory, Replaced
from eai.abilities.transition_modeling.memory import Memory
from eai.abilities.transition_modeling.report import OperatorReport, OperatorStatus
from eai.abilities.transition_modeling.task import TransitionTask
from eai.pddl.match import SideMatch
from eai.pddl.model import PddlAction
from eai.pddl.offence import PddlFinding
from eai.pddl.operator_text import OperatorText
from eai.pddl.planning import PddlPlanner, PlannerResult, PlanningTask, refusal
from eai.reference.operator_extraction import extract_as_reference
from eai.reference.operator_matching import compare_as_reference
from eai.reference.planner_of_2024 import Dropped, normalise, read_operator

FORMAT_ERROR = "the reference leaves out answers that it cannot search for operators"


@dataclass(frozen=True, slots=True)
class ReferenceRules:
    """The rules with what they remember about one domain: equal texts are compared and read once."""

    plans: PlanMemory
    reports: Memory[OperatorText, OperatorReport] = field(default_factory=Memory)
    read: Memory[OperatorText, PddlAction | Dropped | PddlFinding] = field(default_factory=Memory)
    counts_clauses: bool = False

    @classmethod
    def with_planner(cls, planner: PddlPlanner | None) -> ReferenceRules:
        """Fresh rules."""
        return cls(PlanMemory(planner))

    def judge(self, task: TransitionTask, text: str) -> Judgement:
        """The judgement on an answer; the reference leaves out those with its format error."""
        written = extract_as_reference(text)
        if written is None:
            return Judgement((), NOT_RUN, error=UNREADABLE, excluded=FORMAT_ERROR)
        return Judgement(
            operators=tuple(self._report(task, operator) for operator in written),
            planning=self._plan(task, written),
        )

    def unanswered(self, task: TransitionTask) -> Judgement:
        """All that is asked for is missing: gold operators fill the gaps of an answer, they are none."""
        return Judgement(
            tuple(self._missing(task, name) for name in task.operators), self.plans.without_operators
        )

    def _missing(self, task: TransitionTask, name: str) -> OperatorReport:
        gold = task.domain.operators[name]
        precondition, effect = _compare("()", gold.precondition), _compare("()", gold.effect)
        return OperatorReport(name, OperatorStatus.MISSING, precondition, effect)

    def plan_one_at_a_time(
        self, task: TransitionTask, text: str, replaced: Replaced
    ) -> dict[str, PlannerResult | None]:
        """What comes of each operator that is asked for, among all gold operators.

        The reference counts one that is not written as a failure, and passes over answers with its format
        error (``evaluate_results_sequential``); it counts, but never fills, ``task_variate_control_precond``.
        """
        written = extract_as_reference(text)
        if written is None:
            return {}
        gold = task.domain.operators
        tried = {each.name: _mixed(each, gold[each.name], replaced) for each in written if each.name in gold}
        return {name: self._plan(task, (tried[name],)) if name in tried else None for name in task.operators}

    def _report(self, task: TransitionTask, operator: OperatorText) -> OperatorReport:
        if operator.name not in task.operators:
            return OperatorReport(operator.name, OperatorStatus.HALLUCINATED)
        gold = task.domain.operators[operator.name]
        return self.reports.recall(operator, operator.size, lambda: _compared(operator, gold))

    def _plan(self, task: TransitionTask, written: tuple[OperatorText, ...]) -> PlannerResult:
        if self.plans.planner is None:
            return NOT_RUN
        names = {operator.name for operator in written}
        gold = (operator for name, operator in task.domain.operators.items() if name not in names)
        operators = tuple(sorted((*written, *gold), key=lambda operator: operator.name))
        key, size = (task.problem_text, operators), sum(operator.size for operator in written)
        return self.plans.solve(key, size, lambda: self._planning(task, operators))

    def _planning(
        self, task: TransitionTask, operators: tuple[OperatorText, ...]
    ) -> PlanningTask | PlannerResult:
        actions = []
        for operator in operators:
            reading = self.read.recall(
                operator, operator.size, partial(read_operator, operator, task.domain.header)
            )
            if isinstance(reading, PddlFinding):
                return refusal(reading)
            if isinstance(reading, PddlAction):
                actions.append(reading)
        return normalise(task.domain.header, actions, task.problem)


def _compared(operator: OperatorText, gold: OperatorText) -> OperatorReport:
    return OperatorReport(
        operator.name,
        OperatorStatus.COMPARED,
        _compare(operator.precondition, gold.precondition),
        _compare(operator.effect, gold.effect),
    )


def _mixed(written: OperatorText, gold: OperatorText, replaced: Replaced) -> OperatorText:
    match replaced:
        case Replaced.PRECONDITION:
            return replace(gold, precondition=written.precondition)
        case Replaced.EFFECT:
            return replace(gold, effect=written.effect)
        case _:
            return written


def _compare(predicted: str, gold: str) -> SideMatch:
    sets = compare_as_reference(predicted, gold)
    return SideMatch(*(tuple(sorted(names)) for names in (sets.matched, sets.additional, sets.missing)))
