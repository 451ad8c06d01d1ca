"""Cameras: render a scene with bodies as colours, as distances, or as the object at each pixel."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np

from eai.base.errors import EaiError
from eai.extensions.scenes.body import Array, Box, Vector
from eai.extensions.scenes.geometry import bounding_box
from eai.extensions.scenes.placing import Pose
from eai.extensions.scenes.scene import MujocoScene

if TYPE_CHECKING:
    from eai.extensions.scenes.locations import ObjectLocations

PICTURE_SIZE = (640, 480)
"""Width and height of a picture in pixels."""

CameraView: TypeAlias = Literal["head", "near", "top"]
"""Viewpoint of a camera: the robot's head, near the objects of the task, or above the rooms."""

_EGL_PACKAGES = "MUJOCO_GL=egl; on Debian: apt install libegl1 libgl1-mesa-dri"
_EYE_HEIGHT = 1.6
"""Height of the robot's eyes in metres."""

_MAX_DISTANCE = 9.0
"""Maximum distance in metres that a camera moves back to get objects into the picture."""

_HAND_OFFSETS = {0: -0.22, 1: 0.22}
"""Horizontal offsets of the left (0) and right (1) hand from the middle of the picture.

They are relative to the distance of the hand from the eye.
"""


class _Viewpoint(NamedTuple):
    """A viewpoint: location of the eye, location of the target, and vertical field of view in degrees."""

    eye: Vector
    at: Vector
    angle: float

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """The directions ahead, to the right and up of the viewpoint, as vectors of length 1."""
        way = np.array(self.at) - np.array(self.eye)
        way /= np.linalg.norm(way)
        right = np.cross(way, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        return way, right, np.cross(right, way)


class Camera:
    """Renders pictures of a scene through EGL, on a GPU or in software. Close the camera after use.

    Args:
        scene: the scene.
        size: width and height of pictures in pixels.
        shadows: whether lamps cast shadows. Shadows take two thirds of the rendering time.

    Attributes:
        scene: the scene.

    Raises:
        EaiError: nothing can be drawn, for example because EGL is missing. The message says what to install.
    """

    def __init__(
        self, scene: MujocoScene, size: tuple[int, int] = PICTURE_SIZE, *, shadows: bool = True
    ) -> None:
        self.scene, self._mujoco = scene, scene.mujoco
        self._shadows = shadows
        try:
            self._renderer = self._mujoco.Renderer(scene.model, size[1], size[0])
        except Exception as error:  # an error of MuJoCo or OpenGL, or EGL is missing
            raise EaiError(f"rendered pictures need EGL ({_EGL_PACKAGES}): {error}") from error

    def render_colours(self, view: CameraView) -> Any:
        """Return the picture as an array of height x width x 3: red, green and blue of 8 bits."""
        return self._render_view(view)

    def render_depth(self, view: CameraView) -> Any:
        """Return the distance at each pixel, in metres along the view, as an array of height x width."""
        self._renderer.enable_depth_rendering()
        try:
            return self._render_view(view)
        finally:
            self._renderer.disable_depth_rendering()

    def render_object_indexes(self, view: CameraView) -> Any:
        """Return the index of the object at each pixel, or -1 for none, as an array of height x width."""
        self._renderer.enable_segmentation_rendering()
        try:
            geoms = self._render_view(view)[..., 0]
        finally:
            self._renderer.disable_segmentation_rendering()
        owner = np.full(self.scene.model.ngeom + 1, -1)
        for object_index, own in self.scene.mujoco_geoms_of_object.items():
            owner[own.start : own.stop] = object_index
        return owner[geoms]

    def close(self) -> None:
        """Free the memory of the renderer."""
        self._renderer.close()

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _render_view(self, view: CameraView) -> Any:
        scene, sight = self.scene, _VIEWPOINTS[view](self.scene)
        way = np.array(sight.at) - np.array(sight.eye)
        far = float(np.linalg.norm(way))
        camera = self._mujoco.MjvCamera()
        camera.lookat[:] = sight.at
        camera.distance = far
        camera.azimuth = math.degrees(math.atan2(way[1], way[0]))
        camera.elevation = math.degrees(math.asin(way[2] / far))
        scene.model.vis.global_.fovy = sight.angle
        for hand, object_index in scene.locations.hands.items():
            scene.move_object(
                object_index,
                _find_pose_of_held_object(
                    sight, _HAND_OFFSETS[hand], max(scene.locations.bodies[object_index].size)
                ),
            )
        self._renderer.update_scene(scene.data, camera)
        self._renderer.scene.flags[self._mujoco.mjtRndFlag.mjRND_SHADOW] = self._shadows
        return self._renderer.render()


def _find_viewpoint_at_head_height(scene: MujocoScene) -> _Viewpoint:
    """Return a viewpoint in front of the room with most objects. It shows all objects of this room."""
    locations, room = scene.locations, scene.locations.fullest_room
    (x0, y0, _), (x1, y1, _) = scene.rooms[room]
    seen = [object_index for object_index in locations.bodies if locations.find_room(object_index) == room]
    at = np.array([x0 + 0.52 * (x1 - x0), y0 + 0.62 * (y1 - y0), 0.6])
    middles = _list_corners(scene, seen).reshape(-1, 8, 3).mean(1)
    sight = _Viewpoint(_to_vector(at + np.array([0.0, 0.0, 1.15])), _to_vector(at), 64)
    return _move_back_until_visible(
        sight, middles, np.array([-0.12, -1.0, 0.0]), 0.6 * (y1 - y0), scene.rooms[room]
    )


def _find_viewpoint_showing_most_loaded_object(scene: MujocoScene) -> _Viewpoint:
    """Return the viewpoint that shows the object with most objects on or in it, and these objects.

    If no object carries another, the viewpoint shows the objects of the room with most objects.
    """
    locations = scene.locations
    place = _find_object_carrying_most_objects(locations)
    if place is None:
        here = [i for i in locations.visible_objects if locations.find_room(i) == locations.fullest_room]
        seen = [i for i in here if locations.bodies[i].stand == "free"] or here
        if not seen:
            return _find_viewpoint_at_head_height(scene)
        ahead = np.array([0.0, -1.0, 0.0])
    else:
        on_it = [
            object_index
            for object_index in locations.bodies
            if locations.find_bottom_of_pile(object_index) == place and object_index != place
        ]
        seen = [object_index for object_index in on_it if not locations.is_shut_in(object_index)]
        is_furniture = locations.bodies[place].stand not in ("free", "middle")
        ahead = scene.find_front_direction(place) if is_furniture else np.array([0.0, -1.0, 0.0])
    points = _list_corners(scene, seen)
    if not points.size:  # all objects to show are in the robot's hands
        points = _list_corners(scene, locations.bodies if place is None else [place])
    low, high = points.min(0), points.max(0)
    at = (low + high) / 2
    reach = 0.9 if place is None else 0.9 + float(abs(ahead) @ (np.ptp(bounding_box(scene, place), 0))) / 2
    eye = (float(at[0]), float(at[1]), max(_EYE_HEIGHT, float(high[2]) + 0.35))
    room = scene.rooms[locations.fullest_room if place is None else locations.find_room(place)]
    return _move_back_until_visible(_Viewpoint(eye, _to_vector(at), 52), points, ahead, reach, room)


def _list_corners(scene: MujocoScene, object_indices: Collection[int]) -> Array:
    boxes = [
        bounding_box(scene, object_index)
        for object_index in object_indices
        if not scene.locations.is_held(object_index)
    ]
    return np.array(
        [[box[i, 0], box[j, 1], box[k, 2]] for box in boxes for i, j, k in product((0, 1), repeat=3)]
    )


def _move_back_until_visible(
    start: _Viewpoint, points: Array, direction: Array, distance: float, room: Box
) -> _Viewpoint:
    """Move a viewpoint back inside the room until it shows all points or is `_MAX_DISTANCE` away."""
    direction = direction / np.linalg.norm(direction)
    while True:
        eye = np.array(start.eye) + distance * direction
        eye[0] = np.clip(eye[0], room[0, 0] + 0.1, room[1, 0] - 0.1)
        viewpoint = start._replace(eye=_to_vector(eye))
        if distance > _MAX_DISTANCE or _shows_all_points(viewpoint, points):
            return viewpoint
        distance += 0.2


def _shows_all_points(viewpoint: _Viewpoint, points: Array) -> bool:
    """Whether all points are in the picture, outside a margin of 6 % at its edges."""
    (ahead, right, above), from_eye = viewpoint.axes, points - np.array(viewpoint.eye)
    distances = from_eye @ ahead
    most = 0.94 * math.tan(math.radians(viewpoint.angle) / 2)
    across, up = from_eye @ right / distances, from_eye @ above / distances
    return bool(
        (distances > 0.1).all()
        and (abs(across) < most * PICTURE_SIZE[0] / PICTURE_SIZE[1]).all()
        and (abs(up) < most).all()
    )


def _to_vector(array: Array) -> Vector:
    x, y, z = array.tolist()
    return (x, y, z)


def _find_object_carrying_most_objects(locations: ObjectLocations) -> int | None:
    """Return the object that carries most visible objects, directly or not; None if no object carries any."""
    carried = [
        object_index
        for object_index in locations.visible_objects
        if locations.find_relation_and_carrier(object_index) is not None
    ]
    many = Counter(map(locations.find_bottom_of_pile, carried))
    return max(many, key=lambda object_index: (many[object_index], -object_index), default=None)


def _find_viewpoint_from_above(scene: MujocoScene) -> _Viewpoint:
    boxes = list(scene.rooms.values())
    x0, x1 = min(box[0, 0] for box in boxes), max(box[1, 0] for box in boxes)
    y1 = max(box[1, 1] for box in boxes)
    middle, across = (x0 + x1) / 2, max((x1 - x0) * 0.76, y1)
    height = across / 2 / math.tan(math.radians(18)) + 1.5
    return _Viewpoint((middle, y1 / 2 - 0.35 * y1, height), (middle, y1 / 2, 0.0), 36)


_VIEWPOINTS: Mapping[CameraView, Callable[[MujocoScene], _Viewpoint]] = {
    "head": _find_viewpoint_at_head_height,
    "near": _find_viewpoint_showing_most_loaded_object,
    "top": _find_viewpoint_from_above,
}


def _find_pose_of_held_object(viewpoint: _Viewpoint, offset_to_right: float, size: float) -> Pose:
    """Return the pose in which an object in a hand appears in the picture."""
    way, right, above = viewpoint.axes
    near = 0.45 + size
    at = np.array(viewpoint.eye) + near * way + near * 1.3 * offset_to_right * right - 0.3 * near * above
    return Pose(_to_vector(at))
