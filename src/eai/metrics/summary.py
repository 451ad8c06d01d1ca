"""The metrics of every ability, and which of them the terminal's tables show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from typing_extensions import assert_never

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import Verdict
from eai.metrics import action_sequencing, goal_interpretation, subgoal_decomposition, transition_modeling
from eai.metrics.rate import NOTHING, Rate, total
from eai.pddl.planning import PlannerOutcome

TABLE_COLUMNS: Mapping[Ability, tuple[str, ...]] = {
    Ability.GOAL_INTERPRETATION: goal_interpretation.TABLE_COLUMNS,
    Ability.SUBGOAL_DECOMPOSITION: subgoal_decomposition.TABLE_COLUMNS,
    Ability.ACTION_SEQUENCING: action_sequencing.TABLE_COLUMNS,
    Ability.TRANSITION_MODELING: transition_modeling.TABLE_COLUMNS,
}
"""The columns of the table that a terminal shows, by ability."""

MAIN_COLUMNS: Mapping[Ability, tuple[str, ...]] = {
    Ability.GOAL_INTERPRETATION: ("overall.f1",),
    Ability.SUBGOAL_DECOMPOSITION: ("task_success", "execution_success"),
    Ability.ACTION_SEQUENCING: ("task_success", "execution_success"),
    Ability.TRANSITION_MODELING: ("overall.f1", "overall.planner_success"),
}
"""The columns of the paper's overview, by ability."""

AVERAGED: Mapping[Ability, tuple[str, ...]] = {
    Ability.GOAL_INTERPRETATION: ("overall.f1",),
    Ability.ACTION_SEQUENCING: ("task_success",),
    Ability.SUBGOAL_DECOMPOSITION: ("task_success",),
    Ability.TRANSITION_MODELING: ("overall.f1", "overall.planner_success"),
}
"""What the paper's average performance of a domain is the mean of: of each ability the mean of these."""


def summarise(
    verdicts: Sequence[Verdict], domain: str, ability: Ability, protocol: Protocol
) -> dict[str, Rate]:
    """All metrics of the paper's tables for an ability, by name, over the verdicts that are not excluded.

    Metrics without any verdict are there all the same, as nothing of nothing.
    """
    nothing = dict.fromkeys(contribution(Verdict(), domain, ability, protocol), NOTHING)
    return {**nothing, **total(contributions(verdicts, domain, ability, protocol))}


def contributions(
    verdicts: Sequence[Verdict], domain: str, ability: Ability, protocol: Protocol
) -> list[dict[str, Rate]]:
    """What each verdict of a run that is not excluded contributes to each metric, in order.

    A run in which the planner was left out has no planner success, though some of its answers are known to
    be unsolvable without planning.
    """
    scored = [verdict for verdict in verdicts if verdict.excluded is None]
    if any(verdict.planner is PlannerOutcome.NOT_RUN for verdict in scored):
        scored = [replace(verdict, planner=PlannerOutcome.NOT_RUN) for verdict in scored]
    return [contribution(verdict, domain, ability, protocol) for verdict in scored]


def contribution(verdict: Verdict, domain: str, ability: Ability, protocol: Protocol) -> dict[str, Rate]:
    """What one answer contributes to each metric; the metrics are sums of these over sums."""
    match ability:
        case Ability.GOAL_INTERPRETATION:
            return goal_interpretation.contribution(verdict)
        case Ability.SUBGOAL_DECOMPOSITION:
            return subgoal_decomposition.contribution(verdict, protocol)
        case Ability.ACTION_SEQUENCING:
            return action_sequencing.contribution(verdict, domain, protocol)
        case Ability.TRANSITION_MODELING:
            return transition_modeling.contribution(verdict)
        case _:
            assert_never(ability)
