"""The scorer of transition modeling: from an answer to a verdict with counts by category of predicate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache, partial

from eai.abilities.explanation import AtomOrAction, StepReport, VerdictExplanation
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.transition_modeling.rules import OperatorJudgement, OperatorScoringRules, ReplacedPart
from eai.abilities.transition_modeling.verdict import (
    OTHER,
    OperatorComparisonStatus,
    OperatorReport,
    OperatorVerdict,
    PredicatesInClause,
    find_predicates_and_their_categories,
)
from eai.abilities.verdict import ALL, ConfusionCounts
from eai.pddl.check import PddlViolationKind
from eai.pddl.matching import ClauseComparison, ComparisonWithGoldOperator
from eai.pddl.planning import PlannerOutcome, PlannerResult
from eai.tasks.operator_task import TransitionTask

_MAX_CACHED_CLAUSES = 1000
"""Maximum number of clauses whose predicates are cached for a task."""


def count_matches_by_category(
    clause_comparisons: Iterable[ClauseComparison],
    predicates_of_clauses: Mapping[str, PredicatesInClause],
    *,
    count_clauses: bool,
) -> dict[str, ConfusionCounts]:
    """Return the numbers of matched, additional and missing clauses for each category that has any.

    Args:
        clause_comparisons: matched, additional and missing clauses of preconditions, or of effects.
        predicates_of_clauses: mapping from the text of a clause to its predicates.
        count_clauses: True to count clauses, False to count predicates with a category. A clause counts once
            in each category of its predicates, including `OTHER`, and once in `ALL`.
    """
    counts: dict[str, list[int]] = {}
    for side in clause_comparisons:
        for index, side_clauses in enumerate((side.matched, side.additional, side.missing)):
            for clause in side_clauses:
                for name in predicates_of_clauses[clause].categories:
                    if count_clauses or name != OTHER:
                        counts.setdefault(name, [0, 0, 0])[index] += 1
                if count_clauses:
                    counts.setdefault(ALL, [0, 0, 0])[index] += 1
    return {name: ConfusionCounts(*counts[name]) for name in sorted(counts)}


class TransitionModelingScorer(Scorer):
    """The scorer of the operators for one task.

    As long as the planner is the same, results depend only on answers.

    Args:
        task: the task.
        rules: the rules that judge answers; shared by the tasks of a benchmark.
    """

    def __init__(self, task: TransitionTask, rules: OperatorScoringRules) -> None:
        self.task = task
        self._rules = rules
        self._cached_content = lru_cache(_MAX_CACHED_CLAUSES)(
            partial(find_predicates_and_their_categories, categories=task.domain.categories)
        )

    def assess(self, text: str) -> Assessment:
        """Return the assessment of an answer. Its explanation lists the steps of the planner's plan."""
        judgement = self._rules.judge_answer(self.task, text)
        return Assessment(self._make_verdict(judgement), partial(_explain_judgement, judgement))

    def score_missing_answer(self) -> OperatorVerdict:
        """Return the verdict on a missing answer: all operators are missing."""
        return self._make_verdict(self._rules.judge_missing_answer(self.task))

    def plan_with_each_operator_of_answer(
        self, answer: str, replaced_part: ReplacedPart = "operator"
    ) -> Mapping[str, PlannerResult | None]:
        """Plan once for each operator of the task, with the answer's operator in place of the gold operator.

        Return the planner's results by operator name. All other operators of a planning task are gold
        operators. The result is None for an operator that the answer lacks. The mapping is empty if the
        answer is excluded from all rates.
        """
        return self._rules.plan_with_each_operator_of_answer(self.task, answer, replaced_part)

    def _make_verdict(self, judgement: OperatorJudgement) -> OperatorVerdict:
        categories = tuple(category.value for category in self.task.categories)
        if judgement.excluded is not None:
            return OperatorVerdict(
                excluded=judgement.excluded, error=judgement.error, task_categories=categories
            )
        outcome, planner = judgement.planning.outcome, self._rules.planner
        works = judgement.plan_works
        solved = None if outcome is PlannerOutcome.NOT_RUN else outcome is PlannerOutcome.SOLVED
        predicates_of_clauses = self._find_predicates_of_clauses(judgement.operators)
        return OperatorVerdict(
            success=solved if works is None else works,
            error=judgement.error,
            counts=self._count_clauses_by_category(judgement.operators, predicates_of_clauses),
            literals=judgement.literals,
            planner=outcome,
            plan_works=works,
            repairs=judgement.repairs,
            spans=judgement.spans,
            task_categories=categories,
            operators=judgement.operators,
            plan=tuple(str(step) for step in judgement.planning.plan),
            planner_detail=judgement.planning.detail,
            planner_name=None if planner is None else planner.name,
            clauses=predicates_of_clauses,
        )

    def _find_predicates_of_clauses(
        self, reports: tuple[OperatorReport, ...]
    ) -> dict[str, PredicatesInClause]:
        sides = [side for report in reports for side in (report.precondition, report.effect)]
        clauses = [
            clause_text for side in sides for clause_text in (*side.matched, *side.additional, *side.missing)
        ]
        return {clause: self._cached_content(clause) for clause in clauses}

    def _count_clauses_by_category(
        self, reports: tuple[OperatorReport, ...], predicates_of_clauses: Mapping[str, PredicatesInClause]
    ) -> Mapping[str, Mapping[str, ConfusionCounts]]:
        clauses = self._rules.counts_clauses
        return {
            "precondition": count_matches_by_category(
                [r.precondition for r in reports], predicates_of_clauses, count_clauses=clauses
            ),
            "effect": count_matches_by_category(
                [r.effect for r in reports], predicates_of_clauses, count_clauses=clauses
            ),
        }


def _explain_judgement(judgement: OperatorJudgement) -> VerdictExplanation:
    if judgement.error is not None:
        return VerdictExplanation((judgement.error.detail,))
    steps = tuple(
        StepReport(str(step), "planned", call=AtomOrAction(step.action, step.arguments))
        for step in judgement.planning.plan
    )
    return VerdictExplanation(notes=tuple(_list_explanation_notes(judgement)), steps=steps)


def _list_explanation_notes(judgement: OperatorJudgement) -> Iterator[str]:
    of_operators = {repair for repairs in judgement.operator_repairs.values() for repair in repairs}
    of_answer = [repair for repair in judgement.repairs if repair not in of_operators]
    if of_answer:
        yield f"the answer: read with repair: {', '.join(of_answer)}"
    for report in judgement.operators:
        yield f"{report.name}: {report.status.value}"
        if report.name in judgement.operator_repairs:
            yield f"{report.name}: read with repair: {', '.join(judgement.operator_repairs[report.name])}"
        match = judgement.matches.get(report.name)
        if match is not None and match.renamed:
            pairs = [f"its ?{ours} is the data set's ?{theirs}" for ours, theirs in match.renamed]
            whose = "clauses that it lacks have the data set's names, additional ones its own"
            yield f"{report.name}: compared so that {', '.join(pairs)}; {whose}"
        yield from _describe_clause_differences(report, match)
        for finding in report.offences:
            yield f"{report.name}: {finding.offence.value} in the {finding.place}: {finding.description}"
    planning = judgement.planning
    yield f"planner: {planning.outcome.value}" + (f" ({planning.detail})" if planning.detail else "")
    flaw = judgement.plan_flaw
    if judgement.plan_works:
        yield "the plan works with the data set's operators"
    elif flaw is not None:
        number, reason = flaw
        step = f"step {number + 1}: " if number < len(planning.plan) else ""
        yield f"the plan does not work with the data set's operators: {step}{reason}"


def _describe_clause_differences(
    report: OperatorReport, match: ComparisonWithGoldOperator | None
) -> Iterator[str]:
    """Yield texts on the missing and the additional clauses of an operator's precondition and effect.

    An unreadable precondition or effect counts as lacking all its clauses.
    """
    unread = {finding.place for finding in report.offences if finding.offence.makes_text_unreadable}
    for side, clauses in (("precondition", report.precondition), ("effect", report.effect)):
        of_condition = match if side == "precondition" else None
        missing_any = of_condition is not None and of_condition.missing_any
        additional_any = of_condition is not None and of_condition.additional_any
        lost = _format_clauses(clauses.missing, are_alternatives=missing_any)
        if report.status is OperatorComparisonStatus.UNREADABLE or f"{side} of {report.name}" in unread:
            if clauses.missing:
                yield f"{report.name}: the {side} cannot be compared, so it counts as lacking the {lost}"
            continue
        if clauses.missing:
            yield f"{report.name}: the {side} lacks the {lost}"
        if clauses.additional:
            besides = _format_clauses(clauses.additional, are_alternatives=additional_any)
            unbound = _describe_unbound_variables(report, side)
            yield f"{report.name}: the {side} has the additional {besides}{unbound}"


def _describe_unbound_variables(report: OperatorReport, precondition_or_effect: str) -> str:
    """Return a remark on variables in an operator that are not parameters of the operator.

    Without the remark, a clause with such a variable could look like a clause of the gold operator.
    """
    place = f"{precondition_or_effect} of {report.name}"
    kind = PddlViolationKind.UNBOUND_VARIABLE
    names = [
        f"?{finding.name}"
        for finding in report.offences
        if finding.offence is kind and finding.place == place
    ]
    return f" (no parameter: {', '.join(names)})" if names else ""


def _format_clauses(clauses: tuple[str, ...], *, are_alternatives: bool) -> str:
    """Return a list of clauses as text, such as ``clauses (open ?x), (near ?y)``."""
    noun = "alternative" if are_alternatives else "clause"
    return f"{noun}{'s' if len(clauses) > 1 else ''} {', '.join(clauses)}"
