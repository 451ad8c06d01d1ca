from __future__ import annotations

import pytest

from eai.abilities.protocol import Ability
from eai.results.paper_tables import PaperColumn, read_paper_table
from eai.results.summary import compute_average_performance, compute_weights_of_averaged_metrics

OFF_IN_THE_PAPER = {("behavior", "Cohere Command R+"), ("behavior", "o1-preview")}
"""Averages that do not follow from the paper's own columns."""


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_paper_averages_follow_from_its_columns(domain: str) -> None:
    overview = read_paper_table("overview")
    off = set()
    for model, figures in overview.rows.items():
        printed = figures[PaperColumn("", "average_performance", domain)]
        found = compute_average_performance(
            {
                (Ability(c.ability), c.metric): v
                for c, v in figures.items()
                if c.ability and c.domain == domain
            }
        )
        if found != pytest.approx(printed, abs=0.051):
            off.add((domain, model))
    assert off == {pair for pair in OFF_IN_THE_PAPER if pair[0] == domain}


def test_average_weights_equal_those_of_the_papers_equation() -> None:
    assert compute_weights_of_averaged_metrics() == {
        (Ability.GOAL_INTERPRETATION, "overall.f1"): 0.25,
        (Ability.SUBGOAL_DECOMPOSITION, "task_success"): 0.25,
        (Ability.ACTION_SEQUENCING, "task_success"): 0.25,
        (Ability.TRANSITION_MODELING, "overall.f1"): 0.125,
        (Ability.TRANSITION_MODELING, "overall.planner_success"): 0.125,
    }


def test_the_rate_of_working_plans_replaces_planner_success_if_known() -> None:
    values: dict[tuple[Ability, str], float | None] = dict.fromkeys(
        compute_weights_of_averaged_metrics(), 40.0
    )
    assert compute_average_performance(values) == pytest.approx(40)
    works = Ability.TRANSITION_MODELING, "overall.plan_works"
    assert compute_average_performance({**values, works: 0.0}) == pytest.approx(35)
    assert compute_average_performance({**values, works: None}) == pytest.approx(40)


def test_the_average_is_missing_unless_all_abilities_are_known() -> None:
    assert compute_average_performance({(Ability.GOAL_INTERPRETATION, "overall.f1"): 50.0}) is None
