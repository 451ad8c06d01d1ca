from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest

from eai.abilities.protocol import Ability
from eai.results.lines import ALL_MODELS
from eai.results.table import Cell, Estimate, Table
from eai.studies.cofactors.study import (
    fit_feature_effects_on_success,
    make_bin_function,
    make_task_feature_tables,
)
from oracle import MODELS
from studies.published import GPT_4O, tables

pytest.importorskip("scipy")


def made_of(cell: Cell) -> tuple[float | None, float | None]:
    assert isinstance(cell, Estimate)
    return cell.numerator, cell.denominator


def by(
    table: Table, column: str, rate: str, **wanted: str
) -> Mapping[Cell, tuple[float | None, float | None]]:
    """Return the values of a column, with the fractions of the rates in their rows."""
    rows = table.row_dicts()
    return {
        row[column]: made_of(row[rate])
        for row in rows
        if all(row[name] == value for name, value in wanted.items())
    }


@pytest.fixture(scope="module")
def gpt_4o() -> dict[str, Table]:
    found = make_task_feature_tables(
        tables("behavior", Ability.ACTION_SEQUENCING), bin_width=10, measure="score"
    )
    return {table.name: table for table in found}


def test_the_curve_of_annotated_steps_equals_the_papers_figure(gpt_4o: dict[str, Table]) -> None:
    """The paper draws nothing in the bin of 50 to 59 steps as 0, and prints 0.50 where 17/37 stands."""
    assert by(gpt_4o["curves"], "from", "score", feature="annotated_steps", model=GPT_4O) == {
        0: (27, 39),
        10: (17, 37),
        20: (2, 15),
        30: (1, 6),
        40: (1, 2),
        60: (0, 1),
    }


def test_the_share_of_executed_steps_by_action_equals_the_papers(gpt_4o: dict[str, Table]) -> None:
    found = by(gpt_4o["by_action"], "action", "executed")
    wanted = {"OPEN": (23, 23), "SLICE": (0, 4), "SOAK": (16, 17), "CLEAN": (47, 58)}
    assert {action: found[action] for action in wanted} == wanted
    for side, rate in (("RIGHT_", (471, 491)), ("LEFT_", (95, 105))):
        of_side = [made for action, made in found.items() if str(action).startswith(side)]
        assert tuple(sum(number or 0 for number in column) for column in zip(*of_side, strict=True)) == rate


def test_the_share_of_reached_goals_by_predicate_equals_the_papers(gpt_4o: dict[str, Table]) -> None:
    """``ontop`` was 41 of 60 before one reconstruction of a scene served all its answers."""
    found = by(gpt_4o["by_predicate"], "predicate", "reached")
    wanted = {
        "open": (9, 10),
        "soaked": (7, 8),
        "toggled_on": (5, 6),
        "dusty": (24, 30),
        "under": (4, 5),
        "onfloor": (16, 23),
        "ontop": (40, 60),
        "nextto": (27, 57),
        "inside": (47, 139),
        "stained": (13, 40),
        "sliced": (0, 10),
    }
    assert {predicate: found[predicate] for predicate in wanted} == wanted


def test_the_number_of_objects_has_no_effect_beside_the_length_of_plans() -> None:
    """Without other features it lowers success; with length and other features it has no effect."""
    made = tables("behavior", Ability.ACTION_SEQUENCING, MODELS)
    nine = make_task_feature_tables(made, bin_width=10, measure="score")
    adjusted = {row[3]: row[4:6] for row in nine[0].rows}
    found = {
        str(feature): tuple(round(cell.value or 0, 2) for cell in cells if isinstance(cell, Estimate))
        for feature, cells in adjusted.items()
    }
    assert found["log annotated_steps"] == (-0.97, -0.88)
    assert found["log objects"] == (-0.81, 0.31)
    assert found["any tool_steps"] == (-0.57, -0.92)
    together = [row for row in nine[1].rows if row[3] == ALL_MODELS and row[4] == "annotated_steps"]
    assert [round(cell.value or 0, 2) for cell in together[0] if isinstance(cell, Estimate)] == [-0.52]


@pytest.mark.parametrize(
    ("feature", "values", "value", "found"),
    [
        ("annotated_steps", [3, 67], 19, (10, 19)),
        ("goals", [1, 7], 7, (7, 7)),
        ("goals", [1, 15], 15, (14, 15)),
        ("objects", [3, 46], 46, (40, 49)),
        ("goal_options", [1, 331776], 1, (1, 1)),
        ("goal_options", [1, 331776], 9, (2, 9)),
        ("goal_options", [1, 331776], 1000, (1000, 9999)),
    ],
)
def test_bins_of_a_feature_have_the_documented_widths(
    feature: str, values: list[int], value: int, found: tuple[int, int]
) -> None:
    assert make_bin_function(feature, values, 10)(value) == found


def test_a_constant_logarithm_is_no_column_of_the_regression() -> None:
    """The standard deviation of 40 equal logarithms of 7 is not exactly 0."""
    (answer, *_) = tables("behavior", Ability.ACTION_SEQUENCING).answers
    answers = [
        replace(answer, name=str(i), success=i % 3 > 0, annotated_steps=7, objects=i % 2 + 2)
        for i in range(40)
    ]
    (row,) = fit_feature_effects_on_success(answers)
    assert (row[0], row[1]) == ("log objects", row[2])
    assert isinstance(row[2], Estimate)
    assert row[2].value is not None
