"""Render three-dimensional scenes of tasks. All functions raise an error without the extra `physics`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from eai.base.errors import InputError, require_extra
from eai.benchmarks.suite import Suite
from eai.extensions.scenes.course import replay_record
from eai.extensions.scenes.diagrams import PNG
from eai.results.record import Record
from eai.tasks.prompts.prompt import Image
from eai.tasks.task import Task
from eai.world.state import State

if TYPE_CHECKING:
    from eai.extensions.scenes.camera import Camera, CameraView

VIEWS: tuple[CameraView, ...] = ("head", "near", "top")
"""All viewpoints: the robot's head, near the objects of the task, and above the rooms."""


_installed = partial(require_extra, "physics", "scenes with bodies need")


def render_task_images(
    task: Task, views: Sequence[CameraView] = VIEWS, *, numbered: bool = False, state: State | None = None
) -> tuple[Image, ...]:
    """Return one picture for each view of a state of a task.

    Args:
        task: the task.
        views: the viewpoints.
        numbered: whether each object gets a box with its index.
        state: the state to show; the initial state if None.

    Raises:
        InputError: an object does not fit into its room or container, or has no body. The message names it.
        EaiError: the extra `physics` is not installed.
    """
    with _installed():
        from eai.extensions.scenes.pictures import render_pictures

        return tuple(
            [Image(PNG, picture) for picture in render_pictures(task, views, numbered=numbered, state=state)]
        )


def render_images_of_tasks(
    tasks: Mapping[str, Task], *, numbered: bool = False
) -> dict[str, tuple[Image, ...]]:
    """Return pictures of the initial state of each task whose scene can be built, by task id.

    The pictures are those of `render_task_images`.

    Raises:
        InputError: no task's scene can be built. The message is about the first task.
        EaiError: the extra `physics` is not installed.
    """
    pictures_by_task: dict[str, tuple[Image, ...]] = {}
    refused: list[InputError] = []
    for task_id, task in tasks.items():
        try:
            pictures_by_task[task_id] = render_task_images(task, VIEWS[:2], numbered=numbered)
        except InputError as error:
            refused.append(error)
    if refused and not pictures_by_task:
        raise refused[0]
    return pictures_by_task


def map_objects_to_positions_in_pictures(task: Task) -> dict[int, tuple[int, int, int]]:
    """Return a mapping from the index of each visible object to the position of one of its pixels.

    The position is the number of a picture of the task, from 1, and the column and row in this picture.

    Raises:
        InputError, EaiError: see `render_task_images`.
    """
    with _installed():
        from eai.extensions.scenes.pictures import map_objects_to_picture_column_and_row

        return map_objects_to_picture_column_and_row(task, VIEWS[:2])


def make_film(task: Task, states: Sequence[State]) -> bytes:
    """Return the states of an episode as an animated GIF.

    Raises:
        InputError, EaiError: see `render_task_images`.
    """
    with _installed():
        from eai.extensions.scenes.pictures import render_film

        return render_film(task, states)


def make_film_of_answer(record: Record, suite: Suite) -> bytes:
    """Return a film (an animated GIF) of the states that an answer passed through.

    Raises:
        InputError: the states are not known, or the scene cannot be built.
        EaiError: see `render_task_images`.
    """
    episode = replay_record(record, suite)
    if episode is None:
        raise InputError(
            f"--film: the answer to {record.task_id} has no plan, or was scored with other data: "
            "choose an answer with a plan, or score it again"
        )
    return make_film(*episode)


def open_camera(task: Task) -> Camera:
    """Return a camera in a task's scene; close it after use. `MujocoScene.show_state` shows later states.

    Raises:
        InputError, EaiError: see `render_task_images`.
    """
    with _installed():
        from eai.extensions.scenes.camera import Camera
        from eai.extensions.scenes.scene import MujocoScene

        return Camera(MujocoScene(task))
