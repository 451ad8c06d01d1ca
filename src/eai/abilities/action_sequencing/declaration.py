"""Declaration of action sequencing: its questions, its scorer, its metrics and its columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from eai.abilities.declaration import (
    ENDING_FAULTS,
    DomainAndNotation,
    SchemaMaker,
    SingleQuestionInteraction,
    compute_reached_goal_shares,
    count_faults_for_summary,
    count_needless_steps_for_summary,
    declare_plan_ability,
)
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict, make_rate_contribution_of_answer
from eai.tasks.share import Share

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.tasks.task import Task


def compute_contributions_to_metrics(verdict: PlanVerdict) -> dict[str, Share]:
    """Return for each metric the numerator and the denominator that one plan adds to the metric.

    If the verdict has separate counts for summaries (`SummaryCounts`), these counts are used for success,
    errors and goals.
    """
    counted = verdict.counted
    return {
        "task_success": make_rate_contribution_of_answer(
            verdict.success if counted is None else counted.success
        ),
        "execution_success": make_rate_contribution_of_answer(verdict.executable),
        **{
            name: make_rate_contribution_of_answer(count_faults_for_summary(verdict, kind))
            for name, kind in ENDING_FAULTS.items()
        },
        "additional_step": make_rate_contribution_of_answer(count_needless_steps_for_summary(verdict)),
        **compute_reached_goal_shares(verdict),
    }


def _make_scorer_factory(parts: DomainAndNotation) -> Callable[[Task], Scorer]:
    """Return a function that makes the scorer of a task.

    The module with scorers is imported only here, so that programs that only make reports do not load the
    simulator.
    """
    from eai.abilities.action_sequencing.scorer import ActionSequencingScorer

    return partial(ActionSequencingScorer, domain=parts.domain, notation=parts.notation.plans)


def _get_object_names_and_schema_maker(
    parts: DomainAndNotation, task: Task | None
) -> tuple[Sequence[str], SchemaMaker]:
    """Return the words for objects in answers, and a function that makes an answer's JSON schema from them.

    If `task` is None, there are no words. If answers may decline the task, they have no schema, so the second
    result always returns None.
    """
    if task is not None and task.allows_declining_answers:
        return parts.notation.plans.list_words_that_name_objects(task), lambda words: None
    words = () if task is None else parts.notation.plans.list_words_that_name_objects(task)
    return words, lambda words: parts.notation.plans.make_json_schema_of_answer(parts.domain, words)


ACTION_SEQUENCING = declare_plan_ability(
    Ability.ACTION_SEQUENCING,
    SingleQuestionInteraction(
        _make_scorer_factory,
        answer_form=_get_object_names_and_schema_maker,
        keys_in_order=True,
        plain_text_prefix=None,
    ),
    "Action sequencing",
    "actions",
    PlanVerdict,
    compute_contributions_to_metrics,
)
