"""Cameras: pictures show objects in their places and states, and files have the right contents."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np
import pytest
from PIL import Image

from eai.base.errors import EaiError
from eai.benchmarks.behavior.predicates import VOCABULARY
from eai.extensions.scenes.camera import Camera
from eai.extensions.scenes.pictures import map_objects_to_picture_column_and_row, render_film, render_pictures
from eai.extensions.scenes.scene import MujocoScene
from eai.world.state import Scene
from extensions.scenes import installed  # noqa: F401 - skips all of this where MuJoCo is not installed
from extensions.scenes.rooms import SCENE, kitchen, task_of

PLATE, COUNTER = (SCENE.index[name] for name in ("plate_6", "countertop_1"))
STATES = ("is_dusty", "is_stained", "is_soaked", "is_frozen", "is_cooked", "is_burnt")


@pytest.fixture(scope="module")
def camera() -> Iterator[Camera]:
    scene = MujocoScene(task_of(kitchen()))
    try:
        opened = Camera(scene, (320, 240), shadows=False)
    except EaiError as error:
        pytest.skip(str(error))
    with opened:
        yield opened


def test_colours_depth_and_objects_agree(camera: Camera) -> None:
    colours = camera.render_colours("top")
    depth = camera.render_depth("top")
    objects = camera.render_object_indexes("top")
    assert colours.shape == (240, 320, 3)
    assert depth.shape == objects.shape == (240, 320)
    assert {PLATE, COUNTER} <= set(np.unique(objects).tolist())
    plate, counter = depth[objects == PLATE].mean(), depth[objects == COUNTER].mean()
    assert plate < counter < depth[objects == -1].max()
    assert np.array_equal(colours, camera.render_colours("top"))
    assert not np.array_equal(colours, camera.render_colours("head"))


@pytest.mark.parametrize("state", STATES)
def test_each_state_is_seen_and_goes(camera: Camera, state: str) -> None:
    before = camera.render_colours("near")
    camera.scene.show_state(kitchen([f"{state}(basket_4)"]))
    changed = np.abs(camera.render_colours("near").astype(int) - before).max(2)
    camera.scene.show_state(kitchen())
    assert (changed > 25).sum() > 30
    assert np.abs(camera.render_colours("near").astype(int) - before).max() <= 2


def test_what_is_held_is_in_view_and_what_is_shut_in_is_not(camera: Camera) -> None:
    milk = SCENE.index["milk_7"]
    assert milk not in camera.render_object_indexes("near")
    camera.scene.show_state(kitchen(["in_left_hand(milk_7)"], ["lies_in(milk_7, fridge_2)"]))
    assert (camera.render_object_indexes("near") == milk).sum() > 100
    camera.scene.show_state(kitchen())


def test_what_holds_things_may_be_held(camera: Camera) -> None:
    camera.scene.show_state(kitchen(["in_left_hand(basket_4)"], ["lies_on(basket_4, breakfast_table_3)"]))
    seen = set(np.unique(camera.render_object_indexes("near")).tolist())
    camera.scene.show_state(kitchen())
    assert SCENE.index["basket_4"] in seen
    assert SCENE.index["apple_5"] not in seen


def test_what_alone_is_there_may_be_held(camera: Camera) -> None:
    scene = Scene(VOCABULARY, {"floor_kitchen": "floor.n.01", "apple_5": "apple.n.01"})
    state = scene.state(["floor(floor_kitchen)", "stands_on(apple_5, floor_kitchen)"])
    with Camera(MujocoScene(task_of(state)), (320, 240), shadows=False) as alone:
        alone.scene.show_state(scene.state(["floor(floor_kitchen)", "in_left_hand(apple_5)"]))
        assert (alone.render_object_indexes("near") == 1).any()


def test_a_pixel_of_each_thing_that_is_seen_is_on_it(camera: Camera) -> None:
    task, views = task_of(kitchen()), ("near", "top")
    found = map_objects_to_picture_column_and_row(task, views)
    assert {PLATE, COUNTER} <= set(found)
    assert SCENE.index["milk_7"] not in found
    with Camera(MujocoScene(task)) as whole:
        objects = [whole.render_object_indexes(view) for view in views]
    assert all(objects[number - 1][row, column] == i for i, (number, column, row) in found.items())


def test_pictures_are_files(camera: Camera) -> None:
    task = task_of(kitchen())
    plain, numbered = (render_pictures(task, ("near",), numbered=each)[0] for each in (False, True))
    assert Image.open(io.BytesIO(plain)).size == (640, 480)
    assert plain != numbered
    moving = Image.open(io.BytesIO(render_film(task, [kitchen(), kitchen(["is_dusty(basket_4)"])])))
    assert (moving.format, getattr(moving, "n_frames", 1)) == ("GIF", 2)
