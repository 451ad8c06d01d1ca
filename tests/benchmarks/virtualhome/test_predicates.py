from __future__ import annotations

import random

import pytest

from benchmarks.virtualhome import flat
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.predicates import VOCABULARY
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import Atom, Constant, Formula
from eai.world.domain import Domain
from eai.world.execution import attempt_action
from eai.world.history import History
from eai.world.state import Scene, State, WorldObject

STRICT = virtualhome.make_domain_with_checks_in_paper_order()
NAMES = (*flat.PROPERTIES, "shelf.90", "shelf.128")
ON_SHELVES = (
    *("-ONTOP cup.13 table.12", "ONTOP cup.13 shelf.90", "ONTOP cup.13 shelf.128"),
    *("NEXT_TO character.65 cup.13", "NEXT_TO cup.13 character.65"),
)
IN_SHELVES = (
    *("-INSIDE cup.13 kitchen.1", "INSIDE cup.13 shelf.90"),
    *("INSIDE shelf.90 shelf.128", "INSIDE shelf.128 kitchen.1"),
)


@pytest.fixture
def domain() -> Domain:
    """Return the domain with the paper's rules. Tests of other rules override this fixture."""
    return STRICT


def holds(domain: Domain, formula: Formula, *facts: str) -> bool:
    """Whether a formula holds in the flat with two shelves and these additional facts."""
    return domain.holds(formula, flat.make_state(*facts, over=_scene()))


def _scene() -> Scene:
    objects = [WorldObject(name, name.rpartition(".")[0]) for name in NAMES]
    return Scene(VOCABULARY, objects, NAMES.index("character.65"))


def is_remembered_after_grabbing(domain: Domain, support: str, *facts: str) -> bool:
    """Whether the remembered place of a grabbed cup is this support."""
    scene = _scene()
    state = attempt_action(
        domain, History(flat.make_state(*facts, over=scene)), flat.parse_action("GRAB cup.13", scene)
    )
    assert isinstance(state, State)
    return domain.holds(make_atom("TAKEN_FROM_TOP_OF", "cup.13", support), state)


def make_atom(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


def test_an_object_on_several_supports_is_remembered_on_the_first() -> None:
    remembered = [
        name for name in ("shelf.90", "shelf.128") if is_remembered_after_grabbing(STRICT, name, *ON_SHELVES)
    ]
    assert remembered == ["shelf.90"]


def test_a_room_is_found_through_the_only_container(domain: Domain) -> None:
    assert holds(domain, make_atom("room_of", "cup.13", "kitchen.1"), *IN_SHELVES)


def test_a_room_is_not_found_through_several_containers() -> None:
    several = (*IN_SHELVES, "INSIDE shelf.90 fridge.10")
    assert not holds(STRICT, make_atom("room_of", "cup.13", "kitchen.1"), *several)


def test_an_object_in_a_room_has_that_room(domain: Domain) -> None:
    assert holds(domain, make_atom("room_of", "fridge.10", "kitchen.1"))
    assert not holds(domain, make_atom("room_of", "cloud.30", "kitchen.1"))


def test_only_the_first_relation_that_holds_defines_the_place_of_an_object(domain: Domain) -> None:
    facts = ("INSIDE cup.13 shelf.90", "NEXT_TO cup.13 shelf.128")
    assert holds(domain, make_atom("lies_on", "cup.13", "table.12"), *facts)
    assert not holds(domain, make_atom("lies_in", "cup.13", "shelf.90"), *facts)
    assert not holds(domain, make_atom("lies_next_to", "cup.13", "shelf.128"), *facts)


def test_relevant_objects_have_the_order_of_the_data_set(virtualhome_tasks: VirtualHomeTasks) -> None:
    for task in virtualhome_tasks.values():
        assert list(task.relevant) == sorted(set(task.relevant))


def test_carries_is_the_closure_of_rests_in() -> None:
    chance = random.Random(4)
    names = ("cup.13", "bread.14", "knife.15", "book.16", "table.12", "bed.20")
    scene = flat.make_scene()
    for _ in range(60):
        pairs = [chance.sample(names, 2) for _ in range(5)]
        state = flat.make_state(
            *(f"{chance.choice(('INSIDE', 'ONTOP'))} {x} {y}" for x, y in pairs), over=scene
        )

        def is_true(name: str, x: str, y: str, state: State = state) -> bool:
            return STRICT.holds(make_atom(name, x, y), state)

        for x in names:
            carried: set[str] = set()
            while more := {y for y in names for z in (x, *carried) if is_true("rests_in", y, z)} - carried:
                carried |= more
            assert {y for y in names if is_true("carries", x, y)} == carried
