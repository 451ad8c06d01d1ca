from __future__ import annotations

from typing import Any

import pytest

from eai.abilities.protocol import Ability
from eai.results.table import Estimate
from eai.studies.goals.study import make_goal_tables
from oracle import MODELS, read_shared
from studies.published import tables

PAPERS_NAMES = {
    "claude-3-opus-20240229": "Claude-3 Opus",
    "cohere-command-r": "Cohere Command R",
    "gemini-1.5-pro-preview-0409": "Gemini 1.5 Pro",
    "gpt-3.5-turbo-0125": "GPT-3.5-turbo",
    "gpt-4o-2024-05-13": "GPT-4o",
    "llama-3-8b-chat": "Llama 3 8B",
    "mixtral-8x22b-instruct-v0.1": "Mixtral 8x22B MoE",
}
"""The models of which both the answers and the authors' own lists are at hand."""


@pytest.fixture(scope="module")
def nine() -> dict[str, list[dict[str, Any]]]:
    found = make_goal_tables(tables("behavior", Ability.GOAL_INTERPRETATION, MODELS).atoms)
    return {table.name: table.row_dicts() for table in found}


def test_goals_by_predicate_equal_the_authors_figures(nine: dict[str, list[dict[str, Any]]]) -> None:
    authors = read_shared("paper", "goal_interpretation_behavior_by_predicate.json")["rows"]
    ours = {
        (row["model"], row["predicate"]): [row["matched"], row["wrong"], row["missing"]]
        for row in nine["by_predicate"]
    }
    cells = {
        (model, predicate): counts
        for model, name in PAPERS_NAMES.items()
        for predicate, counts in authors[name].items()
    }
    assert len(cells) == 98
    assert {cell: ours.get(cell, [0, 0, 0]) for cell in cells} == cells


def test_two_fifths_of_wrong_goals_hold_at_the_start(nine: dict[str, list[dict[str, Any]]]) -> None:
    together = {row["reason"]: row["share"] for row in nine["reasons"] if row["model"] == "all models"}
    assert isinstance(together["initial"], Estimate)
    assert (together["initial"].numerator, together["initial"].denominator) == (1411, 3390)
    assert sum(share.numerator for share in together.values()) == 3390


def test_a_goal_that_all_models_miss_is_listed(nine: dict[str, list[dict[str, Any]]]) -> None:
    """The paper's example: no model states that the shoes must be on the floor."""
    missed = {row["goal"] for row in nine["shared"] if row["missing"] == row["models"] == 9}
    assert {f"onfloor(gym_shoe.n.01_{i}, floor.n.01_1)" for i in range(1, 5)} <= missed
