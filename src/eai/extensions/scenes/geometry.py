"""Test spatial relations with contacts, boxes and rays, as iGibson defines them (``igibson/object_states``).

Rays begin at the middle of the first object's body. The first object is

* on the second object if both touch, a ray down meets the second, and a ray up does not;
* inside the second object if its middle is in the bounding box of the second, and if on two of three axes the
  rays in both directions meet the second;
* next to the second object if their boxes are near, and a horizontal ray from one of them meets the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from eai.extensions.scenes.body import Array, Box

_HORIZONTAL_REACH, _VERTICAL_REACH = 1.0, 5.0
"""Maximum lengths, in metres, of the horizontal and vertical rays that test how two objects lie."""

_AXIS_PAIR_COUNT = 5
"""Number of pairs of perpendicular horizontal axes. The pairs are rotated by 0 to 90 degrees.

Rays along these axes test whether an object is inside or next to another object.
"""

_MAX_DISTANCE_SHARE = 1 / 6
"""Maximum distance between the boxes of two neighbours, as a share of the mean side length of both boxes."""

_UP, _DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])


class _PlacedBodies(Protocol):
    """A MuJoCo model with the bodies of objects.

    Attributes:
        mujoco: the MuJoCo module.
        model: the model.
        data: the MuJoCo data: the poses and contacts of the model.
    """

    mujoco: Any
    model: Any
    data: Any

    @property
    def mujoco_body_of_object(self) -> Mapping[int, int]:
        """Mapping from the index of each object to the index of its MuJoCo body."""

    @property
    def mujoco_geoms_of_object(self) -> Mapping[int, range]:
        """Numbers of the MuJoCo geoms (shapes) of each object, by its index: one geom for each part."""


def is_on_top(scene: _PlacedBodies, first: int, second: int) -> bool:
    """Whether the first object lies on the second."""
    if not _are_touching(scene, first, second):
        return False
    middle = _find_middle(scene, first)
    return _does_ray_meet(scene, middle, _DOWN, second, _VERTICAL_REACH) and not _does_ray_meet(
        scene, middle, _UP, second, _VERTICAL_REACH
    )


def is_under(scene: _PlacedBodies, first: int, second: int) -> bool:
    """Whether the first object is under the second."""
    middle = _find_middle(scene, first)
    return _does_ray_meet(scene, middle, _UP, second, _VERTICAL_REACH) and not _does_ray_meet(
        scene, middle, _DOWN, second, _VERTICAL_REACH
    )


def is_inside(scene: _PlacedBodies, first: int, second: int) -> bool:
    """Whether the first object is inside the second."""
    middle, (low, high) = _find_middle(scene, first), bounding_box(scene, second)
    if not ((middle >= low) & (middle <= high)).all():
        return False
    levels = [
        [_do_rays_hit_object_both_ways(scene, middle, axis, second, _HORIZONTAL_REACH) for axis in plane]
        for plane in _list_rotated_horizontal_axis_pairs()
    ]
    if any(all(plane) for plane in levels):
        return True
    return _do_rays_hit_object_both_ways(scene, middle, _UP, second, _VERTICAL_REACH) and any(
        any(plane) for plane in levels
    )


def is_next_to(scene: _PlacedBodies, first: int, second: int) -> bool:
    """Whether two objects are next to each other."""
    boxes = [bounding_box(scene, first), bounding_box(scene, second)]
    low, high = (np.array([box[i] for box in boxes]) for i in (0, 1))
    apart = np.maximum(0, low.max(0) - high.min(0))
    if math.hypot(*apart) > (high - low).sum() / 3 * _MAX_DISTANCE_SHARE:
        return False
    return any(
        _does_ray_meet(scene, _find_middle(scene, a), sign * axis, b, _HORIZONTAL_REACH)
        for a, b in ((first, second), (second, first))
        for plane in _list_rotated_horizontal_axis_pairs()
        for axis in plane
        for sign in (1, -1)
    )


def is_on_floor(scene: _PlacedBodies, object_index: int, room: Box) -> bool:
    """Whether an object is on the floor of a room. Objects that hang on the walls of the room count, too."""
    middle, (low, high) = _find_middle(scene, object_index), bounding_box(scene, object_index)
    at_home = all(room[0, i] <= middle[i] <= room[1, i] for i in (0, 1))
    is_fixed = scene.model.body_dofnum[scene.mujoco_body_of_object[object_index]] == 0
    return bool(at_home and (is_fixed or low[2] < 0.01) and high[2] > 0)


def bounding_box(scene: _PlacedBodies, object_index: int) -> Box:
    """Return the box around the solid parts of an object."""
    geoms = _list_solid_geoms(scene, object_index)
    axes = scene.data.geom_xmat[geoms].reshape(-1, 3, 3)
    aabb = scene.model.geom_aabb[geoms]
    middle = scene.data.geom_xpos[geoms] + np.einsum("gij,gj->gi", axes, aabb[:, :3])
    half = np.einsum("gij,gj->gi", np.abs(axes), aabb[:, 3:])
    return np.array([(middle - half).min(0), (middle + half).max(0)])


def _find_middle(scene: _PlacedBodies, object_index: int) -> Array:
    middle: Array = scene.data.xpos[scene.mujoco_body_of_object[object_index]]
    return middle


def _list_solid_geoms(scene: _PlacedBodies, object_index: int) -> list[int]:
    return [geom for geom in scene.mujoco_geoms_of_object[object_index] if scene.model.geom_contype[geom]]


def _are_touching(scene: _PlacedBodies, first: int, second: int) -> bool:
    bodies = {scene.mujoco_body_of_object[first], scene.mujoco_body_of_object[second]}
    owners = scene.model.geom_bodyid[scene.data.contact.geom[: scene.data.ncon]]
    return any({*pair} == bodies for pair in owners.tolist())


def _do_rays_hit_object_both_ways(
    scene: _PlacedBodies, start: Array, axis: Array, object_index: int, max_distance: float
) -> bool:
    return _does_ray_meet(scene, start, axis, object_index, max_distance) and _does_ray_meet(
        scene, start, -axis, object_index, max_distance
    )


def _does_ray_meet(
    scene: _PlacedBodies, start: Array, direction: Array, object_index: int, max_distance: float
) -> bool:
    """Whether a ray meets a solid part of an object within the given distance."""
    model, data, ray = scene.model, scene.data, scene.mujoco.mju_rayGeom
    for geom in _list_solid_geoms(scene, object_index):
        form = int(model.geom_type[geom])
        distance = ray(
            data.geom_xpos[geom], data.geom_xmat[geom], model.geom_size[geom], start, direction, form
        )
        if 0 <= distance <= max_distance:
            return True
    return False


def _list_rotated_horizontal_axis_pairs() -> list[list[Array]]:
    angles = [i * math.pi / 2 / (_AXIS_PAIR_COUNT - 1) for i in range(_AXIS_PAIR_COUNT)]
    return [
        [np.array([math.cos(a), math.sin(a), 0.0]), np.array([-math.sin(a), math.cos(a), 0.0])]
        for a in angles
    ]
