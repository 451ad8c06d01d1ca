from __future__ import annotations

import pytest

from eai.abilities.goal_interpretation.declaration import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.declaration import OperatorVerdict
from eai.abilities.verdict import Confusion
from eai.results.paper_tables import OTHER_TABLES, PaperColumn, paper_models, paper_setting, paper_table
from eai.results.summary import summarise
from oracle import MODELS, Oracle

FULL_TABLES = paper_setting().full_tables

DIGIT = 0.056
"""The paper rounds to two digits and then to one."""


def test_a_published_file_is_known_by_the_name_that_it_has() -> None:
    """It lacks a digit; without it one of the 18 models would be left out without a word."""
    assert paper_models()["claude-3-sonnet-2024022"] == "Claude-3 Sonnet"


@pytest.mark.parametrize("name", [*FULL_TABLES, *OTHER_TABLES])
def test_every_row_fills_every_column(name: str) -> None:
    table = paper_table(name)
    assert {len(row) for row in table.rows.values()} == {len(table.columns)}
    assert all(figure is None or 0 <= figure <= 100 for row in table.rows.values() for figure in row)


@pytest.mark.parametrize("name", FULL_TABLES)
def test_full_tables_have_the_same_models_and_our_metrics(name: str) -> None:
    table = paper_table(name)
    assert set(table.rows) == set(paper_models().values())
    for column in table.columns:
        if column.ability:
            assert column.metric in summarise([], Ability(column.ability))


@pytest.mark.parametrize("name", [*FULL_TABLES, *OTHER_TABLES])
def test_notes_are_on_cells_that_exist(name: str) -> None:
    table = paper_table(name)
    for note in table.notes:
        assert note.columns, note.text
        assert set(note.models) <= set(table.rows), note.text


def test_contradictions_are_found_on_both_sides() -> None:
    column = PaperColumn("subgoal_decomposition", "task_success", "virtualhome")
    for name, printed in (("overview", 88.8), ("subgoal_decomposition_trajectory", 87.6)):
        table = paper_table(name)
        texts = [note.text for note in table.notes if note.is_on("GPT-4o", column)]
        assert any(str(printed) in text for text in texts)
        assert table.figure("GPT-4o", column) == {"overview": 87.6}.get(name, 88.8)


@pytest.mark.parametrize("model", MODELS)
def test_goal_interpretation_of_behavior_is_the_paper_s_to_the_digit(model: str, oracle: Oracle) -> None:
    verdicts = [
        GoalVerdict(
            counts={key: _confusion(row["verdict"][part]) for key, part in _PARTS.items()},
        )
        for row in oracle("behavior", "goal_interpretation", model)["records"]
        if row["verdict"]
    ]
    rates = summarise(verdicts, Ability.GOAL_INTERPRETATION)
    table = paper_table("goal_interpretation")
    for column in table.columns:
        printed = table.figure(paper_models()[model], column)
        if column.domain == "behavior" and printed is not None:
            assert rates[column.metric].percent == pytest.approx(printed, abs=DIGIT), column


_PARTS = {"state": "state_goal", "relation": "relation_goal", "all": "overall"}


def _confusion(part: dict[str, int]) -> Confusion:
    keys = ("num_satisfied_conditions", "num_false_positive_conditions", "num_unsatisfied_conditions")
    return Confusion(*(part[key] for key in keys))


@pytest.mark.parametrize("model", MODELS)
def test_operators_of_behavior_are_the_paper_s_to_the_digit(model: str, oracle: Oracle) -> None:
    verdicts = [
        OperatorVerdict(
            counts={
                side: {name.replace("-", "_"): Confusion(*c) for name, c in row["verdict"][key].items()}
                for side, key in _SIDES.items()
            }
        )
        for row in oracle("behavior", "transition_modeling", model)["records"]
        if row["verdict"]
    ]
    rates = summarise(verdicts, Ability.TRANSITION_MODELING)
    table = paper_table("transition_modeling_behavior_logic")
    for column in table.columns:
        printed = table.figure(paper_models()[model], column)
        assert rates[column.metric].percent == pytest.approx(printed, abs=DIGIT), column


_SIDES = {"precondition": "precond_predicate_type_res", "effect": "effect_predicate_type_res"}
