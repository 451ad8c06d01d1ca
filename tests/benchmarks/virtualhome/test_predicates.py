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
from eai.world.history import Past
from eai.world.state import Scene, State, WorldObject
from protocols import of_reference

virtualhome_quirks = of_reference("virtualhome_quirks")

STRICT, REFERENCE = virtualhome.as_meant(), virtualhome_quirks.as_in_reference()
BOTH = pytest.mark.parametrize("domain", [STRICT, REFERENCE], ids=["strict", "eai-1.0.5"])
NAMES = (*flat.PROPERTIES, "shelf.90", "shelf.128")


def holds(domain: Domain, formula: Formula, *facts: str) -> bool:
    """Whether a formula holds in the flat with two shelves, where some facts are added."""
    return domain.holds(formula, flat.state(*facts, over=_scene()))


def _scene() -> Scene:
    objects = [WorldObject(name, name.rpartition(".")[0]) for name in NAMES]
    return Scene(VOCABULARY, objects, NAMES.index("character.65"))


def holds_after(domain: Domain, place: str, *facts: str) -> bool:
    """Whether a grabbed cup is remembered to have stood on a place."""
    scene = _scene()
    state = attempt(domain, Past(flat.state(*facts, over=scene)), flat.action("GRAB cup.13", scene))
    assert isinstance(state, State)
    return domain.holds(looked_up("TAKEN_FROM_TOP_OF", "cup.13", place), state)


def looked_up(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


def test_of_several_places_the_first_in_the_data_set_counts_in_the_reference_that_of_a_hash_table() -> None:
    """Python iterates a set of 90 and 128 as 128, 90: they are in slots 0 and 2 of 8."""
    facts = ("-ONTOP cup.13 table.12", "ONTOP cup.13 shelf.90", "ONTOP cup.13 shelf.128")
    near = ("NEXT_TO character.65 cup.13", "NEXT_TO cup.13 character.65")
    remembered = [
        [name for name in ("shelf.90", "shelf.128") if holds_after(domain, name, *facts, *near)]
        for domain in (STRICT, REFERENCE)
    ]
    assert remembered == [["shelf.90"], ["shelf.128"]]


def test_a_room_is_found_through_the_only_container_in_the_reference_through_the_first() -> None:
    facts = (
        *("-INSIDE cup.13 kitchen.1", "INSIDE cup.13 shelf.90"),
        *("INSIDE shelf.90 shelf.128", "INSIDE shelf.128 kitchen.1"),
    )
    room = looked_up("room_of", "cup.13", "kitchen.1")
    assert [holds(domain, room, *facts) for domain in (STRICT, REFERENCE)] == [True, True]
    several = (*facts, "INSIDE shelf.90 fridge.10")
    assert not holds(STRICT, room, *several)


@BOTH
def test_an_object_that_is_in_one_room_is_there(domain: Domain) -> None:
    assert holds(domain, looked_up("room_of", "fridge.10", "kitchen.1"))
    assert not holds(domain, looked_up("room_of", "cloud.30", "kitchen.1"))


@BOTH
def test_only_the_first_relation_that_holds_decides_where_something_is_taken_from(domain: Domain) -> None:
    facts = ("INSIDE cup.13 shelf.90", "NEXT_TO cup.13 shelf.128")
    assert holds(domain, looked_up("lies_on", "cup.13", "table.12"), *facts)
    assert not holds(domain, looked_up("lies_in", "cup.13", "shelf.90"), *facts)
    assert not holds(domain, looked_up("lies_next_to", "cup.13", "shelf.128"), *facts)


def test_both_vocabularies_store_the_same() -> None:
    assert virtualhome_quirks.IN_SLOT_ORDER.predicates == VOCABULARY.predicates
    assert virtualhome_quirks.IN_SLOT_ORDER.unary_slots == VOCABULARY.unary_slots
    assert virtualhome_quirks.IN_SLOT_ORDER.binary_slots == VOCABULARY.binary_slots
    assert REFERENCE.vocabulary is virtualhome_quirks.IN_SLOT_ORDER


def test_relevant_objects_are_in_the_order_of_the_data_set(virtualhome_tasks: VirtualHomeTasks) -> None:
    reordered = 0
    for task in virtualhome_tasks.values():
        assert list(task.relevant) == sorted(set(task.relevant))
        in_reference = virtualhome_quirks.relevant_objects(task)
        assert sorted(in_reference) == list(task.relevant)
        reordered += in_reference != task.relevant
    assert reordered > 100


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
