"""Scenes with bodies: initial facts hold by geometry, equal tasks make equal scenes, and states are shown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.extensions.scenes import geometry
from eai.extensions.scenes.scene import MujocoScene
from extensions.scenes import installed  # noqa: F401 - skips all of this where MuJoCo is not installed
from extensions.scenes.rooms import SCENE, kitchen, task_of

MILK, APPLE, PLATE, BASKET = (SCENE.index[n] for n in ("milk_7", "apple_5", "plate_6", "basket_4"))
FRIDGE, TABLE, COUNTER = (SCENE.index[n] for n in ("fridge_2", "breakfast_table_3", "countertop_1"))


@pytest.fixture(scope="module")
def scene() -> MujocoScene:
    return MujocoScene(task_of(kitchen()))


def test_all_facts_hold_and_others_do_not(scene: MujocoScene) -> None:
    assert scene.list_relations_not_met_by_geometry() == []
    assert geometry.is_inside(scene, MILK, FRIDGE)
    assert geometry.is_inside(scene, APPLE, BASKET)
    assert geometry.is_on_top(scene, PLATE, COUNTER)
    assert not geometry.is_on_top(scene, APPLE, COUNTER)
    assert not geometry.is_inside(scene, PLATE, FRIDGE)
    assert not geometry.is_under(scene, PLATE, TABLE)
    assert not geometry.is_next_to(scene, PLATE, APPLE)


def test_a_fact_that_is_broken_is_found() -> None:
    scene = MujocoScene(task_of(kitchen()))
    place = scene.data.xpos[scene.mujoco_body_of_object[COUNTER]].tolist()
    scene.model.body_pos[scene.mujoco_body_of_object[FRIDGE]] = (9.0, 9.0, 1.0)
    scene.mujoco.mj_forward(scene.model, scene.data)
    lost = {
        (SCENE.objects[a].name, relation) for a, relation, _ in scene.list_relations_not_met_by_geometry()
    }
    assert lost == {("milk_7", "lies_in"), ("fridge_2", "on the floor of")}
    assert scene.data.xpos[scene.mujoco_body_of_object[COUNTER]].tolist() == place


def test_equal_tasks_make_equal_scenes_and_others_do_not(scene: MujocoScene) -> None:
    task = task_of(kitchen())
    again, other = MujocoScene(task), MujocoScene(replace(task, id="other"))
    assert np.array_equal(scene.data.qpos, again.data.qpos)
    assert not np.array_equal(scene.data.qpos, other.data.qpos)


def test_a_later_state_is_shown_and_what_stays_stays() -> None:
    scene = MujocoScene(task_of(kitchen()))
    bodies, at = scene.mujoco_body_of_object, scene.data.xpos
    before = at[bodies[PLATE]].copy()
    moved = kitchen(["is_open(fridge_2)", "lies_on(milk_7, countertop_1)"], ["lies_in(milk_7, fridge_2)"])
    scene.show_state(moved)
    assert np.allclose(at[bodies[PLATE]], before)
    assert at[bodies[MILK]][2] > 0.9
    assert (scene.model.geom_rgba[scene.mujoco_geoms_of_object[FRIDGE], 3] == 0).any()
    cut = kitchen(
        ["is_sliced(apple_5)", "lies_on(apple_5_part_0, plate_6)", "lies_on(apple_5_part_1, plate_6)"],
        ["lies_in(apple_5, basket_4)"],
    )
    scene.show_state(cut)
    assert at[bodies[APPLE]][2] < -10 < at[bodies[SCENE.index["apple_5_part_0"]]][2]


def test_what_finds_no_place_is_refused_with_a_reason_but_shown_later() -> None:
    full = kitchen(["lies_in(fridge_2, basket_4)"], ["stands_on(fridge_2, floor_kitchen)"])
    with pytest.raises(InputError, match=r"kitchen: 8 attempts .*: no free space for fridge_2 in basket_4"):
        MujocoScene(task_of(full))
    scene = MujocoScene(task_of(kitchen()))
    scene.show_state(full)
    assert scene.locations.find_relation_and_carrier(FRIDGE) == ("lies_in", BASKET)


def test_a_thing_without_a_body_is_refused() -> None:
    from eai.world.state import Scene

    strange = Scene(SCENE.vocabulary, {"floor_kitchen": "floor.n.01", "unicorn_1": "unicorn.n.01"})
    with pytest.raises(
        InputError, match=r"unicorn_1: objects of the kind unicorn have no three-dimensional shape"
    ):
        MujocoScene(task_of(strange.state(["floor(floor_kitchen)"])))


def test_what_is_yet_to_be_made_is_not_there() -> None:
    from eai.benchmarks.behavior_1k import predicates as p
    from eai.benchmarks.behavior_1k.predicates import VOCABULARY
    from eai.world.state import Scene

    names = {
        "floor_1": "floor.n.01",
        "table_1": "table.n.02",
        "bowl_1": "bowl.n.01",
        "unicorn_1": "unicorn.n.01",
    }
    facts = ["floor(floor_1)", "present(floor_1)", "present(table_1)", "lies_on(bowl_1, table_1)"]
    scene = MujocoScene(task_of(Scene(VOCABULARY, names).state([*facts, "lies_on(table_1, floor_1)"])))
    assert p.present.name in {each.name for each in VOCABULARY.predicates}
    assert sorted(scene.locations.bodies) == [1, 2]
    assert geometry.is_on_top(scene, 2, 1)
    assert scene.locations.floor_of[1] == 0


def refusals(tasks: BehaviorTasks, step: int) -> list[str]:
    found = []
    for task_id in [*tasks][::step]:
        try:
            MujocoScene(tasks[task_id])
        except InputError as error:
            found.append(str(error))
    return found


def test_published_scenes_hold_by_geometry(behavior_tasks: BehaviorTasks) -> None:
    assert refusals(behavior_tasks, 20) == []


@pytest.mark.sweep
def test_all_published_scenes_hold_by_geometry(
    data_store: DataPackStore, behavior_tasks: BehaviorTasks
) -> None:
    assert refusals(behavior_tasks, 1) == []
