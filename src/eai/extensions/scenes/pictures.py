"""Render scenes of 3D bodies as PNG pictures, with numbered boxes on request, and as animated GIFs."""

from __future__ import annotations

import io
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from eai.extensions.scenes.camera import PICTURE_SIZE, Camera, CameraView
from eai.extensions.scenes.scene import MujocoScene
from eai.tasks.task import Task
from eai.world.state import State

_MIN_PIXELS = 12
"""Minimum number of visible pixels for an object to get a numbered box or a reported location."""

_INK, _PAPER = (20, 20, 20), (255, 235, 60)


def render_pictures(
    task: Task, views: Collection[CameraView], *, numbered: bool = False, state: State | None = None
) -> list[bytes]:
    """Return one PNG picture for each view of a state of a task.

    Args:
        task: the task.
        views: the viewpoints.
        numbered: whether each object gets a box with its index.
        state: the state to show; the initial state if None.

    Raises:
        InputError: an object does not fit into its room or container, or has no three-dimensional shape.
        EaiError: the renderer cannot start. The message says what to install.
    """
    with Camera(MujocoScene(task)) as camera:
        if state is not None and state != task.initial:
            camera.scene.show_state(state)
        drawn = [Image.fromarray(camera.render_colours(view)) for view in views]
        if numbered:
            for image, view in zip(drawn, views, strict=True):
                _draw_object_numbers_on_image(image, camera.render_object_indexes(view))
    return [_encode_image(image, "PNG") for image in drawn]


def render_film(task: Task, states: Iterable[State]) -> bytes:
    """Return the states of an episode as an animated GIF, at half the width and height of pictures.

    Raises:
        InputError: an object does not fit into its room or container, or has no three-dimensional shape.
        EaiError: the renderer cannot start. The message says what to install.
    """
    drawn = []
    scene = MujocoScene(task)
    with Camera(scene, (PICTURE_SIZE[0] // 2, PICTURE_SIZE[1] // 2), shadows=False) as camera:
        for state in states:
            scene.show_state(state)
            drawn.append(Image.fromarray(camera.render_colours("head")).quantize(128))
    return _encode_image(drawn[0], "GIF", save_all=True, append_images=drawn[1:], duration=700, loop=0)


def map_objects_to_picture_column_and_row(
    task: Task, views: Sequence[CameraView]
) -> dict[int, tuple[int, int, int]]:
    """Return a pixel of each object that is visible in pictures of the initial state of a task.

    The pixel is in the first picture that shows the object, close to the middle of the object's visible
    pixels.

    Returns:
        a mapping from the index of the object to the number of the picture (from 1), the column and the row.

    Raises:
        InputError, EaiError: see `render_pictures`.
    """
    pixels: dict[int, tuple[int, int, int]] = {}
    with Camera(MujocoScene(task)) as camera:
        for number, view in enumerate(views, 1):
            for object_index, rows, columns in _list_visible_objects_and_pixels(
                camera.render_object_indexes(view)
            ):
                nearest = int(np.hypot(rows - rows.mean(), columns - columns.mean()).argmin())
                pixels.setdefault(object_index, (number, int(columns[nearest]), int(rows[nearest])))
    return pixels


def _list_visible_objects_and_pixels(object_image: Any) -> Iterator[tuple[int, Any, Any]]:
    """Yield objects with enough visible pixels (`_MIN_PIXELS`), and the rows and columns of their pixels."""
    for object_index in np.unique(object_image[object_image >= 0]).tolist():
        rows, columns = np.nonzero(object_image == object_index)
        if len(rows) >= _MIN_PIXELS:
            yield object_index, rows, columns


def _draw_object_numbers_on_image(image: Image.Image, object_image: Any) -> None:
    draw = ImageDraw.Draw(image)
    for object_index, rows, columns in _list_visible_objects_and_pixels(object_image):
        left, top = int(columns.min()), int(rows.min())
        draw.rectangle((left - 1, top - 1, int(columns.max()) + 1, int(rows.max()) + 1), outline=_PAPER)
        around = draw.textbbox((left, max(0, top - 11)), str(object_index))
        draw.rectangle(around, fill=_PAPER)
        draw.text((left, max(0, top - 11)), str(object_index), fill=_INK)


def _encode_image(image: Image.Image, form: str, **options: Any) -> bytes:
    file = io.BytesIO()
    image.save(file, form, **options)
    return file.getvalue()
