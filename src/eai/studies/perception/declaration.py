"""Declare the ability ``scene_graph``: a model lists the objects and facts in pictures of a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from eai.abilities.declaration import (
    AbilityDeclaration,
    AnswerOutcome,
    DomainAndNotation,
    MetricColumn,
    QuestionAndAnswer,
    SingleQuestionInteraction,
    classify_answer_by_counts,
    find_error_outcome,
    get_display_name,
)
from eai.abilities.protocol import Ability
from eai.abilities.verdict import (
    make_confusion_shares,
    make_rate_contribution_of_answer,
    sum_confusion_counts,
)
from eai.base.entry_points import load_from_extension
from eai.studies.perception.verdict import SceneGraphVerdict, ScenePerceptionErrorCounts
from eai.tasks.share import Share

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.studies.perception.scene_graph import SceneGraphVocabulary
    from eai.tasks.task import Task


def make_numerator_and_denominator_by_rate(perceived: ScenePerceptionErrorCounts) -> dict[str, Share]:
    """Return the numerator and denominator that one scene graph adds to each rate, by name of the rate.

    Two rates are from the paper. ``predicate_error`` is the share of true facts that the graph lacks or
    misplaces. ``object_error`` is the share of invented names in the graph's names. Of the other rates,
    ``missing`` is a share of the true facts, and ``misplaced`` of the true relations. ``unnecessary`` and
    ``invented`` are shares of the graph's facts, and ``unseen`` is a share of the true objects. The last
    rates are precision, recall and F1 of facts. This project chose the denominators, because the paper gives
    none.
    """
    lost = perceived.missing + perceived.misplaced
    return {
        "predicate_error": Share(lost, perceived.facts),
        "object_error": Share(perceived.invented_names, perceived.names),
        "missing": Share(perceived.missing, perceived.facts),
        "misplaced": Share(perceived.misplaced, perceived.relations),
        "unnecessary": Share(perceived.unnecessary, perceived.perceived),
        "invented": Share(perceived.invented, perceived.perceived),
        "unseen": Share(perceived.unseen, perceived.objects),
        **make_confusion_shares("facts", sum_confusion_counts(perceived.predicates.values())),
    }


def _make_scorer_factory(parts: DomainAndNotation) -> Callable[[Task], Scorer]:
    """Return a function that makes the scorer of a task.

    The scorer's module is imported only when this function is called. Reports never call it.
    """
    from eai.studies.perception.errors import make_scorer_factory

    return make_scorer_factory(_make_vocabulary_of_scene_graphs(parts))


def _make_vocabulary_of_scene_graphs(parts: DomainAndNotation) -> SceneGraphVocabulary:
    from eai.studies.perception.scene_graph import SceneGraphVocabulary

    return SceneGraphVocabulary(parts.wording(Ability.ACTION_SEQUENCING))


def _make_question_and_answer(parts: DomainAndNotation, task: Task) -> QuestionAndAnswer:
    words = _make_vocabulary_of_scene_graphs(parts)
    values = {
        "vocabulary": words.wording.describe_vocabulary(),
        "objects": words.wording.describe_objects(task),
    }
    return values, words.make_true_graph(task).json_text


def _draw_task_pictures(parts: DomainAndNotation, task: Task) -> Sequence[tuple[str, bytes]]:
    from eai.studies.perception.scene_graph import SceneGraphVocabulary

    diagrams = load_from_extension("diagrams", "questions of scene_graph")
    return (diagrams.draw_task_image(task, SceneGraphVocabulary(parts.observation_wording())),)


def compute_rate_contributions(verdict: SceneGraphVerdict) -> dict[str, Share]:
    """Return the numerator and denominator that one answer adds to each rate, by name of the rate.

    A predicate has rates of its own only if it occurs in the true scene or in the answer's scene graph.
    """
    shares = {
        "right": make_rate_contribution_of_answer(verdict.success),
        **make_numerator_and_denominator_by_rate(verdict.seen),
        "parsing": make_rate_contribution_of_answer(verdict.error is not None),
    }
    for name, counts in verdict.seen.predicates.items():
        shares |= make_confusion_shares(name, counts)
    return shares


def find_outcome(verdict: SceneGraphVerdict) -> AnswerOutcome:
    """Return the outcome of an answer, for counts of outcomes in reports."""
    if verdict.success:
        return AnswerOutcome.SUCCESS
    return find_error_outcome(verdict) or classify_answer_by_counts(
        sum_confusion_counts(verdict.seen.predicates.values()), can_be_success=False
    )


_ERRORS = ("predicate_error", "object_error", "missing", "misplaced", "unnecessary", "invented", "unseen")
_FACTS = {"facts.precision": "Precision", "facts.recall": "Recall", "facts.f1": "F1"}

SCENE_GRAPH = AbilityDeclaration(
    ability=Ability("scene_graph"),
    interaction=SingleQuestionInteraction(
        _make_scorer_factory,
        _make_question_and_answer,
        _draw_task_pictures,
        lists_are_sets=True,
        plain_text_prefix=None,
    ),
    title="Scene graphs",
    short_title="scene",
    verdict=SceneGraphVerdict,
    contributions=compute_rate_contributions,
    outcome=find_outcome,
    columns=(
        MetricColumn("right", "All", "Right"),
        *(MetricColumn(metric, "Facts", label) for metric, label in _FACTS.items()),
        *(MetricColumn(metric, "Errors", get_display_name(metric), False) for metric in _ERRORS),
        MetricColumn("parsing", "Grammar errors", "Unreadable", False),
    ),
    terminal_metrics=("right", *_FACTS, "predicate_error", "object_error", "parsing"),
    overview_headings={"right": "Right", "facts.f1": "F1 of facts"},
    averaged_metrics=(),
    yes_no_metrics=frozenset({"right"}),
)
