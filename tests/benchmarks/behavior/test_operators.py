from __future__ import annotations

import pytest

from benchmarks.behavior.kitchen import make_task, parse_actions
from eai.benchmarks.behavior import domain as behavior
from eai.world.domain import Domain
from eai.world.execution import Trajectory, execute_plan
from eai.world.state import State

STRICT = behavior.make_domain_with_checks_in_paper_order()
ON_TABLE = ("RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP table_1")
PEACH = ("OPEN fridge_1", "RIGHT_GRASP peach_1")
CUT = ("OPEN fridge_1", "RIGHT_GRASP carving_knife_1", "SLICE peach_1")


@pytest.fixture
def domain() -> Domain:
    """Return the domain with the paper's rules. Tests of other rules override this fixture."""
    return STRICT


def run(domain: Domain, *steps: str) -> Trajectory:
    initial = make_task().initial
    return execute_plan(domain, initial, parse_actions(initial, *steps))


def outcome(trajectory: Trajectory) -> str:
    """Return the outcome of the last attempted step."""
    fault = trajectory.steps[-1].fault
    return "ok" if fault is None else fault.kind.value


def has(state: State, fact: str) -> bool:
    predicate, *names = fact.split()
    return state.has(predicate, *(state.scene.index[name] for name in names))


LAST_STEPS = [
        # Hands.
        (["RIGHT_GRASP rag_1"], "ok"),
        (["RIGHT_GRASP room_floor_kitchen_0"], "affordance"),
        (["RIGHT_GRASP car_1"], "affordance"),
        (["RIGHT_GRASP rag_1", "RIGHT_GRASP rag_1"], "additional_step"),
        (["RIGHT_GRASP rag_1", "LEFT_GRASP rag_1"], "wrong_order"),
        (["RIGHT_GRASP rag_1", "RIGHT_GRASP plate_1"], "wrong_order"),
        (["RIGHT_GRASP peach_1"], "missing_step"),
        (["OPEN fridge_1", "CLOSE fridge_1", "RIGHT_GRASP peach_1"], "wrong_order"),
        (["RIGHT_RELEASE rag_1"], "additional_step"),
        (["RIGHT_RELEASE pebble_1"], "additional_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_RELEASE plate_1"], "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_RELEASE rag_1"], "ok"),
        # Placing.
        (["RIGHT_PLACE_ONTOP table_1"], "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP rag_1"], "missing_step"),
        ([*ON_TABLE, "RIGHT_PLACE_ONTOP sink_1"], "wrong_order"),
        (["RIGHT_GRASP table_1", "RIGHT_PLACE_ONTOP plate_1"], "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE fridge_1"], "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE pebble_1"], "affordance"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE room_floor_kitchen_0"], "affordance"),
        (["OPEN fridge_1", "RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE fridge_1"], "ok"),
        # Contents.
        (["RIGHT_GRASP plate_1", "RIGHT_TRANSFER_CONTENTS_ONTOP table_1"], "affordance"),
        (["RIGHT_GRASP plate_1", "RIGHT_TRANSFER_CONTENTS_INSIDE sink_1"], "ok"),
        (["RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_INSIDE pebble_1"], "affordance"),
        (["RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_ONTOP fridge_1"], "ok"),
        # States.
        (["OPEN table_1"], "affordance"),
        (["OPEN carton_1"], "additional_step"),
        (["CLOSE carton_1"], "ok"),
        (["LEFT_GRASP rag_1", "RIGHT_GRASP plate_1", "OPEN fridge_1"], "wrong_order"),
        (["LEFT_GRASP rag_1", "RIGHT_GRASP plate_1", "OPEN table_1"], "affordance"),
        (["TOGGLE_ON dishwasher_1", "OPEN dishwasher_1"], "wrong_order"),
        (["OPEN dishwasher_1", "TOGGLE_ON dishwasher_1"], "wrong_order"),
        (["TOGGLE_OFF sink_1"], "additional_step"),
        (["SOAK rag_1"], "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP sink_1", "SOAK rag_1"], "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP sink_1", "TOGGLE_ON sink_1", "SOAK rag_1"], "ok"),
        (["DRY rag_1"], "additional_step"),
        (["COOK peach_1"], "missing_step"),
        ([*PEACH, "RIGHT_PLACE_INSIDE saucepan_1", "COOK peach_1"], "ok"),
        (["OPEN fridge_1", "FREEZE peach_1"], "ok"),
        ([*PEACH, "FREEZE peach_1"], "wrong_order"),
        (["UNFREEZE carving_knife_1"], "affordance"),
        # Slicing.
        (["OPEN fridge_1", "SLICE peach_1"], "missing_step"),
        ([*CUT], "ok"),
        ([*CUT, "LEFT_GRASP peach_1"], "affordance"),
        ([*CUT, "LEFT_GRASP peach_1_part_0"], "ok"),
        (["RIGHT_GRASP peach_1_part_0"], "missing_step"),
        # Cleaning.
        (["CLEAN peach_1"], "affordance"),
        (["CLEAN sink_1"], "additional_step"),
        (["CLEAN plate_1"], "missing_step"),
        (["RIGHT_GRASP rag_1", "CLEAN plate_1"], "ok"),
        ([*ON_TABLE, "CLEAN plate_2"], "wrong_order"),
        ([*ON_TABLE, "CLEAN plate_1"], "wrong_order"),
        # Navigation.
        (["NAVIGATE_TO car_1"], "ok"),
    ]  # fmt: skip


@pytest.mark.parametrize(("steps", "expected"), LAST_STEPS)
def test_the_last_step_has_its_expected_outcome(steps: list[str], expected: str) -> None:
    assert outcome(run(STRICT, *steps)) == expected


def test_grasping_lifts_the_cargo_except_much_larger_objects(domain: Domain) -> None:
    steps = ("RIGHT_GRASP plate_1", "RIGHT_PLACE_ONTOP pebble_1", "RIGHT_GRASP pebble_1")
    assert not has(run(domain, *steps).final_state, "lies_on plate_1 pebble_1")
    final = run(domain, "RIGHT_GRASP table_1").final_state
    assert has(final, "lies_on plate_1 table_1")
    assert not has(final, "stands_on table_1 room_floor_kitchen_0")


def test_grasping_ends_all_loose_relations_of_the_object(domain: Domain) -> None:
    final = run(domain, "RIGHT_GRASP rag_1").final_state
    assert not has(final, "stands_by rag_1 rag_10")
    assert not has(final, "stands_by rag_10 rag_1")
    assert not has(final, "stands_on rag_1 room_floor_kitchen_0")


@pytest.mark.parametrize(
    ("step", "facts"),
    [
        ("RIGHT_PLACE_NEXTTO plate_1", ["stands_by rag_1 plate_1", "stands_by plate_1 rag_1"]),
        ("RIGHT_PLACE_NEXTTO plate_1", ["lies_on rag_1 table_1"]),
        ("RIGHT_PLACE_NEXTTO sink_1", ["stands_by rag_1 sink_1", "stands_on rag_1 room_floor_kitchen_0"]),
        ("RIGHT_PLACE_UNDER plate_1", ["stands_under rag_1 plate_1", "lies_on rag_1 table_1"]),
        ("RIGHT_PLACE_ONTOP room_floor_garage_0", ["stands_on rag_1 room_floor_garage_0"]),
        ("RIGHT_PLACE_NEXTTO_ONTOP plate_1 sink_1", ["stands_by rag_1 plate_1", "lies_on rag_1 sink_1"]),
        ("RIGHT_PLACE_INSIDE carton_1", ["lies_in rag_1 carton_1"]),
    ],
)  # fmt: skip
def test_a_placed_object_has_its_new_relations(domain: Domain, step: str, facts: list[str]) -> None:
    trajectory = run(domain, "RIGHT_GRASP rag_1", step)
    assert outcome(trajectory) == "ok"
    assert [fact for fact in facts if not has(trajectory.final_state, fact)] == []
    assert not has(trajectory.final_state, "in_right_hand rag_1")


def test_slicing_replaces_an_object_by_its_halves(domain: Domain) -> None:
    final = run(domain, *CUT, "LEFT_GRASP peach_1_part_0").final_state
    assert not has(final, "lies_in peach_1 fridge_1")
    assert has(final, "lies_in peach_1_part_1 fridge_1")
    assert has(final, "in_left_hand peach_1_part_0")
    frozen = run(domain, "OPEN fridge_1", "FREEZE peach_1", *CUT[1:]).final_state
    assert has(frozen, "is_frozen peach_1_part_0")
    assert has(frozen, "is_sliced peach_1_part_1")


def test_cleaning_removes_only_the_dirt_that_the_tool_can_remove(domain: Domain) -> None:
    dry = run(domain, "RIGHT_GRASP rag_1", "CLEAN plate_1").final_state
    assert not has(dry, "is_dusty plate_1")
    assert has(dry, "is_stained plate_1")
    soap = run(domain, "RIGHT_GRASP detergent_1", "CLEAN plate_1").final_state
    assert has(soap, "is_dusty plate_1")
    assert not has(soap, "is_stained plate_1")


def test_a_dishwasher_cleans_its_contents(domain: Domain) -> None:
    steps = (
        "OPEN dishwasher_1",
        "RIGHT_GRASP plate_1",
        "RIGHT_PLACE_INSIDE dishwasher_1",
        "CLOSE dishwasher_1",
    )
    final = run(domain, *steps, "TOGGLE_ON dishwasher_1").final_state
    assert not has(final, "is_dusty plate_1")
    assert not has(final, "is_stained plate_1")
    assert has(final, "is_dusty plate_2")


def test_a_released_object_stands_on_the_floor_of_the_robot() -> None:
    steps = ("RIGHT_GRASP rag_1", "NAVIGATE_TO car_1", "RIGHT_RELEASE rag_1")
    assert has(run(STRICT, *steps).final_state, "stands_on rag_1 room_floor_garage_0")


def test_contents_are_transferred_to_another_support() -> None:
    steps = ("RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_ONTOP room_floor_garage_0")
    final = run(STRICT, *steps).final_state
    assert has(final, "stands_on plate_1 room_floor_garage_0")
    assert not has(final, "lies_on plate_2 table_1")


def test_an_object_placed_next_to_a_floor_stands_on_it() -> None:
    steps = ("RIGHT_GRASP rag_1", "RIGHT_PLACE_NEXTTO room_floor_garage_0")
    labels = ("stands_by rag_1 room_floor_garage_0", "stands_on rag_1 room_floor_garage_0")
    assert [has(run(STRICT, *steps).final_state, label) for label in labels] == [True, True]
