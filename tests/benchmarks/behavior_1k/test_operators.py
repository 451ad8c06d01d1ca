"""Effects and faults of actions in a small hand-made scene."""

from __future__ import annotations

import pytest

from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.operators import build_domain
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.fault import FaultKind
from eai.world.state import Fact, Scene, State, WorldObject

OBJECTS = (
    *("floor", "sink", "oven", "pan", "bowl", "knife", "rag", "spoon", "apple", "half_1", "half_2", "plate"),
    *("water", "soap", "stain", "dust", "dice", "flour", "dough", "loaf", "recipe_1", "recipe_2"),
)
FACTS = """
floor floor; fixed sink; fixed oven; sink sink; fillable sink; container sink; toggleable sink
toggleable oven; openable oven; container oven; heat_source oven; works_on oven; works_closed oven
works_inside oven; container pan; fillable pan; container bowl; fillable bowl; slicer knife; mixing_tool spoon
absorbent rag; sliceable apple; diceable half_1; diceable half_2; part_of half_1 apple; part_of half_2 apple
diced_as half_1 dice; diced_as half_2 dice; gives sink water; substance water; liquid water; substance soap
liquid soap; substance stain; visual stain; substance dust; visual dust; substance dice; substance flour
substance dough; water water; heatable apple; cooks oven apple; heatable pan; cooks oven dough
removes_dry rag dust; removes_soaked rag stain; dissolved_by stain soap; washes_off sink dust
recipe recipe_1; by_stirring recipe_1; ingredient recipe_1 flour; ingredient recipe_1 water
makes recipe_1 dough; product dough; recipe recipe_2; by_heat recipe_2; relaxed recipe_2; product loaf
ingredient recipe_2 dough; makes recipe_2 loaf; made_in recipe_2 pan; heated_by recipe_2 oven
present floor; present sink; present oven; present pan; present bowl; present knife; present rag
present spoon; present apple; present plate; present water; present soap; present stain; present dust
present flour; lies_on pan floor; lies_on bowl floor; lies_on knife floor; lies_on rag floor
lies_on spoon floor; lies_on apple floor; lies_on plate floor; has_in bowl flour; full_of bowl flour
by_floor sink floor; by_floor oven floor; robot_on floor
"""


@pytest.fixture(scope="module")
def domain() -> Domain:
    return build_domain()


def make_state(*more: str) -> State:
    scene = Scene(p.VOCABULARY, [WorldObject(name, name.partition("_")[0]) for name in OBJECTS])
    lines = [*FACTS.replace("\n", ";").split(";"), *more]
    facts = [line.split() for line in lines if line.strip()]
    return scene.state([Fact(name, tuple(scene.index[o] for o in objects)) for name, *objects in facts])


def parse_plan(initial: State, text: str) -> list[Action]:
    steps = [step.split() for step in text.split(";")]
    return [Action(name, tuple(initial.scene.index[o] for o in objects)) for name, *objects in steps]


def run_plan(domain: Domain, initial: State, text: str) -> State:
    trajectory = execute_plan(domain, initial, parse_plan(initial, text))
    assert trajectory.failure is None, trajectory.failure
    return trajectory.final_state


def holds(reached: State, fact: str) -> bool:
    name, *objects = fact.split()
    return reached.has(name, *(reached.scene.index[each] for each in objects))


@pytest.mark.parametrize(
    ("before", "steps", "then", "no_more"),
    [
        ((), "GRASP rag", ["held rag"], ["lies_on rag floor"]),
        ((), "GRASP apple;PLACE_INSIDE apple bowl;GRASP bowl", ["lies_in apple bowl", "held bowl"], []),
        ((), "GRASP pan;RELEASE pan", ["lies_on pan floor"], ["held pan"]),
        (
            (),
            "GRASP pan;PLACE_NEXTTO pan bowl",
            ["stands_by pan bowl", "stands_by bowl pan", "lies_on pan floor"],
            [],
        ),
        (
            (),
            "GRASP pan;PLACE_BETWEEN pan bowl plate",
            ["stands_by pan bowl", "stands_by plate pan"],
            ["stands_by bowl plate"],
        ),
        (("has_cover plate dust",), "GRASP rag;WIPE plate rag", [], ["has_cover plate dust"]),
        (
            ("has_cover plate stain", "has_in pan soap"),
            "GRASP rag;SOAK rag pan;WIPE plate rag",
            ["soaked_with rag soap"],
            ["has_cover plate stain"],
        ),
        (
            ("has_cover plate dust",),
            "TOGGLE_ON sink;GRASP plate;RINSE plate sink",
            [],
            ["has_cover plate dust"],
        ),
        (
            (),
            "GRASP knife;SLICE apple knife",
            ["present half_1", "present half_2", "lies_on half_1 floor"],
            ["present apple", "lies_on apple floor"],
        ),
        (
            (),
            "GRASP knife;SLICE apple knife;GRASP half_1;PLACE_INSIDE half_1 pan;DICE half_1 knife",
            ["has_in pan dice", "full_of pan dice", "present half_2"],
            ["present half_1"],
        ),
        ((), "TOGGLE_ON sink;GRASP pan;FILL pan sink", ["has_in pan water", "full_of pan water"], []),
        (
            (),
            "GRASP bowl;POUR bowl pan",
            ["has_in pan flour", "full_of pan flour", "has_in bowl flour"],
            [],
        ),
        ((), "GRASP bowl;EMPTY bowl pan", ["has_in pan flour"], ["has_in bowl flour", "full_of bowl flour"]),
        ((), "GRASP bowl;EMPTY bowl sink", [], ["has_in bowl flour", "has_in sink flour"]),
        ((), "GRASP bowl;APPLY bowl plate", ["has_cover plate flour"], []),
        (
            ("has_in pan water",),
            "GRASP bowl;POUR bowl pan;RELEASE bowl;GRASP spoon;STIR pan spoon",
            ["has_in pan dough", "full_of pan dough"],
            ["has_in pan flour", "has_in pan water"],
        ),
        (
            ("has_in pan dough",),
            "OPEN oven;GRASP pan;PLACE_INSIDE pan oven;CLOSE oven;TOGGLE_ON oven;HEAT pan oven",
            ["lies_on loaf pan", "present loaf", "is_hot pan"],
            ["has_in pan dough"],
        ),
        (("is_hot pan",), "WAIT", [], ["is_hot pan"]),
    ],
)
def test_actions_have_their_effects(
    domain: Domain, before: tuple[str, ...], steps: str, then: list[str], no_more: list[str]
) -> None:
    reached = run_plan(domain, make_state(*before), steps)
    assert [fact for fact in then if not holds(reached, fact)] == []
    assert [fact for fact in no_more if holds(reached, fact)] == []


@pytest.mark.parametrize(
    ("before", "steps", "kind", "reason"),
    [
        ((), "GRASP oven", FaultKind.AFFORDANCE, "{x} cannot be moved"),
        ((), "GRASP flour", FaultKind.AFFORDANCE, "{x} is a substance: only what holds it can be handled"),
        ((), "GRASP half_1", FaultKind.MISSING_STEP, "{x} does not exist now"),
        ((), "GRASP rag;GRASP pan;GRASP bowl", FaultKind.WRONG_ORDER, "both hands are full"),
        (
            ("lies_in pan oven",),
            "GRASP pan",
            FaultKind.MISSING_STEP,
            "{x} is inside something that is closed",
        ),
        ((), "PLACE_ONTOP rag plate", FaultKind.MISSING_STEP, "{x} is not in a hand"),
        ((), "GRASP rag;PLACE_INSIDE rag oven", FaultKind.MISSING_STEP, "{y} is closed"),
        ((), "GRASP rag;PLACE_INSIDE rag plate", FaultKind.AFFORDANCE, "{y} has no inside"),
        ((), "GRASP rag;SLICE apple rag", FaultKind.AFFORDANCE, "{t} cannot cut"),
        ((), "CLOSE oven", FaultKind.ADDITIONAL_STEP, "{x} is closed already"),
        ((), "GRASP rag;WIPE plate rag", FaultKind.ADDITIONAL_STEP, "{x} is covered by nothing"),
        (
            ("has_cover plate stain",),
            "GRASP rag;WIPE plate rag",
            FaultKind.MISSING_STEP,
            "{t} is not soaked with, or does not run as, what removes what covers {x}",
        ),
        (
            ("has_cover plate stain",),
            "GRASP pan;WIPE plate pan",
            FaultKind.AFFORDANCE,
            "{t} cannot remove what covers {x}",
        ),
        ((), "GRASP pan;FILL pan sink", FaultKind.MISSING_STEP, "{y} is not switched on"),
        (
            (),
            "OPEN oven;GRASP pan;PLACE_INSIDE pan oven;HEAT pan oven",
            FaultKind.MISSING_STEP,
            "{h} does not work: it must be switched on, and closed, if it can be",
        ),
        (
            (),
            "GRASP spoon;STIR pan spoon",
            FaultKind.MISSING_STEP,
            "{c} does not hold all that a recipe takes, and nothing else",
        ),
    ],
)
def test_a_failing_action_has_its_fault_and_reason(
    domain: Domain, before: tuple[str, ...], steps: str, kind: FaultKind, reason: str
) -> None:
    initial = make_state(*before)
    trajectory = execute_plan(domain, initial, parse_plan(initial, steps))
    faults = [step.fault for step in trajectory.steps if step.fault is not None]
    assert [(fault.kind, fault.check.reason) for fault in faults] == [(kind, reason)]


def test_the_robot_moves_to_the_object_of_its_action(domain: Domain) -> None:
    initial = make_state()
    assert holds(run_plan(domain, initial, "GRASP rag"), "robot_on floor")
    assert len(domain.operators) == 35


def test_a_substance_is_visible_on_an_object_or_in_an_open_container(domain: Domain) -> None:
    def find_visible(*more: str) -> set[str]:
        initial = make_state(*more)
        return {
            name for name, i in initial.scene.index.items() if domain.visible_object_filter(initial, 1 << i)
        }

    assert {"plate", "flour"} <= find_visible()
    assert "stain" not in find_visible()
    assert "dust" in find_visible("has_cover plate dust")
    assert "dust" not in find_visible("has_cover pan dust", "lies_in pan oven")
    assert "water" in find_visible("has_in pan water")
    assert "dough" not in find_visible("has_in oven dough")
    assert "dough" in find_visible("has_in oven dough", "is_open oven")
