"""The operators of the reference: those that are the paper's, and quirk by quirk those that are not."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.behavior.test_operators import (
    CUT,
    LAST_STEPS,
    ON_TABLE,
    PEACH,
    STRICT,
    has,
    outcome,
    run,
    test_a_dishwasher_cleans_its_contents,
    test_a_placed_object_has_its_new_relations,
    test_cleaning_removes_only_the_dirt_that_the_tool_can_remove,
    test_grasping_ends_all_loose_relations_of_the_object,
    test_grasping_lifts_the_cargo_except_much_larger_objects,
    test_slicing_replaces_an_object_by_its_halves,
)
from eai.benchmarks.behavior import domain as behavior
from eai.extensions.reference import behavior_quirks
from eai.world.domain import Domain
from eai.world.fault import FaultKind

SHARED = (
    test_a_dishwasher_cleans_its_contents,
    test_cleaning_removes_only_the_dirt_that_the_tool_can_remove,
    test_grasping_ends_all_loose_relations_of_the_object,
    test_slicing_replaces_an_object_by_its_halves,
    test_grasping_lifts_the_cargo_except_much_larger_objects,
    test_a_placed_object_has_its_new_relations,
)
"""Tests of the paper's operators, which are run again with the fixture `domain` below."""

REFERENCE = behavior_quirks.make_domain_with_all_quirks()
OTHERWISE = {
    ("RIGHT_GRASP rag_1", "LEFT_GRASP rag_1"): "additional_step",
    ("RIGHT_RELEASE rag_1",): "missing_step",
    (*ON_TABLE, "RIGHT_PLACE_ONTOP sink_1"): "missing_step",
    ("RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE room_floor_kitchen_0"): "uncategorised",
    ("RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_ONTOP fridge_1"): "uncategorised",
    ("LEFT_GRASP rag_1", "RIGHT_GRASP plate_1", "OPEN table_1"): "missing_step",
    (*PEACH, "FREEZE peach_1"): "ok",
    ("RIGHT_GRASP peach_1_part_0",): "ok",
    ("NAVIGATE_TO car_1",): "uncategorised",
}
"""Outcomes of last steps that are not those of the paper's rules."""


@pytest.fixture
def domain() -> Domain:
    return REFERENCE


@pytest.mark.parametrize(("steps", "strict"), LAST_STEPS)
def test_outcome_of_the_last_step(steps: list[str], strict: str) -> None:
    assert outcome(run(REFERENCE, *steps)) == OTHERWISE.get(tuple(steps), strict)


def test_what_is_released_stays_in_the_air() -> None:
    in_air = run(REFERENCE, "RIGHT_GRASP rag_1", "RIGHT_RELEASE rag_1").final_state
    assert not has(in_air, "stands_on rag_1 room_floor_kitchen_0")


def test_a_transfer_of_contents_aborts() -> None:
    steps = ("RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_ONTOP room_floor_garage_0")
    aborted = run(REFERENCE, *steps)
    left = behavior_quirks.find_state_left_by_aborted_action(aborted.final_state, aborted.steps[-1].action)
    assert [has(left, f"lies_on {plate} table_1") for plate in ("plate_1", "plate_2")] == [False, True]


def test_in_the_reference_the_last_label_of_a_pair_counts() -> None:
    steps = ("RIGHT_GRASP rag_1", "RIGHT_PLACE_NEXTTO room_floor_garage_0")
    labels = ("stands_by rag_1 room_floor_garage_0", "stands_on rag_1 room_floor_garage_0")
    assert [has(run(STRICT, *steps).final_state, label) for label in labels] == [True, True]
    assert [has(run(REFERENCE, *steps).final_state, label) for label in labels] == [False, True]


def test_subgoals_rank_kinds_of_error_differently_in_the_reference() -> None:
    domain = behavior_quirks.make_subgoal_domain_with_all_quirks()
    steps = (*CUT, "OPEN dishwasher_1", "LEFT_GRASP peach_1")
    (fault,) = (step.fault for step in run(REFERENCE, *steps).steps if step.fault is not None)
    assert fault.kind is FaultKind.AFFORDANCE
    assert outcome(run(domain, *steps)) == "wrong_order"


@pytest.mark.parametrize("quirk", behavior_quirks.QUIRKS, ids=lambda quirk: quirk.__name__)
def test_each_quirk_changes_the_domain_and_says_what(quirk: Any) -> None:
    declared = behavior.make_domain_with_checks_in_reference_order()
    assert quirk(declared) != declared
    assert "``" in quirk.__doc__  # its place in the reference
