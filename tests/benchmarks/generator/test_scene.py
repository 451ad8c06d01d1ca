"""Scenes of generated tasks, by small kitchens: added guests, and the kept part of a scene."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import pytest

from benchmarks.generator.kitchens import ON_TABLE, VOCABULARY, task, told, usual
from eai.benchmarks.generator.scene import (
    _order_by_category,
    add_objects_of_other_tasks,
    add_portable_objects_similar_to_existing,
    make_free_name,
    make_state_with_subset_of_objects,
    restrict_state,
)
from eai.benchmarks.generator.usual_goals import LiteralPattern
from eai.world import Scene, WorldObject

HOME = (["cup.1", "table.1"], ("on", "cup.1", "table.1"), ("clean", "cup.1"))
HERE = (["plate.1", "table.2"], ("on", "plate.1", "table.2"))


@pytest.mark.parametrize(
    ("home", "here", "changes", "most", "guests"),
    [
        (HOME, HERE, {}, 3, ["cup.3"]),  # each object has its own number
        (HOME, HERE, {}, 4, ["cup.3", "cup.4"]),
        (HOME, HERE, {}, 2, []),
        (HOME, HERE, {"patterns": {("on", False): {ON_TABLE._replace(truth=False): 1.0}}}, 3, []),
        (
            HOME,
            HERE,
            {"patterns": {("clean", True): {LiteralPattern("clean", ("cup",), True): 1.0}}},
            3,
            [],
        ),
        (
            HOME,
            HERE,
            {"patterns": {("on", True): {LiteralPattern("on", ("cup", "shelf"), True): 1.0}}},
            3,
            [],
        ),
        (HOME, HERE, {"taken_categories": frozenset({"plate"})}, 3, []),
        (
            HOME,
            HERE,
            {"taken_categories": frozenset({"cup"})},
            3,
            [],
        ),  # beside a portable object
        (HOME, HERE, {"part_categories": frozenset({"cup"})}, 3, []),
        (HOME, HERE, {"place_relations": ()}, 3, []),
        ((["cup.1", "shelf.1"], ("on", "cup.1", "shelf.1")), HERE, {}, 3, []),
        ((["cup.1", "lid.1", "table.1"], *HOME[1:], ("part_of", "lid.1", "cup.1")), HERE, {}, 3, []),
        ((["cup.1", "lid.1", "table.1"], *HOME[1:], ("part_of", "cup.1", "lid.1")), HERE, {}, 3, []),
    ],
)
def test_guests_fit_the_scene_and_keep_their_placement(
    home: Any, here: Any, changes: dict[str, Any], most: int, guests: list[str]
) -> None:
    prior, place = usual(**changes), task(*here)
    closed = make_state_with_subset_of_objects(
        place, replace(prior, taken_categories=frozenset()), random.Random(0), 9
    )
    home_tasks = [task(*home, relevant=["cup.1"]), replace(task(*home), relevant=())]
    found = add_objects_of_other_tasks(closed, home_tasks, prior, random.Random(0), most)
    names = [thing.name for thing in found.scene.objects]
    assert names == [*here[0], *guests]
    expected = {f"on {guest} table.2" for guest in guests} | {f"clean {guest}" for guest in guests}
    assert told(found.facts(), found.scene) - told(closed.facts(), closed.scene) == expected


@pytest.mark.parametrize(
    ("changes", "kinds", "most", "number"),
    [
        ({}, {"cup"}, 9, {1, 2, 3, 4, 5}),
        ({}, {"cup"}, 4, {1, 2}),
        ({}, {"cup"}, 2, {0}),
        ({}, {"plate"}, 9, {0}),
        ({"countable_categories": frozenset({"plate"})}, {"cup"}, 9, {0}),
        ({"taken_categories": frozenset({"plate"})}, {"cup"}, 9, {0}),
        ({"place_relations": ()}, {"cup"}, 9, {0}),
    ],
)
def test_added_objects_are_placed_like_one_of_their_category(
    changes: dict[str, Any], kinds: set[str], most: int, number: set[int]
) -> None:
    prior = usual(**{"countable_categories": frozenset({"cup"}), **changes})
    closed = make_state_with_subset_of_objects(
        task(*HOME), replace(prior, taken_categories=frozenset()), random.Random(0), 9
    )
    seen = set()
    for seed in range(40):
        found = add_portable_objects_similar_to_existing(closed, prior, random.Random(seed), most, kinds)
        more = [thing.name for thing in found.scene.objects[2:]]
        seen.add(len(more))
        assert len(set(more)) == len(more)
        assert told(found.facts(), found.scene) - told(closed.facts(), closed.scene) == {
            fact for name in more for fact in (f"on {name} table.1", f"clean {name}")
        }
    assert seen == number


CROWD = [f"cup.{n}" for n in range(40)]


@pytest.mark.parametrize(
    ("most", "rich", "sizes"),
    [
        (30, False, set(range(16, 31))),
        (12, False, {12}),
        (16, False, {16}),
        (30, True, {20}),
        (10, True, {6}),
    ],
)
def test_the_number_of_objects_in_a_scene_is_limited(most: int, rich: bool, sizes: set[int]) -> None:
    """A rich scene has two thirds of the maximum, others at least sixteen objects."""
    prior = usual(
        patterns={("clean", True): {LiteralPattern("clean", (f"kind{n}",), True): 1.0 for n in range(40)}}
    )
    things = [f"kind{n}.{n}" for n in range(40)] if rich else CROWD
    crowded = replace(task(things), relevant=())
    found = {
        len(
            make_state_with_subset_of_objects(
                crowded, prior, random.Random(seed), most, leaves_room_for_other_tasks=rich
            ).scene.objects
        )
        for seed in range(150)
    }
    assert found == sizes


def test_an_object_comes_with_its_support_and_its_parts() -> None:
    things = ["cup.1", "lid.1", "tray.1", "table.1", "me.0", "sink.1", "pan.1"]
    facts = [
        ("on", "cup.1", "tray.1"),
        ("on", "tray.1", "table.1"),
        ("part_of", "lid.1", "cup.1"),
        ("near", "cup.1", "tray.1"),
        ("near", "me.0", "cup.1"),
        ("near", "table.1", "me.0"),
        ("clean", "lid.1"),
        ("clean", "pan.1"),
        ("night",),
    ]
    asked = task(things, *facts, relevant=["lid.1"])
    prior = usual(taken_categories=frozenset({"nothing"}))
    found = make_state_with_subset_of_objects(asked, prior, random.Random(0), 5)
    assert [thing.name for thing in found.scene.objects] == things[:5]
    assert found.scene.agent == 4
    assert told(found.facts(), found.scene) == {
        "on cup.1 tray.1",
        "on tray.1 table.1",
        "part_of lid.1 cup.1",
        "near me.0 cup.1",
        "near table.1 me.0",
        "clean lid.1",
        "night",
    }
    assert [
        thing.name
        for thing in make_state_with_subset_of_objects(asked, prior, random.Random(0), 4).scene.objects
    ] == ["me.0"]
    there = make_state_with_subset_of_objects(asked, prior, random.Random(0), 2, required_objects=[5])
    assert [thing.name for thing in there.scene.objects] == ["me.0", "sink.1"]


def test_two_objects_in_each_other_lose_both_facts() -> None:
    asked = task(["cup.1", "pan.1"], ("on", "cup.1", "pan.1"), ("on", "pan.1", "cup.1"), ("clean", "pan.1"))
    assert told(
        make_state_with_subset_of_objects(asked, usual(), random.Random(0), 9).facts(), asked.scene
    ) == {"clean pan.1"}
    assert {fact.predicate for fact in restrict_state(asked.initial, [1]).facts()} == {"clean"}


@pytest.mark.parametrize(
    ("name", "there", "expected"),
    [
        ("cup", [], "cup"),
        ("cup", ["pan"], "cup"),
        ("cup", ["cup"], "cup_1"),
        ("cup_1", ["pan_2"], "cup_1"),
        ("cup_1", ["cup_1"], "cup_2"),  # numbers begin at the number of objects
        ("cup_1", ["pan_1", "pan_2"], "cup_3"),  # each number belongs to one object
        ("cup.12", ["pan.12", "x", "y"], "cup.3"),
    ],
)
def test_a_new_name_has_an_unused_number(name: str, there: list[str], expected: str) -> None:
    assert make_free_name(name, [WorldObject(each, "thing") for each in there]) == expected


def test_one_object_of_each_category_comes_before_a_second_one() -> None:
    scene = Scene(VOCABULARY, [WorldObject(f"{k}.{n}", k) for k in ("cup", "pan") for n in range(3)], None)
    orders = {tuple(_order_by_category(range(6), scene, random.Random(seed))) for seed in range(50)}
    assert len(orders) > 20
    for order in orders:
        kinds = [scene.objects[i].category for i in order]
        assert all({*pair} == {"cup", "pan"} for pair in zip(kinds[::2], kinds[1::2], strict=True))
