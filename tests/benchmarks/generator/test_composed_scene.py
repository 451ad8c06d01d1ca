"""Scenes composed from several tasks, by small kitchens and by all tasks of a household."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

import eai.logic.formula as f
from benchmarks.generator.kitchens import VOCABULARY, task, told, usual
from benchmarks.generator.worlds import tasks
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import TaskObject
from eai.benchmarks.generator.composed_scene import (
    add_static_facts_comparing_objects,
    compose_scene_from_tasks,
    list_mentioned_objects_by_category,
)
from eai.benchmarks.generator.usual_goals import UsualGoalsOfDataSet
from eai.tasks.goal_text import make_task
from eai.tasks.task import Task, goal
from eai.world import Scene, WorldObject
from eai.world.relation import iterate_bits
from eai.world.state import Fact


def compose(
    here: Task, others: Sequence[Task], prior: UsualGoalsOfDataSet, seed: int = 0, most: int = 9
) -> tuple[list[str], set[str]]:
    """Return the names and the facts of a scene after objects of other tasks were added."""
    donors = list_mentioned_objects_by_category(others)
    state = compose_scene_from_tasks(here.initial, others, donors, prior, random.Random(seed), most)
    return [thing.name for thing in state.scene.objects], told(state.facts(), state.scene)


def test_objects_of_other_tasks_come_with_their_states_and_what_holds_them() -> None:
    """The cup of another home stands on the same tray, which is on a table of this home."""
    here = task(["me.0", "table.5", "plate.1"], ("on", "plate.1", "table.5"))
    home = task(
        ["cup.1", "tray.1", "table.1", "plate.1", "me.0"],
        ("on", "cup.1", "tray.1"),
        ("on", "cup.1", "table.1"),
        ("on", "tray.1", "table.1"),
        ("near", "cup.1", "plate.1"),
        ("clean", "cup.1"),
    )
    needs_cup = replace(home, goals=(goal(f.Atom("clean", (f.Constant("cup.1"),))),))
    names, facts = compose(here, [needs_cup], usual(taken_categories=frozenset()))
    assert names == ["me.0", "table.5", "plate.1", "tray.3", "cup.4"]
    assert facts == {
        "on plate.1 table.5",
        "on tray.3 table.5",
        "on cup.4 tray.3",
        "on cup.4 table.5",
        "clean cup.4",
    }
    assert compose(here, [needs_cup], usual(taken_categories=frozenset()), most=4)[0] == names[:4]
    assert compose(here, [home], usual())[0] == ["me.0", "table.5", "plate.1"]  # no goal needs the cup


def test_an_object_of_another_task_is_left_out_if_its_place_does_not_fit() -> None:
    """The tray of this home is on no table, and nothing is put on the agent."""
    here = task(["me.0", "table.5", "tray.7"])
    facts = [("on", "cup.1", "tray.1"), ("on", "cup.1", "table.1"), ("on", "tray.1", "table.1")]
    on_tray = task(["cup.1", "tray.1", "table.1"], *facts)
    on_agent = task(["cup.1", "me.0"], ("on", "cup.1", "me.0"))
    for home in (on_tray, on_agent):
        needs_cup = replace(home, goals=(goal(f.Atom("clean", (f.Constant("cup.1"),))),))
        assert compose(here, [needs_cup], usual())[0] == ["me.0", "table.5", "tray.7"]
    part = replace(on_tray, goals=(goal(f.Atom("clean", (f.Constant("tray.1"),))),))
    bare = task(["me.0"])
    assert compose(bare, [part], usual())[0] == ["me.0", "table.1", "tray.2"]
    assert compose(bare, [part], usual(part_categories=frozenset({"tray"})))[0] == ["me.0"]


@pytest.mark.parametrize(
    ("changes", "facts", "is_moved"),
    [
        ({}, (), True),
        ({"taken_categories": frozenset({"plate"})}, (), False),
        ({"holding_predicate_names": frozenset({"near"})}, (("near", "me.0", "cup.1"),), False),
        ({}, (("on", "plate.1", "cup.1"),), False),  # the plate would hang in the air
        ({"place_relations": ()}, (), False),
    ],
)
def test_half_of_the_portable_objects_get_a_place_of_another_task(
    changes: dict[str, Any], facts: tuple[tuple[str, ...], ...], is_moved: bool
) -> None:
    things = ["me.0", "table.1", "shelf.1", "cup.1", "plate.1"]
    here = task(things, ("on", "cup.1", "table.1"), ("near", "me.0", "cup.1"), ("clean", "cup.1"), *facts)
    home = task(["shelf.9", "cup.9"], ("on", "cup.9", "shelf.9"))
    before = told(here.initial.facts(), here.scene)
    moved = {"on cup.1 shelf.1", "clean cup.1"}
    found = [compose(here, [home], usual(**changes), seed)[1] for seed in range(40)]
    assert all(after in (before, moved) for after in found)
    assert (8 < found.count(moved) < 32) == is_moved == (moved in found)


def compose_by_models(here: Task, home: Task, needed: str, **options: Any) -> tuple[list[str], set[str]]:
    """Return a scene with an added object of another home. The first letter of a name is the model."""
    needs = replace(home, goals=(goal(f.Atom("clean", (f.Constant(needed),))),))
    origins: dict[str, TaskObject] = {thing.name: (here, i) for i, thing in enumerate(here.scene.objects)}
    state = compose_scene_from_tasks(
        here.initial,
        [needs],
        {},
        usual(taken_categories=frozenset(), **options.pop("prior", {})),
        random.Random(0),
        9,
        origins,
        lambda of, index: of.scene.objects[index].name[0],
        **options,
    )
    names = [thing.name for thing in state.scene.objects]
    assert list(origins) == names
    assert [origins[name][0].scene.objects[origins[name][1]].category for name in names] == [
        thing.category for thing in state.scene.objects
    ]
    return names, told(state.facts(), state.scene)


def make_home(*things: tuple[str, str], facts: Sequence[tuple[str, ...]]) -> Task:
    """Return a task whose objects have these names and categories."""
    scene = Scene(VOCABULARY, [WorldObject(name, category) for name, category in things])
    state = scene.state([Fact(name, tuple([scene.index[each] for each in about])) for name, *about in facts])
    return make_task("t", "-", state)


def test_only_a_place_of_the_same_model_holds_an_object_like_in_its_home() -> None:
    """A bed that stands in a bedroom does not come to stand in the kitchen."""
    kitchen = make_home(("kitchen.1", "floor"), ("table.2", "table"), facts=[("on", "table.2", "kitchen.1")])
    bedroom = make_home(("nursery.1", "floor"), ("bed.2", "bed"), facts=[("on", "bed.2", "nursery.1")])
    assert compose_by_models(kitchen, bedroom, "bed.2") == (
        ["kitchen.1", "table.2"],
        {"on table.2 kitchen.1"},
    )
    names, facts = compose_by_models(kitchen, bedroom, "bed.2", limits={"floor": 2})
    assert names == ["kitchen.1", "table.2", "nursery.3", "bed.4"]
    assert facts == {"on table.2 kitchen.1", "on bed.4 nursery.3"}
    other_kitchen = make_home(("kitchen.7", "floor"), ("bed.2", "bed"), facts=[("on", "bed.2", "kitchen.7")])
    assert compose_by_models(kitchen, other_kitchen, "bed.2")[1] == {
        "on table.2 kitchen.1",
        "on bed.3 kitchen.1",
    }
    second_table = make_home(("desk.1", "table"), facts=[])
    assert compose_by_models(kitchen, second_table, "desk.1")[0] == ["kitchen.1", "table.2"]


def test_an_object_comes_with_its_parts_and_without_the_place_of_the_robot() -> None:
    kitchen = make_home(("kitchen.1", "floor"), ("bowl.3", "bowl"), facts=[("robot_here", "kitchen.1")])
    home = make_home(
        ("nursery.1", "floor"),
        ("apple.3", "apple"),
        ("apple.3 half 0", "half"),
        ("core", "half"),
        facts=[
            ("on", "apple.3", "nursery.1"),
            ("part_of", "apple.3 half 0", "apple.3"),
            ("part_of", "core", "apple.3"),
            ("clean", "core"),
            ("robot_here", "nursery.1"),
        ],
    )
    prior = {"part_categories": frozenset({"half"}), "unique_states": frozenset({"robot_here"})}
    names, facts = compose_by_models(kitchen, home, "apple.3", limits={"floor": 2}, prior=prior)
    assert names == ["kitchen.1", "bowl.3", "nursery.2", "apple.4", "apple.4 half 0", "core"]
    assert facts == {
        "robot_here kitchen.1",
        "on apple.4 nursery.2",
        "part_of apple.4 half 0 apple.4",
        "part_of core apple.4",
        "clean core",
    }


def test_objects_of_two_tasks_get_the_relations_that_the_benchmark_tells() -> None:
    here, home = task(["cup.1"]), task(["cup.2", "tray.2"])
    both = task(["cup.1", "tray.2"], ("clean", "cup.1"))
    compared: list[list[TaskObject]] = []

    def compare(objects: Sequence[TaskObject]) -> list[Fact]:
        compared.append(list(objects))
        return [Fact("part_of", (0, 1)), Fact("clean", (0,))]

    state = add_static_facts_comparing_objects(
        both.initial, {"tray.2": (home, 1), "cup.1": (here, 0)}, compare
    )
    assert compared == [[(here, 0), (home, 1)]]
    assert told(state.facts(), state.scene) == {"clean cup.1", "part_of cup.1 tray.2"}


def test_composed_scenes_have_whole_facts(data_store: DataPackStore) -> None:
    """Sizes are a strict order of all objects, wholes have both halves, and there is one robot."""
    made = [each.task for each in tasks("behavior")]
    assert len(made) > 10
    for each in made:
        state, things = each.initial, each.scene.objects
        larger = [state.relation("larger").row(i) for i in range(len(things))]
        assert state.mask("robot_on").bit_count() == 1
        assert state.scene.everything & state.mask("floor") & ~state.mask("ungraspable") == 0
        for i, smaller in enumerate(larger):
            equal = state.scene.everything & ~smaller & ~state.relation("larger").column(i)
            assert all(
                larger[j] == smaller for j in iterate_bits(equal)
            )  # also that nothing is larger than itself
            assert all(larger[j] | 1 << j | smaller == smaller for j in iterate_bits(smaller))
            assert state.relation("much_larger").row(i) | smaller == smaller
            assert not state.relation("lies_in").row(i) & smaller  # nothing lies in a smaller object
        for i in iterate_bits(state.mask("sliceable")):
            halves = state.relation("part_of").column(i)
            assert (halves.bit_count() == 2) != things[i].category.startswith("half_")
