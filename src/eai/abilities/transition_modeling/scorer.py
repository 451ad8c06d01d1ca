"""Transition modeling: from an answer's text to a verdict."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from eai.abilities.explanation import Explanation, StepReport
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.transition_modeling.counting import count_by_category
from eai.abilities.transition_modeling.judgement import Judgement, Rules
from eai.abilities.transition_modeling.report import OperatorReport, OperatorStatus
from eai.abilities.transition_modeling.strict_rules import StrictRules
from eai.abilities.transition_modeling.task import TransitionTask
from eai.abilities.verdict import Confusion, ErrorReport, OperatorVerdict
from eai.benchmarks.reference.operator_rules import ReferenceRules
from eai.pddl.matching import missing_operator
from eai.pddl.planning import PddlPlanner, PlannerOutcome
from eai.world.fault import FaultKind

FORMAT_ERROR = "the reference leaves out answers that it cannot search for operators"
UNREADABLE = 'expected JSON with a text under "output", or operators (:action ...)'


def rules_of(protocol: Protocol, planner: PddlPlanner | None) -> Rules:
    """The rules of a protocol, to be shared by all tasks of a domain: they remember what they have seen."""
    if protocol is Protocol.EAI_1_0_5:
        return ReferenceRules.with_planner(planner)
    return StrictRules.with_planner(planner)


class TransitionModeling(Scorer):
    """The scorer of one task; given a planner, all it says are pure functions of the answer.

    Args:
        task: the task.
        protocol: the protocol that the rules are of.
        rules: from `rules_of`.
    """

    def __init__(self, task: TransitionTask, protocol: Protocol, rules: Rules) -> None:
        self.task = task
        self.protocol = protocol
        self._rules = rules
        self._categories = tuple(category.value for category in task.categories)

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and its words; the steps are those of the plan that was found."""
        judgement = self._rules.judge(self.task, text)
        if judgement is None:
            return Assessment(self._unreadable(), partial(Explanation, (UNREADABLE,)))
        return Assessment(self._verdict(judgement), partial(_explained, judgement))

    def _verdict(self, judgement: Judgement) -> OperatorVerdict:
        return OperatorVerdict(
            success=_success(judgement.planning.outcome),
            counts=self._counts(judgement.operators),
            planner=judgement.planning.outcome,
            repairs=judgement.repairs,
            task_categories=self._categories,
            operators=judgement.operators,
            plan=tuple(str(step) for step in judgement.planning.plan),
            planner_detail=judgement.planning.detail,
        )

    def _unreadable(self) -> OperatorVerdict:
        error = ErrorReport(FaultKind.PARSING, None, UNREADABLE)
        if self.protocol is Protocol.EAI_1_0_5:
            return OperatorVerdict(excluded=FORMAT_ERROR, error=error, task_categories=self._categories)
        missing = [
            OperatorReport(name, OperatorStatus.MISSING, match.precondition, match.effect)
            for name, match in ((name, missing_operator(gold)) for name, gold in self.task.gold.items())
        ]
        outcome = PlannerOutcome.NOT_RUN if self._rules.plans.planner is None else PlannerOutcome.INPUT_ERROR
        return OperatorVerdict(
            success=_success(outcome),
            error=error,
            counts=self._counts(missing),
            planner=outcome,
            task_categories=self._categories,
            operators=tuple(missing),
        )

    def _counts(
        self, reports: tuple[OperatorReport, ...] | list[OperatorReport]
    ) -> dict[str, dict[str, Confusion]]:
        others, categories = self._rules.count_others, self.task.domain.categories
        return {
            "precondition": count_by_category(
                (r.precondition for r in reports), categories, count_others=others
            ),
            "effect": count_by_category((r.effect for r in reports), categories, count_others=others),
        }


def _success(outcome: PlannerOutcome) -> bool | None:
    return None if outcome is PlannerOutcome.NOT_RUN else outcome is PlannerOutcome.SOLVED


def _explained(judgement: Judgement) -> Explanation:
    steps = tuple(StepReport(str(step), "planned") for step in judgement.planning.plan)
    return Explanation(notes=tuple(_notes(judgement)), steps=steps)


def _notes(judgement: Judgement) -> Iterator[str]:
    for report in judgement.operators:
        yield f"{report.name}: {report.status.value}"
        for side, match in (("precondition", report.precondition), ("effect", report.effect)):
            if match.missing:
                yield f"{report.name}: the {side} lacks {', '.join(match.missing)}"
            if match.additional:
                yield f"{report.name}: the {side} has additional {', '.join(match.additional)}"
        for finding in report.findings:
            yield f"{report.name}: {finding.offence.value} in the {finding.place}: {finding.name}"
    planning = judgement.planning
    yield f"planner: {planning.outcome.value}" + (f" ({planning.detail})" if planning.detail else "")
