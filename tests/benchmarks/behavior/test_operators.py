from __future__ import annotations

from typing import Any

import pytest

from benchmarks.behavior.kitchen import actions, make_task
from eai.benchmarks.behavior import domain as behavior
from eai.world.domain import Domain
from eai.world.execution import Trajectory, execute
from eai.world.fault import FaultKind
from eai.world.state import State
from protocols import of_reference

behavior_quirks = of_reference("behavior_quirks")

STRICT, REFERENCE = behavior.as_meant(), behavior_quirks.as_in_reference()
BOTH = pytest.mark.parametrize("domain", [STRICT, REFERENCE], ids=["strict", "eai-1.0.5"])
ON_TABLE = ("RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP table_1")
PEACH = ("OPEN fridge_1", "RIGHT_GRASP peach_1")
CUT = ("OPEN fridge_1", "RIGHT_GRASP carving_knife_1", "SLICE peach_1")


def run(domain: Domain, *steps: str) -> Trajectory:
    initial = make_task().initial
    return execute(domain, initial, actions(initial, *steps))


def outcome(trajectory: Trajectory) -> str:
    """What became of the last step that was tried."""
    fault = trajectory.steps[-1].fault
    return "ok" if fault is None else fault.kind.value


def has(state: State, fact: str) -> bool:
    predicate, *names = fact.split()
    return state.has(predicate, *(state.scene.index[name] for name in names))


@pytest.mark.parametrize(
    ("steps", "strict", "reference"),
    [
        # Hands.
        (["RIGHT_GRASP rag_1"], "ok", "ok"),
        (["RIGHT_GRASP room_floor_kitchen_0"], "affordance", "affordance"),
        (["RIGHT_GRASP car_1"], "affordance", "affordance"),
        (["RIGHT_GRASP rag_1", "RIGHT_GRASP rag_1"], "additional_step", "additional_step"),
        (["RIGHT_GRASP rag_1", "LEFT_GRASP rag_1"], "wrong_order", "additional_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_GRASP plate_1"], "wrong_order", "wrong_order"),
        (["RIGHT_GRASP peach_1"], "missing_step", "missing_step"),
        (["OPEN fridge_1", "CLOSE fridge_1", "RIGHT_GRASP peach_1"], "wrong_order", "wrong_order"),
        (["RIGHT_RELEASE rag_1"], "additional_step", "missing_step"),
        (["RIGHT_RELEASE pebble_1"], "additional_step", "additional_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_RELEASE plate_1"], "missing_step", "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_RELEASE rag_1"], "ok", "ok"),
        # Placing.
        (["RIGHT_PLACE_ONTOP table_1"], "missing_step", "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP rag_1"], "missing_step", "missing_step"),
        ([*ON_TABLE, "RIGHT_PLACE_ONTOP sink_1"], "wrong_order", "missing_step"),
        (["RIGHT_GRASP table_1", "RIGHT_PLACE_ONTOP plate_1"], "missing_step", "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE fridge_1"], "missing_step", "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE pebble_1"], "affordance", "affordance"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE room_floor_kitchen_0"], "affordance", "uncategorised"),
        (["OPEN fridge_1", "RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE fridge_1"], "ok", "ok"),
        # Contents.
        (["RIGHT_GRASP plate_1", "RIGHT_TRANSFER_CONTENTS_ONTOP table_1"], "affordance", "affordance"),
        (["RIGHT_GRASP plate_1", "RIGHT_TRANSFER_CONTENTS_INSIDE sink_1"], "ok", "ok"),
        (["RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_INSIDE pebble_1"], "affordance", "affordance"),
        (["RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_ONTOP fridge_1"], "ok", "uncategorised"),
        # States.
        (["OPEN table_1"], "affordance", "affordance"),
        (["OPEN carton_1"], "additional_step", "additional_step"),
        (["CLOSE carton_1"], "ok", "ok"),
        (["LEFT_GRASP rag_1", "RIGHT_GRASP plate_1", "OPEN fridge_1"], "wrong_order", "wrong_order"),
        (["LEFT_GRASP rag_1", "RIGHT_GRASP plate_1", "OPEN table_1"], "affordance", "missing_step"),
        (["TOGGLE_ON dishwasher_1", "OPEN dishwasher_1"], "wrong_order", "wrong_order"),
        (["OPEN dishwasher_1", "TOGGLE_ON dishwasher_1"], "wrong_order", "wrong_order"),
        (["TOGGLE_OFF sink_1"], "additional_step", "additional_step"),
        (["SOAK rag_1"], "missing_step", "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP sink_1", "SOAK rag_1"], "missing_step", "missing_step"),
        (["RIGHT_GRASP rag_1", "RIGHT_PLACE_ONTOP sink_1", "TOGGLE_ON sink_1", "SOAK rag_1"], "ok", "ok"),
        (["DRY rag_1"], "additional_step", "additional_step"),
        (["COOK peach_1"], "missing_step", "missing_step"),
        ([*PEACH, "RIGHT_PLACE_INSIDE saucepan_1", "COOK peach_1"], "ok", "ok"),
        (["OPEN fridge_1", "FREEZE peach_1"], "ok", "ok"),
        ([*PEACH, "FREEZE peach_1"], "wrong_order", "ok"),
        (["UNFREEZE carving_knife_1"], "affordance", "affordance"),
        # Slicing.
        (["OPEN fridge_1", "SLICE peach_1"], "missing_step", "missing_step"),
        ([*CUT], "ok", "ok"),
        ([*CUT, "LEFT_GRASP peach_1"], "affordance", "affordance"),
        ([*CUT, "LEFT_GRASP peach_1_part_0"], "ok", "ok"),
        (["RIGHT_GRASP peach_1_part_0"], "missing_step", "ok"),
        # Cleaning.
        (["CLEAN peach_1"], "affordance", "affordance"),
        (["CLEAN sink_1"], "additional_step", "additional_step"),
        (["CLEAN plate_1"], "missing_step", "missing_step"),
        (["RIGHT_GRASP rag_1", "CLEAN plate_1"], "ok", "ok"),
        ([*ON_TABLE, "CLEAN plate_2"], "wrong_order", "wrong_order"),
        ([*ON_TABLE, "CLEAN plate_1"], "wrong_order", "wrong_order"),
        # Going.
        (["NAVIGATE_TO car_1"], "ok", "uncategorised"),
    ],
)  # fmt: skip
def test_outcome_of_the_last_step(steps: list[str], strict: str, reference: str) -> None:
    assert (outcome(run(STRICT, *steps)), outcome(run(REFERENCE, *steps))) == (strict, reference)


@BOTH
def test_what_is_carried_comes_along_but_for_what_is_much_larger(domain: Domain) -> None:
    steps = ("RIGHT_GRASP plate_1", "RIGHT_PLACE_ONTOP pebble_1", "RIGHT_GRASP pebble_1")
    assert not has(run(domain, *steps).final, "lies_on plate_1 pebble_1")
    after = run(domain, "RIGHT_GRASP table_1").final
    assert has(after, "lies_on plate_1 table_1")
    assert not has(after, "stands_on table_1 room_floor_kitchen_0")


@BOTH
def test_grasping_ends_all_labels_of_the_object(domain: Domain) -> None:
    after = run(domain, "RIGHT_GRASP rag_1").final
    assert not has(after, "stands_by rag_1 rag_10")
    assert not has(after, "stands_by rag_10 rag_1")
    assert not has(after, "stands_on rag_1 room_floor_kitchen_0")


@BOTH
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
def test_where_placed_objects_are(domain: Domain, step: str, facts: list[str]) -> None:
    trajectory = run(domain, "RIGHT_GRASP rag_1", step)
    assert outcome(trajectory) == "ok"
    assert [fact for fact in facts if not has(trajectory.final, fact)] == []
    assert not has(trajectory.final, "in_right_hand rag_1")


@BOTH
def test_slicing_replaces_an_object_by_its_parts(domain: Domain) -> None:
    after = run(domain, *CUT, "LEFT_GRASP peach_1_part_0").final
    assert not has(after, "lies_in peach_1 fridge_1")
    assert has(after, "lies_in peach_1_part_1 fridge_1")
    assert has(after, "in_left_hand peach_1_part_0")
    frozen = run(domain, "OPEN fridge_1", "FREEZE peach_1", *CUT[1:]).final
    assert has(frozen, "is_frozen peach_1_part_0")
    assert has(frozen, "is_sliced peach_1_part_1")


@BOTH
def test_cleaning_takes_off_what_the_means_suffice_for(domain: Domain) -> None:
    dry = run(domain, "RIGHT_GRASP rag_1", "CLEAN plate_1").final
    assert not has(dry, "is_dusty plate_1")
    assert has(dry, "is_stained plate_1")
    soap = run(domain, "RIGHT_GRASP detergent_1", "CLEAN plate_1").final
    assert has(soap, "is_dusty plate_1")
    assert not has(soap, "is_stained plate_1")


@BOTH
def test_a_dishwasher_cleans_its_contents(domain: Domain) -> None:
    steps = (
        "OPEN dishwasher_1",
        "RIGHT_GRASP plate_1",
        "RIGHT_PLACE_INSIDE dishwasher_1",
        "CLOSE dishwasher_1",
    )
    after = run(domain, *steps, "TOGGLE_ON dishwasher_1").final
    assert not has(after, "is_dusty plate_1")
    assert not has(after, "is_stained plate_1")
    assert has(after, "is_dusty plate_2")


def test_what_is_released_stands_on_the_floor_where_the_robot_is() -> None:
    steps = ("RIGHT_GRASP rag_1", "NAVIGATE_TO car_1", "RIGHT_RELEASE rag_1")
    assert has(run(STRICT, *steps).final, "stands_on rag_1 room_floor_garage_0")
    in_air = run(REFERENCE, "RIGHT_GRASP rag_1", "RIGHT_RELEASE rag_1").final
    assert not has(in_air, "stands_on rag_1 room_floor_kitchen_0")


def test_contents_are_transferred_or_abort_the_reference() -> None:
    steps = ("RIGHT_GRASP table_1", "RIGHT_TRANSFER_CONTENTS_ONTOP room_floor_garage_0")
    after = run(STRICT, *steps).final
    assert has(after, "stands_on plate_1 room_floor_garage_0")
    assert not has(after, "lies_on plate_2 table_1")
    aborted = run(REFERENCE, *steps)
    left = behavior_quirks.half_done(aborted.final, aborted.steps[-1].action)
    assert [has(left, f"lies_on {plate} table_1") for plate in ("plate_1", "plate_2")] == [False, True]


def test_in_the_reference_the_last_label_of_a_pair_counts() -> None:
    steps = ("RIGHT_GRASP rag_1", "RIGHT_PLACE_NEXTTO room_floor_garage_0")
    labels = ("stands_by rag_1 room_floor_garage_0", "stands_on rag_1 room_floor_garage_0")
    assert [has(run(STRICT, *steps).final, label) for label in labels] == [True, True]
    assert [has(run(REFERENCE, *steps).final, label) for label in labels] == [False, True]


def test_subgoals_rank_kinds_of_error_differently_in_the_reference() -> None:
    domain = behavior_quirks.as_in_reference_subgoals()
    steps = (*CUT, "OPEN dishwasher_1", "LEFT_GRASP peach_1")
    (fault,) = (step.fault for step in run(REFERENCE, *steps).steps if step.fault is not None)
    assert fault.kind is FaultKind.AFFORDANCE
    assert outcome(run(domain, *steps)) == "wrong_order"


@pytest.mark.parametrize("quirk", behavior_quirks.QUIRKS, ids=lambda quirk: quirk.__name__)
def test_each_quirk_changes_the_domain_and_says_what(quirk: Any) -> None:
    declared = behavior.as_declared()
    assert quirk(declared) != declared
    assert "``" in quirk.__doc__  # its place in the reference
