from __future__ import annotations

import random

import pytest

from benchmarks.virtualhome import flat
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.predicates import VOCABULARY
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import Atom, Constant, Formula
from eai.world.domain import Domain
from eai.world.execution import attempt
from eai.world.history import History
from eai.world.state import Scene, State, WorldObject

STRICT = virtualhome.as_meant()
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
    """The rules of the paper; tests of other rules for the same world have a fixture of this name, too."""
    return STRICT


def holds(domain: Domain, formula: Formula, *facts: str) -> bool:
    """Whether a formula holds in the flat with two shelves, where some facts are added."""
    return domain.holds(formula, flat.state(*facts, over=_scene()))


def _scene() -> Scene:
    objects = [WorldObject(name, name.rpartition(".")[0]) for name in NAMES]
    return Scene(VOCABULARY, objects, NAMES.index("character.65"))


def holds_after(domain: Domain, place: str, *facts: str) -> bool:
    """Whether a grabbed cup is remembered to have stood on a place."""
    scene = _scene()
    state = attempt(domain, History(flat.state(*facts, over=scene)), flat.action("GRAB cup.13", scene))
    assert isinstance(state, State)
    return domain.holds(looked_up("TAKEN_FROM_TOP_OF", "cup.13", place), state)


def looked_up(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


def test_of_several_places_the_first_in_the_data_set_counts() -> None:
    remembered = [name for name in ("shelf.90", "shelf.128") if holds_after(STRICT, name, *ON_SHELVES)]
    assert remembered == ["shelf.90"]


def test_a_room_is_found_through_the_only_container(domain: Domain) -> None:
    assert holds(domain, looked_up("room_of", "cup.13", "kitchen.1"), *IN_SHELVES)


def test_a_room_is_not_found_through_several_containers() -> None:
    several = (*IN_SHELVES, "INSIDE shelf.90 fridge.10")
    assert not holds(STRICT, looked_up("room_of", "cup.13", "kitchen.1"), *several)


def test_an_object_that_is_in_one_room_is_there(domain: Domain) -> None:
    assert holds(domain, looked_up("room_of", "fridge.10", "kitchen.1"))
    assert not holds(domain, looked_up("room_of", "cloud.30", "kitchen.1"))


def test_only_the_first_relation_that_holds_decides_where_something_is_taken_from(domain: Domain) -> None:
    facts = ("INSIDE cup.13 shelf.90", "NEXT_TO cup.13 shelf.128")
    assert holds(domain, looked_up("lies_on", "cup.13", "table.12"), *facts)
    assert not holds(domain, looked_up("lies_in", "cup.13", "shelf.90"), *facts)
    assert not holds(domain, looked_up("lies_next_to", "cup.13", "shelf.128"), *facts)


def test_relevant_objects_are_in_the_order_of_the_data_set(virtualhome_tasks: VirtualHomeTasks) -> None:
    for task in virtualhome_tasks.values():
        assert list(task.relevant) == sorted(set(task.relevant))


def test_what_goes_along_is_what_rests_in_it_or_in_that() -> None:
    """The lookup of `carries` says what its formula says: the closure of `rests_in`."""
    chance = random.Random(4)
    things = ("cup.13", "bread.14", "knife.15", "book.16", "table.12", "bed.20")
    scene = flat.scene()
    for _ in range(60):
        pairs = [chance.sample(things, 2) for _ in range(5)]
        state = flat.state(*(f"{chance.choice(('INSIDE', 'ONTOP'))} {x} {y}" for x, y in pairs), over=scene)

        def said(name: str, x: str, y: str, state: State = state) -> bool:
            return STRICT.holds(looked_up(name, x, y), state)

        for x in things:
            found: set[str] = set()
            while more := {y for y in things for z in (x, *found) if said("rests_in", y, z)} - found:
                found |= more
            assert {y for y in things if said("carries", x, y)} == found
