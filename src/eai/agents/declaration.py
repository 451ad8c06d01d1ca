"""Declare the ability ``acting``, whose answers are episodes, and compute the metrics of episodes.

``docs/agents.md`` defines the metrics, with sources.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import floor
from statistics import fmean
from typing import TYPE_CHECKING

from eai.abilities.declaration import (
    ENDING_FAULTS,
    GOAL_COLUMNS,
    PARTIAL,
    SUCCESS,
    AbilityDeclaration,
    DomainAndNotation,
    MetricColumn,
    MultiTurnInteraction,
    QuestionAndAnswer,
    classify_plan_outcome,
    compute_reached_goal_shares,
    get_display_name,
)
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability
from eai.abilities.verdict import EMPTY_SHARE, UNREPLAYABLE, make_rate_contribution_of_answer
from eai.agents.verdict import EpisodeVerdict
from eai.tasks.share import Share
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.tasks.task import Task

WITHIN = {"within_1x": 1.0, "within_1.5x": 1.5, "within_2x": 2.0, "within_4x": 4.0}
"""Mapping from metrics to the maximum length of an episode that counts as a success for the metric.

Lengths are multiples of the length of the shortest known plan.
"""

KINDS = tuple(ENDING_FAULTS)
"""Names of the reasons why an action is impossible, such as an unmet precondition or an unknown object."""

_MAX_RECOVERY_TURNS = 2
"""Number of turns after an impossible action within which a possible action counts as recovery."""


def compute_contributions_to_metrics(verdict: EpisodeVerdict) -> dict[str, Share]:
    """Return the numerator and denominator that an episode adds to each rate, by the rate's name.

    If the task was played several times and the verdict is the mean, the numbers are means too.
    """
    if verdict.mean is not None:
        return dict(verdict.mean)
    won, actions, shortest = bool(verdict.success), verdict.action_turns, verdict.shortest
    tried = len(actions)
    kinds = [None if turn.fault is None else turn.fault.value for turn in actions]
    faulty = [i for i, kind in enumerate(kinds) if kind in KINDS]
    is_known = verdict.outlook in ("open", "lost")
    recovered = sum(
        any(turn.fault is None for turn in actions[i + 1 : i + 1 + _MAX_RECOVERY_TURNS]) for i in faulty
    )
    return {
        "success": make_rate_contribution_of_answer(won),
        **{
            name: EMPTY_SHARE
            if shortest is None
            else make_rate_contribution_of_answer(won and tried <= max(1, floor(most * shortest)))
            for name, most in WITHIN.items()
        },
        "spl": EMPTY_SHARE
        if shortest is None
        else make_rate_contribution_of_answer(_weight_success_by_path_length(won, tried, shortest)),
        "impossible": Share(len(faulty), tried),
        **{kind: Share(kinds.count(kind), tried) for kind in KINDS},
        "additional_step": Share(kinds.count(FaultKind.ADDITIONAL_STEP.value), tried),
        "won_after_fault": make_rate_contribution_of_answer(won) if faulty else EMPTY_SHARE,
        "recovered": Share(recovered, len(faulty)),
        "loops": Share(sum(turn.same_as is not None for turn in actions), tried),
        "undeclared": make_rate_contribution_of_answer(verdict.reached and not won),
        "declared_early": make_rate_contribution_of_answer(verdict.declared and not verdict.reached),
        UNREPLAYABLE: make_rate_contribution_of_answer(verdict.is_unreplayable),
        "lost_for_good": make_rate_contribution_of_answer(verdict.outlook == "lost")
        if is_known
        else EMPTY_SHARE,
        "outlook_unknown": EMPTY_SHARE
        if verdict.outlook is None
        else make_rate_contribution_of_answer(not is_known),
        **compute_reached_goal_shares(verdict),
    }


def average_episode_verdicts(verdicts: Sequence[EpisodeVerdict]) -> EpisodeVerdict:
    """Return the verdict on a task's first scored episode. Its `mean` is that of all scored episodes."""
    scored = [verdict for verdict in verdicts if verdict.excluded is None]
    if not scored:
        return verdicts[0]
    added = [compute_contributions_to_metrics(verdict) for verdict in scored]
    mean = {
        name: Share(*map(fmean, zip(*(shares[name] for shares in added), strict=True))) for name in added[0]
    }
    return replace(scored[0], mean=mean)


def _weight_success_by_path_length(won: bool, tried_actions: int, shortest_length: int) -> float:
    """Return success weighted by path length (SPL): shortest length / actions tried, 0 without success."""
    return float(won) if tried_actions <= shortest_length else won * shortest_length / tried_actions


def _make_scorer_factory(domain_and_notation: DomainAndNotation) -> Callable[[Task], Scorer]:
    """Return a function that makes the scorer of a task.

    The scorer plays episodes again. Its code is imported late, because reports do not need it.
    """
    from eai.agents.scorer import make_scorer_factory

    return make_scorer_factory(domain_and_notation)


def _make_question_and_answer(domain_and_notation: DomainAndNotation, task: Task) -> QuestionAndAnswer:
    from eai.agents.scorer import make_question_and_winning_answer

    return make_question_and_winning_answer(domain_and_notation, task)


def _read_harness_and_game_rules_of_episode(episode_text: str) -> Experiment | None:
    """Return the game rules of an episode and its harness, the program that let the model act.

    Return None if the answer is not an episode with turns.

    The import is delayed, so that reports start fast.
    """
    from eai.agents.play import StoredEpisode, make_label_of_nonstandard_rules, read_episode

    episode = read_episode(episode_text)
    if not isinstance(episode, StoredEpisode) or not episode.turns:
        return None
    return Experiment(harness=episode.harness or None, rules=make_label_of_nonstandard_rules(episode))


_WITHIN = tuple(MetricColumn(name, "Success within", f"{most:g}x shortest") for name, most in WITHIN.items())

ACTING = AbilityDeclaration(
    ability=Ability("acting"),
    interaction=MultiTurnInteraction(
        _make_scorer_factory,
        _make_question_and_answer,
        read_episode_settings=_read_harness_and_game_rules_of_episode,
    ),
    title="Acting",
    short_title="acting",
    verdict=EpisodeVerdict,
    contributions=compute_contributions_to_metrics,
    outcome=classify_plan_outcome,
    columns=(
        MetricColumn("success", SUCCESS, "Success"),
        *_WITHIN,
        MetricColumn("spl", SUCCESS, "SPL"),
        MetricColumn("impossible", "Impossible actions", "All", False),
        *(MetricColumn(kind, "Impossible actions", get_display_name(kind), False) for kind in KINDS),
        MetricColumn("additional_step", "Actions", "Not needed", False),
        MetricColumn("loops", "Actions", "Loops", False),
        MetricColumn("won_after_fault", "After a fault", "Success"),
        MetricColumn("recovered", "After a fault", "Recovered"),
        MetricColumn("undeclared", "The end", "Undeclared", False),
        MetricColumn("declared_early", "The end", "Declared early", False),
        MetricColumn(UNREPLAYABLE, "The end", "Unreplayable", False),
        MetricColumn("lost_for_good", "The end", "Lost for good", False),
        MetricColumn("outlook_unknown", "The end", "Outlook unknown", False),
        *GOAL_COLUMNS,
    ),
    terminal_metrics=(
        *("success", *WITHIN, "spl", "impossible", "recovered", "loops", "undeclared", "declared_early"),
        *(UNREPLAYABLE, "lost_for_good", "total_goal", PARTIAL),
    ),
    overview_headings={"success": "Success", "within_2x": "Within 2x", "spl": "SPL"},
    averaged_metrics=(),
    yes_no_metrics=frozenset(
        {"success", *WITHIN, "undeclared", "declared_early", UNREPLAYABLE, "lost_for_good"}
    ),
    combine_epochs=average_episode_verdicts,
)
