"""Cameras: views of a scene with bodies, in colours, as distances, and of which thing each pixel is."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np

from eai.base.errors import EaiError
from eai.extensions.scenes.body import Array, Box, Vector
from eai.extensions.scenes.geometry import around
from eai.extensions.scenes.placing import Pose
from eai.extensions.scenes.scene import BodyScene

if TYPE_CHECKING:
    from eai.extensions.scenes.told import Told

SIZE = (640, 480)
"""The width and height of a picture, in pixels."""

View: TypeAlias = Literal["head", "near", "top"]
"""From where a scene is seen: the robot's head, near the place of work, or from above."""

_NEEDED = "pictures of bodies need EGL (MUJOCO_GL=egl; on Debian: apt install libegl1 libgl1-mesa-dri)"
_EYES = 1.6
"""How high the robot's eyes are, in metres."""

_FARTHEST = 9.0
"""How far one steps back to see everything, in metres."""

_HANDS = {0: -0.22, 1: 0.22}
"""How far beside the middle of the view the left and the right hand are."""


class _Sight(NamedTuple):
    """Where an eye is, what it looks at, and how many degrees high its field of view is."""

    eye: Vector
    at: Vector
    angle: float

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """The way ahead, to the right and up, each of length 1."""
        way = np.array(self.at) - np.array(self.eye)
        way /= np.linalg.norm(way)
        right = np.cross(way, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        return way, right, np.cross(right, way)


class Camera:
    """Pictures of a scene, drawn by software or a GPU through EGL; to be closed when it is done with.

    Args:
        scene: the scene.
        size: width and height of pictures, in pixels.
        shadows: whether lamps throw shadows, which takes two thirds of the time.

    Attributes:
        scene: the scene.

    Raises:
        EaiError: nothing can be drawn; says what to install.
    """

    def __init__(self, scene: BodyScene, size: tuple[int, int] = SIZE, *, shadows: bool = True) -> None:
        self.scene, self._mujoco = scene, scene.mujoco
        self._shadows = shadows
        try:
            self._renderer = self._mujoco.Renderer(scene.model, size[1], size[0])
        except Exception as error:  # of the library, of OpenGL's, or that there is none
            raise EaiError(f"{_NEEDED}: {error}") from error

    def colours(self, view: View) -> Any:
        """The picture: an array of height, width and 3 colours, 8 bits each."""
        return self._drawn(view)

    def depth(self, view: View) -> Any:
        """How far away everything is, in metres along the view: an array of height and width."""
        self._renderer.enable_depth_rendering()
        try:
            return self._drawn(view)
        finally:
            self._renderer.disable_depth_rendering()

    def objects(self, view: View) -> Any:
        """The index of the thing that each pixel is of, -1 for none: an array of height and width."""
        self._renderer.enable_segmentation_rendering()
        try:
            geoms = self._drawn(view)[..., 0]
        finally:
            self._renderer.disable_segmentation_rendering()
        owner = np.full(self.scene.model.ngeom + 1, -1)
        for thing, own in self.scene.geoms.items():
            owner[own.start : own.stop] = thing
        return owner[geoms]

    def close(self) -> None:
        """Free what it draws with."""
        self._renderer.close()

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _drawn(self, view: View) -> Any:
        scene, sight = self.scene, _SIGHTS[view](self.scene)
        way = np.array(sight.at) - np.array(sight.eye)
        far = float(np.linalg.norm(way))
        camera = self._mujoco.MjvCamera()
        camera.lookat[:] = sight.at
        camera.distance = far
        camera.azimuth = math.degrees(math.atan2(way[1], way[0]))
        camera.elevation = math.degrees(math.asin(way[2] / far))
        scene.model.vis.global_.fovy = sight.angle
        for hand, thing in scene.told.hands.items():
            scene.move(thing, _in_hand(sight, _HANDS[hand], max(scene.told.bodies[thing].size)))
        self._renderer.update_scene(scene.data, camera)
        self._renderer.scene.flags[self._mujoco.mjtRndFlag.mjRND_SHADOW] = self._shadows
        return self._renderer.render()


def _from_head(scene: BodyScene) -> _Sight:
    """From the front of the room in which most things are, as far back as it takes to see them all."""
    told, room = scene.told, scene.told.fullest
    (x0, y0, _), (x1, y1, _) = scene.rooms[room]
    seen = [thing for thing in told.bodies if told.room_of(thing) == room]
    at = np.array([x0 + 0.52 * (x1 - x0), y0 + 0.62 * (y1 - y0), 0.6])
    middles = _corners(scene, seen).reshape(-1, 8, 3).mean(1)
    sight = _Sight(_vector(at + np.array([0.0, 0.0, 1.15])), _vector(at), 64)
    return _fitted(sight, middles, np.array([-0.12, -1.0, 0.0]), 0.6 * (y1 - y0), scene.rooms[room])


def _nearby(scene: BodyScene) -> _Sight:
    """From before the thing that carries most others, or else before what stands in the fullest room."""
    told = scene.told
    place = _busiest(told)
    if place is None:
        here = [i for i in told.visible if told.room_of(i) == told.fullest]
        seen = [i for i in here if told.bodies[i].stand == "free"] or here
        if not seen:
            return _from_head(scene)
        ahead = np.array([0.0, -1.0, 0.0])
    else:
        on_it = [thing for thing in told.bodies if told.root(thing) == place and thing != place]
        seen = [thing for thing in on_it if not told.is_shut_in(thing)]
        is_furniture = told.bodies[place].stand not in ("free", "middle")
        ahead = scene.front(place) if is_furniture else np.array([0.0, -1.0, 0.0])
    points = _corners(scene, seen)
    if not points.size:  # all that could be seen there is in the robot's hands
        points = _corners(scene, told.bodies if place is None else [place])
    low, high = points.min(0), points.max(0)
    at = (low + high) / 2
    reach = 0.9 if place is None else 0.9 + float(abs(ahead) @ (np.ptp(around(scene, place), 0))) / 2
    eye = (float(at[0]), float(at[1]), max(_EYES, float(high[2]) + 0.35))
    room = scene.rooms[told.fullest if place is None else told.room_of(place)]
    return _fitted(_Sight(eye, _vector(at), 52), points, ahead, reach, room)


def _corners(scene: BodyScene, things: Collection[int]) -> Array:
    """The corners of the boxes around things: three numbers each."""
    boxes = [around(scene, thing) for thing in things if not scene.told.is_held(thing)]
    return np.array(
        [[box[i, 0], box[j, 1], box[k, 2]] for box in boxes for i, j, k in product((0, 1), repeat=3)]
    )


def _fitted(start: _Sight, points: Array, ahead: Array, reach: float, room: Box) -> _Sight:
    """A sight from ahead of a place, between the walls, as far away as it takes to see all points."""
    ahead = ahead / np.linalg.norm(ahead)
    while True:
        eye = np.array(start.eye) + reach * ahead
        eye[0] = np.clip(eye[0], room[0, 0] + 0.1, room[1, 0] - 0.1)
        sight = start._replace(eye=_vector(eye))
        if reach > _FARTHEST or _sees(sight, points):
            return sight
        reach += 0.2


def _sees(sight: _Sight, points: Array) -> bool:
    """Whether points are in a picture, its rim left free."""
    (way, right, above), from_eye = sight.axes, points - np.array(sight.eye)
    far = from_eye @ way
    most = 0.94 * math.tan(math.radians(sight.angle) / 2)
    across, up = from_eye @ right / far, from_eye @ above / far
    return bool(
        (far > 0.1).all() and (abs(across) < most * SIZE[0] / SIZE[1]).all() and (abs(up) < most).all()
    )


def _vector(array: Array) -> Vector:
    x, y, z = array.tolist()
    return (x, y, z)


def _busiest(told: Told) -> int | None:
    """The thing on or in which most others are to be seen, if any are."""
    carried = [thing for thing in told.visible if told.carrier(thing) is not None]
    many = Counter(map(told.root, carried))
    return max(many, key=lambda thing: (many[thing], -thing), default=None)


def _from_above(scene: BodyScene) -> _Sight:
    """From high above the middle of all rooms."""
    boxes = list(scene.rooms.values())
    x0, x1 = min(box[0, 0] for box in boxes), max(box[1, 0] for box in boxes)
    y1 = max(box[1, 1] for box in boxes)
    middle, across = (x0 + x1) / 2, max((x1 - x0) * 0.76, y1)
    height = across / 2 / math.tan(math.radians(18)) + 1.5
    return _Sight((middle, y1 / 2 - 0.35 * y1, height), (middle, y1 / 2, 0.0), 36)


_SIGHTS: Mapping[View, Callable[[BodyScene], _Sight]] = {
    "head": _from_head,
    "near": _nearby,
    "top": _from_above,
}


def _in_hand(sight: _Sight, aside: float, size: float) -> Pose:
    """Where a thing is seen that a hand holds."""
    way, right, above = sight.axes
    near = 0.45 + size
    at = np.array(sight.eye) + near * way + near * 1.3 * aside * right - 0.3 * near * above
    return Pose(_vector(at))
