"""BDDL printed and read back."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings

from eai.errors import InputError
from eai.logic.bddl import parse_condition
from eai.logic.bddl_printer import print_condition
from eai.logic.formula import (
    Atom,
    Constant,
    Equals,
    ForAll,
    Formula,
    Next,
    Variable,
)
from eai.logic.signature import Signature
from eai.logic.traversal import walk
from logic.activities import as_text
from logic.random_formulas import formulas


@pytest.mark.parametrize(
    "formula",
    [
        Next(Atom("p")),
        Equals(Constant("a"), Constant("a")),
        ForAll(Variable("x"), Atom("p", (Variable("x"),))),
    ],
)
def test_what_bddl_cannot_say_is_an_error(formula: Formula) -> None:
    with pytest.raises(InputError, match="BDDL"):
        print_condition(formula)


@given(formulas(temporal=False))
@settings(max_examples=100)
def test_what_is_printed_is_read_back(formula: Formula) -> None:
    if all(not isinstance(part, Equals) for part in walk(formula)):
        try:
            text = print_condition(formula)
        except InputError:
            return
        signature = Signature(
            {"open": 1, "next_to": 2, "notable": 1, "-raining": 0}, {"grab": 1, "pour": 2, "sleep": 0}
        )
        assert parse_condition(text, signature).formula == formula


def test_all_goals_of_the_data_set_survive_the_round_trip(oracle: Any) -> None:
    goals = [
        goal for record in oracle("behavior", "", "reconstructed").values() for goal in record["bddl_goal"]
    ]
    assert len(goals) == 366
    for goal in goals:
        formula = parse_condition(as_text(goal)).formula
        assert parse_condition(print_condition(formula)).formula == formula
