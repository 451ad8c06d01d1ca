"""Traces: truth values and actions as masks of positions."""

from __future__ import annotations

import pytest

from eai.base.errors import InputError
from eai.logic.trace import Trace, iterate_positions
from logic.naive import Facts
from logic.random_formulas import SCENE, trace


def test_numbers_of_states_and_actions_must_fit() -> None:
    with pytest.raises(InputError, match="0 states"):
        Trace([])
    with pytest.raises(InputError, match="one action fewer than states"):
        Trace([Facts(frozenset(), ())], [("GRAB", ())])


def test_masks_have_one_bit_for_each_position() -> None:
    path = trace("p", "GRAB", "q", "PUT", "p", "GRAB", "")
    assert path.length == 4
    assert path.find_positions_of_atom("p", ()) == 0b0101
    assert path.find_positions_of_atom("unknown", ("x",)) == 0
    assert path.find_positions_of_action("GRAB", ()) == 0b0101
    assert path.find_positions_of_action("GRAB", ("x",)) == 0
    assert list(iterate_positions(0b1011)) == [0, 1, 3]


def test_participants_are_the_arguments_that_occur() -> None:
    state = Facts(frozenset(), SCENE)
    actions = [
        ("POUR", ("a", "b")),
        ("POUR", ("c", "b")),
        ("POUR", ("d",)),
        ("GRAB", ("e",)),
    ]
    path = Trace([state] * 5, actions)
    assert path.find_values_of_argument("POUR", 0) == {"a", "c", "d"}
    assert path.find_values_of_argument("POUR", 1) == {"b"}
    assert path.find_values_of_argument("DROP", 0) == set()


def test_each_truth_value_is_computed_once() -> None:
    class Counting(Facts):
        asked = 0

        def holds(self, predicate: str, arguments: tuple[str, ...]) -> bool:
            Counting.asked += 1
            return super().holds(predicate, arguments)

    path = Trace([Counting(frozenset(), SCENE)] * 3)
    assert path.find_positions_of_atom("p", ()) == path.find_positions_of_atom("p", ()) == 0
    assert Counting.asked == 3
    assert path.list_objects("cup") == ["cup.1", "cup.2"]
    assert path.get_object_set(None) == {"cup.1", "cup.2", "sofa"}
