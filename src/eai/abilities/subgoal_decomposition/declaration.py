"""Declaration of subgoal decomposition: its questions, its scorer, its metrics and its columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from eai.abilities.declaration import (
    COLUMNS,
    RUNTIME_FAULTS,
    DomainAndNotation,
    MetricColumn,
    SchemaMaker,
    SingleQuestionInteraction,
    compute_reached_goal_shares,
    count_faults_for_summary,
    count_needless_steps_for_summary,
    declare_plan_ability,
)
from eai.abilities.protocol import Ability
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.tasks.share import Share
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.tasks.task import Task


_EXECUTED = (SubgoalAnswerCategory.CORRECT, SubgoalAnswerCategory.GOAL_UNREACHABLE)


def compute_contributions_to_metrics(verdict: SubgoalVerdict) -> dict[str, Share]:
    """Return for each metric the numerator and the denominator that one answer adds to the metric.

    An answer that is rejected before its execution counts as one error: ``parsing``, ``hallucination`` or
    ``argument_number``. If an answer is executed, the error that ended its execution counts as one. All its
    additional (needless) steps together also count as one. If the verdict has `SummaryCounts`, their errors
    count instead.

    All executed actions of a subgoal except one are added actions. The metric ``granularity`` is the number
    of added actions, divided by the number of subgoals with executed actions.
    """
    category = verdict.category
    wrong_arity = verdict.error is not None and verdict.error.kind is FaultKind.ARGUMENT_NUMBER
    unknown = category is SubgoalAnswerCategory.HALLUCINATION and not wrong_arity
    return {
        "task_success": make_rate_contribution_of_answer(category is SubgoalAnswerCategory.CORRECT),
        "execution_success": make_rate_contribution_of_answer(category in _EXECUTED),
        "parsing": make_rate_contribution_of_answer(category is SubgoalAnswerCategory.NOT_PARSEABLE),
        "hallucination": make_rate_contribution_of_answer(unknown),
        "argument_number": make_rate_contribution_of_answer(wrong_arity),
        **{
            name: make_rate_contribution_of_answer(count_faults_for_summary(verdict, kind))
            for name, kind in RUNTIME_FAULTS.items()
            if kind is not FaultKind.UNCATEGORISED
        },
        "additional_step": make_rate_contribution_of_answer(count_needless_steps_for_summary(verdict)),
        "goal_unreachable": make_rate_contribution_of_answer(
            category is SubgoalAnswerCategory.GOAL_UNREACHABLE
        ),
        "granularity": Share(verdict.added_actions or 0, verdict.refined or 0),
        **compute_reached_goal_shares(verdict),
    }


def _make_scorer_factory(parts: DomainAndNotation) -> Callable[[Task], Scorer]:
    """Return a function that makes the scorer of a task.

    The module with scorers is imported only here, so that programs that only make reports do not load the
    search.
    """
    from eai.abilities.subgoal_decomposition.refinement import SubgoalRefiner
    from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer

    notation = parts.subgoal_notation()
    domain = notation.get_domain_for_executing_subgoals()
    return partial(
        SubgoalDecompositionScorer, domain=domain, notation=notation, refinement=SubgoalRefiner(domain)
    )


def _get_object_names_and_schema_maker(
    parts: DomainAndNotation, task: Task | None
) -> tuple[Sequence[str], SchemaMaker]:
    subgoals = parts.subgoal_notation()
    return (), lambda words: subgoals.make_json_schema_of_answer()


SUBGOAL_DECOMPOSITION = replace(
    declare_plan_ability(
        Ability.SUBGOAL_DECOMPOSITION,
        SingleQuestionInteraction(
            _make_scorer_factory, answer_form=_get_object_names_and_schema_maker, plain_text_prefix=None
        ),
        "Subgoal decomposition",
        "subgoals",
        SubgoalVerdict,
        compute_contributions_to_metrics,
    ),
    columns=(*COLUMNS, MetricColumn("granularity", "Added by search", "Granularity", False)),
)
