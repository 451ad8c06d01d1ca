"""Declaration of goal interpretation: its questions, its scorer, its metrics and its columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from eai.abilities.declaration import (
    AbilityDeclaration,
    AnswerOutcome,
    DomainAndNotation,
    MetricColumn,
    SchemaMaker,
    SingleQuestionInteraction,
    classify_answer_by_counts,
    find_error_outcome,
    make_score_columns,
)
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.verdict import (
    ALL,
    NO_COUNTS,
    make_confusion_shares,
    make_rate_contribution_of_answer,
    sum_confusion_counts,
)
from eai.tasks.share import Share
from eai.tasks.task import GoalKind
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.tasks.task import Task


OVERALL = "overall"
"""Prefix of the names of rates that count goals of all kinds."""

_GRAMMAR = "Grammar errors"
_PARTS = (*(kind.value for kind in GoalKind), OVERALL)
_SCORES = make_score_columns(_PARTS)


def compute_contributions_to_metrics(verdict: GoalVerdict) -> dict[str, Share]:
    """Return for each metric the numerator and the denominator that one answer adds to the metric.

    Three metrics are not in the paper's tables. ``parsing`` is the share of unreadable answers.
    ``ill_formed`` and ``hallucination`` are the shares of stated goals that are incomplete, or that name
    something that does not exist. Precision and F1 leave these goals out.
    """
    counts = verdict.counts or {}
    by_kind = {kind.value: counts.get(kind.value, NO_COUNTS) for kind in GoalKind}
    whole = counts.get(ALL, sum_confusion_counts(by_kind.values()))
    shares: dict[str, Share] = {}
    for name, confusion in {**by_kind, OVERALL: whole}.items():
        shares |= make_confusion_shares(name, confusion)
    unreadable = verdict.error is not None and verdict.error.kind is FaultKind.PARSING
    return {
        **shares,
        "parsing": make_rate_contribution_of_answer(unreadable),
        "ill_formed": Share(verdict.ill_formed, verdict.predicted),
        "hallucination": Share(len(verdict.hallucinated), verdict.predicted),
    }


def classify_outcome(verdict: GoalVerdict) -> AnswerOutcome:
    """Return the outcome of a goal interpretation."""
    counts = sum_confusion_counts((verdict.counts or {}).values())
    return find_error_outcome(verdict) or classify_answer_by_counts(
        counts, can_be_success=bool(verdict.success)
    )


def _make_scorer_factory(parts: DomainAndNotation) -> Callable[[Task], Scorer]:
    """Return a function that makes the scorer of a task.

    The module with scorers is imported only here, so that programs that only make reports do not load the
    simulator.
    """
    from eai.abilities.goal_interpretation.scorer import GoalInterpretationScorer

    return partial(GoalInterpretationScorer, domain=parts.domain, notation=parts.notation.goals)


def _get_object_names_and_schema_maker(
    parts: DomainAndNotation, task: Task | None
) -> tuple[Sequence[str], SchemaMaker]:
    names = () if task is None else parts.notation.goals.list_object_names(task)
    relevant = () if task is None else task.relevant
    words = list(dict.fromkeys([names[i] for i in relevant]))
    return words, lambda words: parts.notation.goals.make_json_schema_of_answer(parts.domain, words)


GOAL_INTERPRETATION = AbilityDeclaration(
    ability=Ability.GOAL_INTERPRETATION,
    interaction=SingleQuestionInteraction(
        _make_scorer_factory,
        answer_form=_get_object_names_and_schema_maker,
        lists_are_sets=True,
        plain_text_prefix=None,
    ),
    title="Goal interpretation",
    short_title="goals",
    verdict=GoalVerdict,
    contributions=compute_contributions_to_metrics,
    outcome=classify_outcome,
    columns=(
        *_SCORES,
        MetricColumn("parsing", _GRAMMAR, "Unreadable", False),
        MetricColumn("ill_formed", _GRAMMAR, "Ill-formed", False),
        MetricColumn("hallucination", _GRAMMAR, "Hallucination", False),
    ),
    terminal_metrics=(*(column.metric for column in _SCORES), "parsing"),
    overview_headings={f"{OVERALL}.f1": "F1"},
    averaged_metrics=(f"{OVERALL}.f1",),
)
