"""Declaration of transition modeling: its questions, its scorer, its metrics and its columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from eai.abilities.answer_schema import make_object_schema, make_text_schema
from eai.abilities.declaration import (
    OVERALL,
    PLANNER,
    AbilityDeclaration,
    AnswerOutcome,
    DomainAndNotation,
    MetricColumn,
    SchemaMaker,
    SingleQuestionInteraction,
    classify_answer_by_counts,
    find_error_outcome,
    get_display_name,
    make_score_columns,
)
from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.verdict import (
    OperatorVerdict,
    count_clauses_by_category,
    sum_counts_of_categories,
)
from eai.abilities.verdict import (
    EMPTY_SHARE,
    NO_COUNTS,
    make_confusion_shares,
    make_rate_contribution_of_answer,
    sum_confusion_counts,
)
from eai.pddl.planning import PlannerOutcome
from eai.tasks.share import Share
from eai.tasks.task import CATEGORIES

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.tasks.operator_task import TransitionTask
    from eai.tasks.task import Task


LITERALS = "literals"
"""Prefix of the names of rates that count literals, and so give partial credit for partly right clauses."""

WORKS = "Plan works"
"""Heading of the rate of plans that also work with the gold operators.

Each plan is found with the operators of an answer.
"""

_PARTS = (*CATEGORIES, OVERALL)
_PLANNER_SUCCESS = f"{OVERALL}.planner_success"
_PLAN_WORKS = f"{OVERALL}.plan_works"


def compute_contributions_to_metrics(verdict: OperatorVerdict) -> dict[str, Share]:
    """Return for each metric the numerator and the denominator that one answer adds to the metric.

    Preconditions and effects are counted together. Each category of predicates has its own metrics. The
    metrics that begin with `OVERALL` or `LITERALS` count all categories together. The result of planning
    counts in each category of the task and once overall, unless no planner ran. The rate of working plans
    includes only answers for which it is known whether the plan works.
    """
    counts = count_clauses_by_category(verdict)
    planned = verdict.planner not in (None, PlannerOutcome.NOT_RUN)
    solved = make_rate_contribution_of_answer(verdict.planner is PlannerOutcome.SOLVED)
    shares: dict[str, Share] = {}
    for name in CATEGORIES:
        shares |= make_confusion_shares(name, counts.get(name, NO_COUNTS))
        counts_here = planned and name in verdict.task_categories
        shares[f"{name}.planner_success"] = solved if counts_here else EMPTY_SHARE
    shares |= make_confusion_shares(OVERALL, sum_counts_of_categories(counts))
    shares |= make_confusion_shares(LITERALS, sum_confusion_counts((verdict.literals or {}).values()))
    shares[_PLANNER_SUCCESS] = solved if planned else EMPTY_SHARE
    shares[_PLAN_WORKS] = (
        EMPTY_SHARE if verdict.plan_works is None else make_rate_contribution_of_answer(verdict.plan_works)
    )
    return shares


def classify_outcome(verdict: OperatorVerdict) -> AnswerOutcome:
    """Return the outcome of an answer.

    If a planner was used, an answer with right operators succeeds only if the planner found a plan.
    """
    if verdict.success:
        return AnswerOutcome.SUCCESS
    unplanned = verdict.planner in (None, PlannerOutcome.NOT_RUN)
    return find_error_outcome(verdict) or classify_answer_by_counts(
        sum_counts_of_categories(count_clauses_by_category(verdict)), can_be_success=unplanned
    )


_PLANNED = (*(f"{name}.planner_success" for name in CATEGORIES), _PLANNER_SUCCESS, _PLAN_WORKS)


def list_unmeasured_metrics(verdict: OperatorVerdict) -> Sequence[str]:
    """Return the metrics about planning if the run used no planner, else no metrics.

    Without a planner, these metrics leave out all answers: even answers that need no planner, such as answers
    without operators.
    """
    return _PLANNED if verdict.planner is PlannerOutcome.NOT_RUN else ()


def _make_scorer_factory(parts: DomainAndNotation) -> Callable[[TransitionTask], Scorer]:
    """Return a function that makes the scorer of a task.

    The module with scorers is imported only here, so that scoring of plans does not load the planner of
    operators.
    """
    from eai.abilities.transition_modeling.rules import PaperOperatorScoringRules
    from eai.abilities.transition_modeling.scorer import TransitionModelingScorer

    rules = PaperOperatorScoringRules(parts.make_planner())
    return lambda task: TransitionModelingScorer(task, rules)


def _get_object_names_and_schema_maker(
    parts: DomainAndNotation, task: Task | None
) -> tuple[Sequence[str], SchemaMaker]:
    return (), lambda words: make_object_schema({"output": make_text_schema()})


TRANSITION_MODELING = AbilityDeclaration(
    ability=Ability.TRANSITION_MODELING,
    interaction=SingleQuestionInteraction(
        _make_scorer_factory,
        answer_form=_get_object_names_and_schema_maker,
        uses_operator_tasks=True,
        plain_text_prefix="(:action",
    ),
    title="Transition modeling",
    short_title="operators",
    verdict=OperatorVerdict,
    contributions=compute_contributions_to_metrics,
    outcome=classify_outcome,
    columns=(
        *make_score_columns((*_PARTS, LITERALS)),
        *(MetricColumn(f"{part}.planner_success", PLANNER, get_display_name(part)) for part in _PARTS),
        MetricColumn(_PLAN_WORKS, PLANNER, WORKS),
    ),
    terminal_metrics=(
        *(f"{part}.{measure}" for part in _PARTS for measure in ("f1", "planner_success")),
        _PLAN_WORKS,
        f"{LITERALS}.f1",
    ),
    overview_headings={f"{OVERALL}.f1": "F1", _PLAN_WORKS: WORKS, _PLANNER_SUCCESS: PLANNER},
    averaged_metrics=(f"{OVERALL}.f1", _PLANNER_SUCCESS),
    replacements={_PLANNER_SUCCESS: _PLAN_WORKS},
    yes_no_metrics=frozenset({_PLANNER_SUCCESS, _PLAN_WORKS}),
    missing_metrics=list_unmeasured_metrics,
)
