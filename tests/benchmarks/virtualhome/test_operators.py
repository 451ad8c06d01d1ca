from __future__ import annotations

import pytest

from benchmarks.virtualhome import flat
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.world.action import Fault
from eai.world.domain import Domain
from eai.world.execution import attempt_action
from eai.world.fault import FaultKind
from eai.world.history import History
from eai.world.state import State, compare_states

STRICT = virtualhome.make_domain_with_checks_in_paper_order()

AT_FRIDGE = ("NEXT_TO character.65 fridge.10",)
AT_TABLE = ("NEXT_TO character.65 table.12",)
AT_BED = ("NEXT_TO character.65 bed.20",)
AT_TV = ("NEXT_TO character.65 television.22",)
RUNNING = ("-OFF fridge.10", "ON fridge.10")
GRABBED = ("TAKEN_FROM_TOP_OF bread.14 table.12",)
HANDS_FULL = ("HOLDS_RH character.65 cup.13", "HOLDS_LH character.65 knife.15")
A = FaultKind.AFFORDANCE
D = FaultKind.ADDITIONAL_STEP
M = FaultKind.MISSING_STEP
W = FaultKind.WRONG_ORDER
U = FaultKind.UNCATEGORISED


@pytest.fixture
def domain() -> Domain:
    """Return the domain with the paper's rules. Tests of other rules override this fixture."""
    return STRICT


def get_fault(domain: Domain, facts: tuple[str, ...], action: str) -> FaultKind | None:
    scene = flat.make_scene()
    outcome = attempt_action(
        domain, History(flat.make_state(*facts, over=scene)), flat.parse_action(action, scene)
    )
    return outcome.kind if isinstance(outcome, Fault) else None


def get_changes(domain: Domain, facts: tuple[str, ...], action: str) -> tuple[set[str], set[str]]:
    """Return the facts that an action adds and removes."""
    scene = flat.make_scene()
    before = flat.make_state(*facts, over=scene)
    outcome = attempt_action(domain, History(before), flat.parse_action(action, scene))
    assert isinstance(outcome, State), outcome
    difference = compare_states(before, outcome)
    return flat.format_facts(difference.added, scene), flat.format_facts(difference.removed, scene)


@pytest.mark.parametrize(
    ("facts", "action", "kind"),
    [
        (("SITTING character.65",), "WALK fridge.10", M),
        (AT_TABLE, "GRAB table.12", A),
        ((), "GRAB cup.13", M),
        (AT_FRIDGE, "GRAB milk.11", M),
        ((*AT_TABLE, *HANDS_FULL), "GRAB bread.14", M),
        ((*AT_TABLE, "HOLDS_LH character.65 bread.14", *GRABBED), "GRAB bread.14", D),
        ((), "SIT bed.20", M),
        ((*AT_BED, "SITTING character.65", "ONTOP character.65 bed.20"), "SIT bed.20", D),
        ((*AT_BED, "NEXT_TO character.65 book.16"), "SIT book.16", A),
        (("NEXT_TO character.65 chair.21", "ONTOP cup.13 chair.21"), "SIT chair.21", M),
        ((*AT_BED, "LYING character.65", "ONTOP character.65 bed.20"), "LIE bed.20", D),
        (AT_TABLE, "LIE table.12", A),
        ((), "STANDUP", D),
        ((), "SLEEP", M),
        (AT_TABLE, "OPEN table.12", A),
        ((), "OPEN fridge.10", M),
        ((*AT_FRIDGE, "-CLOSED fridge.10", "OPEN fridge.10"), "OPEN fridge.10", D),
        ((*AT_FRIDGE, *RUNNING, "-CLOSED fridge.10", "OPEN fridge.10"), "OPEN fridge.10", D),
        ((*AT_FRIDGE, *HANDS_FULL), "OPEN fridge.10", M),
        (AT_FRIDGE, "CLOSE fridge.10", D),
        (AT_TABLE, "PUTBACK cup.13 table.12", M),
        (("HOLDS_RH character.65 cup.13",), "PUTBACK cup.13 table.12", M),
        ((), "SWITCHON table.12", A),
        ((), "SWITCHON fridge.10", M),
        ((*AT_FRIDGE, *RUNNING), "SWITCHON fridge.10", D),
        (AT_FRIDGE, "SWITCHOFF fridge.10", D),
        (AT_FRIDGE, "PLUGIN fridge.10", D),
        ((), "PLUGOUT table.12", A),
        ((), "DRINK book.16", A),
        ((), "DRINK milk.11", M),
        (AT_TABLE, "EAT knife.15", A),
        ((), "EAT bread.14", M),
        (AT_TABLE, "CUT bread.14", M),
        (AT_TABLE, "CUT cup.13", A),
        ((), "READ cup.13", A),
        ((), "READ book.16", M),
        ((), "LOOKAT television.22", M),
        (("FACING character.65 fridge.10",), "WATCH fridge.10", A),
        ((), "WATCH television.22", M),
        ((), "TOUCH cup.13", M),
        (AT_FRIDGE, "TOUCH milk.11", M),
        (("NEXT_TO character.65 book.16",), "TYPE book.16", A),
        (AT_BED, "PULL bed.20", A),
        ((), "MOVE table.12", M),
        ((), "PUSH table.12", M),
        ((), "WASH table.12", M),
        (AT_TABLE, "WIPE table.12", M),
        (AT_TABLE, "SQUEEZE table.12", A),
        ((), "POUR book.16 cup.13", A),
        (("HOLDS_RH character.65 milk.11",), "POUR milk.11 table.12", A),
        ((), "POUR milk.11 cup.13", M),
        ((), "PUTON shirt.17", M),
        ((), "PUTOFF shirt.17", M),
        ((), "DROP cup.13", M),
        ((), "GREET book.16", A),
    ],
)
def test_a_failing_action_has_the_fault_of_its_first_failing_check(
    domain: Domain, facts: tuple[str, ...], action: str, kind: FaultKind
) -> None:
    fault = get_fault(domain, facts, action)
    assert (M if fault is W else fault) is kind, (
        "the history rule, not the check, decides whether an order is wrong"
    )


@pytest.mark.parametrize(
    ("facts", "action", "added", "removed"),
    [
        (AT_FRIDGE, "OPEN fridge.10", {"OPEN fridge.10"}, {"CLOSED fridge.10"}),
        (AT_FRIDGE, "SWITCHON fridge.10", {"ON fridge.10"}, {"OFF fridge.10"}),
        (AT_FRIDGE, "PLUGOUT fridge.10", {"PLUGGED_OUT fridge.10"}, {"PLUGGED_IN fridge.10"}),
        (AT_BED, "LIE bed.20", {"LYING character.65", "ONTOP character.65 bed.20"}, set()),
        (("SITTING character.65",), "STANDUP", set(), {"SITTING character.65"}),
        (("LYING character.65",), "SLEEP", set(), set()),
        (AT_TABLE, "WASH table.12", {"CLEAN table.12"}, {"DIRTY table.12"}),
        (
            (*AT_TABLE, "HOLDS_RH character.65 cup.13"),
            "WIPE table.12",
            {"CLEAN table.12"},
            {"DIRTY table.12"},
        ),
        (
            ("FACING character.65 bed.20",),
            "TURNTO television.22",
            {"FACING character.65 television.22"},
            {"FACING character.65 bed.20"},
        ),
        (
            ("HOLDS_LH character.65 shirt.17",),
            "PUTON shirt.17",
            {"ONTOP shirt.17 character.65"},
            {"HOLDS_LH character.65 shirt.17"},
        ),
        (("ONTOP shirt.17 character.65",), "PUTOFF shirt.17", set(), {"ONTOP shirt.17 character.65"}),
        (
            ("HOLDS_RH character.65 book.16", "TAKEN_FROM_TOP_OF book.16 bed.20"),
            "DROP book.16",
            set(),
            {"HOLDS_RH character.65 book.16", "TAKEN_FROM_TOP_OF book.16 bed.20"},
        ),
        ((), "GREET guest.24", set(), set()),
        (("FACING character.65 television.22",), "WATCH television.22", set(), set()),
        (("NEXT_TO character.65 keyboard.23",), "TYPE keyboard.23", set(), set()),
        (AT_TABLE, "EAT bread.14", set(), set()),
    ],
)
def test_an_action_has_its_effects(
    domain: Domain, facts: tuple[str, ...], action: str, added: set[str], removed: set[str]
) -> None:
    assert get_changes(domain, facts, action) == (added, removed)


def test_walking_replaces_all_neighbours_by_the_target_and_its_contents(domain: Domain) -> None:
    added, removed = get_changes(domain, (*AT_BED, "FACING character.65 bed.20"), "WALK fridge.10")
    assert added >= {"INSIDE character.65 kitchen.1", "NEXT_TO character.65 fridge.10"}
    assert added >= {"NEXT_TO character.65 milk.11", "NEXT_TO character.65 face.70"}
    assert removed == {
        "INSIDE character.65 bedroom.2",
        "NEXT_TO character.65 bed.20",
        "FACING character.65 bed.20",
    }


def test_grabbing_removes_an_object_from_its_place_and_remembers_the_place(domain: Domain) -> None:
    added, removed = get_changes(domain, (*AT_TABLE, "HOLDS_RH character.65 cup.13"), "GRAB bread.14")
    assert added == {
        "HOLDS_LH character.65 bread.14",
        "NEXT_TO character.65 bread.14",
        "NEXT_TO bread.14 character.65",
        "NEXT_TO table.12 character.65",
        "INSIDE bread.14 bedroom.2",
        "TAKEN_FROM_TOP_OF bread.14 table.12",
    }
    assert removed == {"ONTOP bread.14 table.12", "INSIDE bread.14 kitchen.1"}


def test_putting_back_restores_the_remembered_place(domain: Domain) -> None:
    facts = (*AT_TABLE, "-ONTOP cup.13 table.12", "HOLDS_RH character.65 cup.13")
    added, removed = get_changes(domain, (*facts, "TAKEN_FROM_TOP_OF cup.13 table.12"), "PUTOBJBACK cup.13")
    assert {"ONTOP cup.13 table.12"} <= added
    assert removed == {"HOLDS_RH character.65 cup.13", "TAKEN_FROM_TOP_OF cup.13 table.12"}


def test_grabbing_an_object_again_remembers_its_new_place() -> None:
    moved = ("NEXT_TO character.65 bread.14", "-ONTOP bread.14 table.12", "ONTOP bread.14 chair.21", *GRABBED)
    added, removed = get_changes(STRICT, moved, "GRAB bread.14")
    assert "TAKEN_FROM_TOP_OF bread.14 chair.21" in added
    assert {*GRABBED} <= removed


FILLED = (
    *("INSIDE milk.11 cup.13", "-INSIDE milk.11 fridge.10"),
    *("ONTOP bread.14 cup.13", "ONTOP bed.20 cup.13"),
)


def test_contents_move_with_a_grabbed_object_but_a_bed_on_it_does_not() -> None:
    scene = flat.make_scene()
    past = History(flat.make_state(*FILLED, "INSIDE knife.15 milk.11", over=scene))
    for step in ("WALK cup.13", "GRAB cup.13", "WALK book.16", "PUTBACK cup.13 bed.20", "WALK fridge.10"):
        outcome = attempt_action(STRICT, past, flat.parse_action(step, scene))
        assert isinstance(outcome, State)
        past = past.extend(outcome)
    facts = flat.format_facts(past.state.facts(), scene)
    unchanged = {"INSIDE milk.11 cup.13", "ONTOP bread.14 cup.13", "INSIDE knife.15 milk.11"}
    moved = {"ONTOP cup.13 bed.20"}
    moved |= {f"INSIDE {name} bedroom.2" for name in ("cup.13", "milk.11", "bread.14", "knife.15")}
    assert facts >= unchanged | moved
    assert facts.isdisjoint({"ONTOP bed.20 cup.13", "INSIDE milk.11 kitchen.1"})
    assert isinstance(attempt_action(STRICT, past, flat.parse_action("WALK cup.13", scene)), State)
    near = past.extend(attempt_action(STRICT, past, flat.parse_action("WALK cup.13", scene)))  # type: ignore[arg-type]
    assert isinstance(attempt_action(STRICT, near, flat.parse_action("GRAB milk.11", scene)), State)


def test_a_poured_liquid_stays_in_its_cup_when_the_character_walks() -> None:
    facts = ("HOLDS_RH character.65 milk.11", "-INSIDE milk.11 fridge.10", "INSIDE milk.11 cup.13")
    _, removed = get_changes(STRICT, facts, "WALK book.16")
    assert "INSIDE milk.11 cup.13" not in removed
