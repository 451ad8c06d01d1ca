"""The operators of the reference: those that are the paper's, and quirk by quirk those that are not."""

from __future__ import annotations

import pytest

from benchmarks.virtualhome import flat
from benchmarks.virtualhome.test_operators import (
    AT_BED,
    AT_FRIDGE,
    AT_TABLE,
    AT_TV,
    GRABBED,
    RUNNING,
    STRICT,
    A,
    D,
    M,
    U,
    W,
    get_changes,
    get_fault,
    test_a_failing_action_has_the_fault_of_its_first_failing_check,
    test_an_action_has_its_effects,
    test_grabbing_removes_an_object_from_its_place_and_remembers_the_place,
    test_putting_back_restores_the_remembered_place,
    test_walking_replaces_all_neighbours_by_the_target_and_its_contents,
)
from eai.extensions.reference.virtualhome_quirks import make_domain_with_all_quirks
from eai.world.action import Fault
from eai.world.domain import Domain
from eai.world.execution import attempt_action
from eai.world.fault import FaultKind
from eai.world.history import History
from eai.world.state import State

SHARED = (
    test_grabbing_removes_an_object_from_its_place_and_remembers_the_place,
    test_putting_back_restores_the_remembered_place,
    test_a_failing_action_has_the_fault_of_its_first_failing_check,
    test_walking_replaces_all_neighbours_by_the_target_and_its_contents,
    test_an_action_has_its_effects,
)
"""Tests of the paper's operators, which are run again with the fixture `domain` below."""

REFERENCE = make_domain_with_all_quirks()


@pytest.fixture
def domain() -> Domain:
    return REFERENCE


def test_quirk_leave_held_objects_in_old_room() -> None:
    facts = ("HOLDS_RH character.65 book.16",)
    strict, _ = get_changes(STRICT, facts, "WALK fridge.10")
    reference, _ = get_changes(REFERENCE, facts, "WALK fridge.10")
    assert "INSIDE book.16 kitchen.1" in strict
    assert "INSIDE book.16 kitchen.1" not in reference


def test_quirk_judge_unplugged_device_as_additional_step() -> None:
    assert get_fault(STRICT, AT_TV, "SWITCHON television.22") is M
    assert get_fault(REFERENCE, AT_TV, "SWITCHON television.22") is D


def test_quirk_judge_running_device_as_additional_step() -> None:
    assert get_fault(STRICT, (*AT_FRIDGE, *RUNNING), "OPEN fridge.10") is M
    assert get_fault(REFERENCE, (*AT_FRIDGE, *RUNNING), "OPEN fridge.10") is D


@pytest.mark.parametrize(
    ("facts", "action"),
    [
        ((*AT_FRIDGE, "-OFF fridge.10"), "SWITCHON fridge.10"),
        ((*AT_FRIDGE, "-OFF fridge.10"), "SWITCHOFF fridge.10"),
        ((*AT_FRIDGE, "-CLOSED fridge.10"), "OPEN fridge.10"),
        ((*AT_FRIDGE, "-CLOSED fridge.10"), "CLOSE fridge.10"),
        ((*AT_FRIDGE, "-PLUGGED_IN fridge.10"), "PLUGIN fridge.10"),
        ((*AT_FRIDGE, "-PLUGGED_IN fridge.10"), "PLUGOUT fridge.10"),
    ],
)
def test_quirk_judge_lacking_state_as_additional_step(facts: tuple[str, ...], action: str) -> None:
    assert get_fault(STRICT, facts, action) is A
    assert get_fault(REFERENCE, facts, action) is D


def test_quirk_judge_second_grab_as_additional_step() -> None:
    facts = (*AT_TABLE, *GRABBED)
    assert get_fault(STRICT, facts, "GRAB bread.14") is None
    assert get_fault(REFERENCE, facts, "GRAB bread.14") is D


@pytest.mark.parametrize(
    ("facts", "action"),
    [
        (("SITTING character.65", "ONTOP character.65 chair.21"), "SIT bed.20"),
        (("SITTING character.65",), "SIT bed.20"),
        (("LYING character.65",), "LIE bed.20"),
    ],
)
def test_quirk_judge_seated_elsewhere_as_additional_step(facts: tuple[str, ...], action: str) -> None:
    assert get_fault(STRICT, (*AT_BED, *facts), action) is M
    assert get_fault(REFERENCE, (*AT_BED, *facts), action) is D


def test_quirk_judge_closed_container_as_affordance_error() -> None:
    facts = (*AT_FRIDGE, "HOLDS_RH character.65 cup.13")
    assert get_fault(STRICT, facts, "PUTIN cup.13 fridge.10") is M
    assert get_fault(REFERENCE, facts, "PUTIN cup.13 fridge.10") is A


def test_quirk_let_impossible_put_back_succeed() -> None:
    facts = ("HOLDS_RH character.65 cup.13", "TAKEN_FROM_TOP_OF cup.13 table.12")
    assert get_fault(STRICT, facts, "PUTOBJBACK cup.13") is M
    assert get_changes(REFERENCE, facts, "PUTOBJBACK cup.13") == (set(), set())


@pytest.mark.parametrize(
    ("action", "strict", "reference"),
    [
        ("LOOKAT_LONG television.22", M, U),
        ("PUTOBJBACK cup.13", M, U),
        ("WALK cloud.30", A, U),
    ],
)
def test_quirk_what_the_reference_cannot_execute(
    action: str, strict: FaultKind, reference: FaultKind
) -> None:
    assert get_fault(STRICT, (), action) is strict
    assert get_fault(REFERENCE, (), action) is reference


@pytest.mark.parametrize(
    ("plan", "strict", "reference"),
    [
        # The container was open once: strict looks for that, the reference for an open carton of milk.
        (["WALK fridge.10", "OPEN fridge.10", "CLOSE fridge.10", "GRAB milk.11"], W, M),
        # The bread was near by way of the table only: the reference looks for a direct edge.
        (["WALK table.12", "WALK bed.20", "GRAB bread.14"], W, M),
        (["WALK bread.14", "WALK bed.20", "GRAB bread.14"], W, W),
        # The seat was free once: the reference looks for nothing.
        (["WALK bed.20", "LIE bed.20", "WAKEUP", "WALK table.12"], W, W),
    ],
)
def test_quirk_search_earlier_states_for_other_condition(
    plan: list[str], strict: FaultKind, reference: FaultKind
) -> None:
    for domain, kind in ((STRICT, strict), (REFERENCE, reference)):
        scene = flat.make_scene()
        past = History(flat.make_state(over=scene))
        outcome: State | Fault | None = None
        for step in plan:
            outcome = attempt_action(domain, past, flat.parse_action(step, scene))
            if isinstance(outcome, State):
                past = past.extend(outcome)
        assert isinstance(outcome, Fault)
        assert outcome.kind is kind, domain


def test_quirk_remove_contents_of_grabbed_object() -> None:
    facts = (*AT_TABLE, "INSIDE milk.11 cup.13", "-INSIDE milk.11 fridge.10")
    _, strict = get_changes(STRICT, facts, "GRAB cup.13")
    _, reference = get_changes(REFERENCE, facts, "GRAB cup.13")
    assert "INSIDE milk.11 cup.13" not in strict
    assert "INSIDE milk.11 cup.13" in reference


def test_what_was_poured_goes_along_with_what_it_was_poured_from() -> None:
    facts = ("HOLDS_RH character.65 milk.11", "-INSIDE milk.11 fridge.10", "INSIDE milk.11 cup.13")
    _, removed = get_changes(REFERENCE, facts, "WALK book.16")
    assert "INSIDE milk.11 cup.13" in removed
