"""Find free poses for bodies: on, in, under or next to other bodies, or on the floor of a room.

Poses are drawn at random, from a seed. This module simulates no physics: bodies are axis-aligned boxes,
upright or on a side, rotated by quarter turns.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from eai.base.errors import InputError
from eai.extensions.scenes.body import Array, Box, Vector
from eai.extensions.scenes.locations import ObjectLocations

_SETTLING_GAP = 0.004
"""Gap in metres under a newly placed object. It closes when the simulation lets the objects settle."""

_RANDOM_TRIES = 80
"""Number of random poses that are tried for an object. Then systematic poses are tried, from the corners."""


_Rotation: TypeAlias = tuple[float, float, float, float]
"""Rotation of a body: a quaternion, its real part first."""

_AreaWithBoxes: TypeAlias = tuple[Box, Array, Array]
"""An area in which an object may be placed, and the low and high corners of its obstacles.

The area and the obstacles are boxes. Obstacles are parts of other objects that overlap the area or nearly
touch it.
"""


class Pose(NamedTuple):
    """Location of the middle of a body, and its rotation: a quaternion, its real part first."""

    at: Vector
    turn: _Rotation = (1.0, 0.0, 0.0, 0.0)

    @property
    def rotation_matrix(self) -> Array:
        """The rotation as a matrix, whose columns are the body's own axes."""
        w, x, y, z = self.turn
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    def to_scene_box(self, local: Box, turn: float = 0.0) -> Box:
        """Return the axis-aligned box in the scene that encloses one box of a body with this pose.

        Args:
            local: the box of the body, relative to the middle of the body.
            turn: rotation of this box about its own upright axis, in radians.
        """
        axes = self.rotation_matrix
        cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
        x, y, z = (local[1] - local[0]) / 2
        half = np.abs(axes) @ np.array([cos * x + sin * y, sin * x + cos * y, z])
        middle = np.array(self.at) + axes @ local.mean(0)
        return np.array([middle - half, middle + half])


def make_rotation_by_quarter_turns(quarter_turns: int) -> _Rotation:
    """Return the rotation by a number of quarter turns to the left, seen from above."""
    return (math.cos(quarter_turns * math.pi / 4), 0.0, 0.0, math.sin(quarter_turns * math.pi / 4))


FLAT = tuple(make_rotation_by_quarter_turns(quarter_turns) for quarter_turns in range(4))
_R = math.sqrt(0.5)
UPRIGHT = ((_R, _R, 0.0, 0.0), (_R, 0.0, _R, 0.0), (0.5, 0.5, 0.5, 0.5), (0.5, 0.5, -0.5, 0.5))
"""Rotations of objects that stand on a narrow side, as a book on a shelf does."""


class ObjectPlacer:
    """Finds free poses for bodies, and stores the poses of placed bodies.

    Args:
        locations: the bodies and states of objects. A state such as `open` decides which parts of a body
            exist.
        names: names of objects, for messages.
        seed: seed of random poses.

    Attributes:
        poses: the pose of each placed object.
        furniture: the objects that do not move.
    """

    def __init__(self, locations: ObjectLocations, names: Sequence[str], seed: str) -> None:
        self.bodies, self.states, self.names = locations.bodies, locations.states, names
        self.poses: dict[int, Pose] = {}
        self.furniture: frozenset[int] = frozenset()
        self._random = random.Random(seed)  # noqa: S311 - a place, not a secret
        self._low, self._high = np.zeros((0, 3)), np.zeros((0, 3))
        self._owner = np.zeros(0, dtype=int)

    def put(self, object_index: int, pose: Pose) -> None:
        """Store the pose of an object."""
        self.poses[object_index] = pose
        solid = [
            part
            for part in self.bodies[object_index].parts
            if part.is_solid and self.is_in_required_state(object_index, part.when)
        ]
        boxes = np.array([pose.to_scene_box(part.box, part.turn) for part in solid]).reshape(-1, 2, 3)
        self._low = np.concatenate([self._low, boxes[:, 0]])
        self._high = np.concatenate([self._high, boxes[:, 1]])
        self._owner = np.concatenate([self._owner, np.full(len(boxes), object_index)])

    def is_in_required_state(self, object_index: int, required_state: str) -> bool:
        """Return whether a part of an object exists now, given the state that the part requires.

        Some parts exist only in a state such as `open`. An empty text requires no state.
        """
        return not required_state or required_state in self.states[object_index]

    def find_pose_on(self, object_index: int, support: int, near: int | None = None) -> Pose:
        """Return a free pose for an object on a support and, if given, next to the object ``near``.

        Raises:
            InputError: the support has no free space.
        """
        body = self.bodies[support]
        x, y, z = (size / 2 for size in body.size)
        tops = body.tops or (np.array([[-x, -y, z], [x, y, z]]),)
        areas = [
            self._widen_area_for_large_object(
                object_index, _resize_box_to_height(self.poses[support].to_scene_box(top), 3.0)
            )
            for top in tops
        ]
        if near is not None:
            areas = [
                _intersect(strip, area)
                for area in areas
                for strip in self._list_floor_areas_beside_object(object_index, near)
            ]
        return self._find_free_pose(object_index, areas, FLAT, f"on {self.names[support]}")

    def _widen_area_for_large_object(self, object_index: int, area: Box) -> Box:
        """Widen an area that is too small for an object, so that the object may jut out.

        A side is not widened if it lacks 40 % or more of its length.
        """
        size, sides = np.sort(self.bodies[object_index].size[:2]), np.ptp(area, 0)[:2]
        lacking = size[np.argsort(np.argsort(sides))] + 2.5 * _SETTLING_GAP - sides
        juts = np.append(np.where((lacking > 0) & (lacking < 0.4 * sides), lacking / 2, 0.0), 0.0)
        wider: Box = area + juts * np.array([[-1.0], [1.0]])
        return wider

    def find_pose_inside(self, object_index: int, container: int) -> Pose:
        """Return a free pose inside a container, on top of its contents if necessary.

        Raises:
            InputError: the container has no free space.
        """
        body, pose = self.bodies[container], self.poses[container]
        areas = [pose.to_scene_box(space) for space in body.spaces]
        closed = "closed" in self.states[container] or not body.slack
        slack = 1 if closed else 1 + body.slack
        raised = [_resize_box_to_height(area, (area[1, 2] - area[0, 2]) * slack) for area in areas]
        where = f"in {self.names[container]}"
        try:
            return self._find_free_pose(object_index, raised, (*FLAT, *UPRIGHT), where)
        except InputError:
            return self._find_free_pose(object_index, raised, (*FLAT, *UPRIGHT), where, container)

    def find_pose_below(self, object_index: int, upper_object: int, room: Box) -> Pose:
        """Return a free pose under an object, inside a room.

        Raises:
            InputError: the space under the object is not free.
        """
        areas = [
            _intersect(self.poses[upper_object].to_scene_box(space), room)
            for space in self.bodies[upper_object].below
        ]
        return self._find_free_pose(object_index, areas, FLAT, f"under {self.names[upper_object]}")

    def find_pose_beside(self, object_index: int, other: int, room: Box) -> Pose:
        """Return a free pose on the floor of a room, next to an object.

        Raises:
            InputError: the floor around the object has no free space.
        """
        within = [
            _intersect(strip, room) for strip in self._list_floor_areas_beside_object(object_index, other)
        ]
        return self._find_free_pose(object_index, within, FLAT, f"next to {self.names[other]}")

    def _list_floor_areas_beside_object(self, object_index: int, neighbour: int) -> list[Box]:
        """Return four strips of floor along the sides of another object, for objects that are next to it."""
        (x0, y0, _), (x1, y1, _) = self.find_bounds(neighbour)
        narrow, wide = sorted(self.bodies[object_index].size[:2])
        reach, more = narrow + 0.03, 0.4 * wide
        sides = [(x1, y0 - more, x1 + reach, y1 + more), (x0 - reach, y0 - more, x0, y1 + more)]
        sides += [(x0 - more, y0 - reach, x1 + more, y0), (x0 - more, y1, x1 + more, y1 + reach)]
        return [np.array([[left, front, 0], [right, back, 3]]) for left, front, right, back in sides]

    def find_pose_on_floor(self, object_index: int, room: Box) -> Pose:
        """Return a free pose on the floor of a room.

        Raises:
            InputError: the floor has no free space.
        """
        middle = room + np.array([[0.2, 0.7, 0.0], [-0.2, -0.3, 0.0]])
        return self._find_free_pose(object_index, [middle, room], FLAT, "on the floor")

    def find_bounds(self, object_index: int) -> Box:
        """Return the box around the solid parts of a placed object."""
        own = self._owner == object_index
        return np.array([self._low[own].min(0), self._high[own].max(0)])

    def _find_free_pose(
        self,
        object_index: int,
        areas: Sequence[Box],
        turns: Sequence[_Rotation],
        where: str,
        within: int | None = None,
    ) -> Pose:
        """Return a free pose in one of the areas, or raise InputError.

        ``within`` is a container: the pose may then be on top of its contents.
        """
        size = np.array(self.bodies[object_index].size) / 2
        others = self._owner != object_index
        spots = [_select_boxes_near_area(area, self._low[others], self._high[others]) for area in areas]
        pose = self._sample_free_pose(size, spots, turns, within) or _find_free_pose_with_contact(
            size, spots, turns
        )
        if pose is None:
            raise InputError(f"no free space for {self.names[object_index]} {where}; choose another task")
        return pose

    def _sample_free_pose(
        self, size: Array, spots: Sequence[_AreaWithBoxes], turns: Sequence[_Rotation], within: int | None
    ) -> Pose | None:
        draw = self._random
        for number in range(_RANDOM_TRIES):
            which = 0 if number < _RANDOM_TRIES // 3 else draw.randrange(len(spots)) if spots else 0
            turn = draw.choice(turns[:4] if number < _RANDOM_TRIES // 2 else turns)
            if not spots:
                return None
            half, (area, low, high) = np.abs(Pose((0, 0, 0), turn).rotation_matrix) @ size, spots[which]
            spare = (area[1] - area[0])[:2] / 2 - half[:2] - _SETTLING_GAP
            if (spare < 0).any():
                continue
            x, y = area.mean(0)[:2] + spare * [draw.uniform(-1, 1), draw.uniform(-1, 1)]
            base = area[0, 2]
            if within is not None:
                below = _mark_boxes_overlapping_rectangle(low, high, (x, y), half)
                inner = below & (high[:, 2] < area[1, 2])
                base = max([base, *high[inner, 2]])
            pose = Pose((x, y, base + half[2] + _SETTLING_GAP), turn)
            if pose.at[2] + half[2] <= area[1, 2] and _is_box_free_of_overlaps(pose.at, half, low, high):
                return pose
        return None


def _find_free_pose_with_contact(
    size: Array, spots: Sequence[_AreaWithBoxes], turns: Sequence[_Rotation]
) -> Pose | None:
    """Return a free pose at which a box touches sides of an area or boxes in it; None if there is none."""
    for (area, low, high), turn in product(spots, turns):
        half = np.abs(Pose((0, 0, 0), turn).rotation_matrix) @ size
        z = area[0, 2] + half[2] + _SETTLING_GAP
        if z + half[2] > area[1, 2]:
            continue
        for x, y in product(
            _list_contact_coordinates(area, low, high, half, 0),
            _list_contact_coordinates(area, low, high, half, 1),
        ):
            if _is_box_free_of_overlaps((x, y, z), half, low, high):
                return Pose((x, y, z), turn)
    return None


def _list_contact_coordinates(
    area: Box, low_corners: Array, high_corners: Array, half_size: Array, axis: int
) -> Iterator[float]:
    """Return coordinates of a box's middle at which the box touches a side of the area or of another box."""
    first = area[0, axis] + half_size[axis] + _SETTLING_GAP
    last = area[1, axis] - half_size[axis] - _SETTLING_GAP
    edges = [
        first,
        last,
        *(high_corners[:, axis] + half_size[axis] + _SETTLING_GAP),
        *(low_corners[:, axis] - half_size[axis] - _SETTLING_GAP),
    ]
    return (edge for edge in sorted(edges) if first <= edge <= last)


def _is_box_free_of_overlaps(
    box_middle: Sequence[float], half_size: Array, low_corners: Array, high_corners: Array
) -> bool:
    """Whether a box overlaps no other box. The other boxes are given by their low and high corners."""
    middle = np.array(box_middle)
    overlaps = (low_corners < middle + half_size + 0.001) & (high_corners > middle - half_size - 0.001)
    return not overlaps.all(1).any()


def _mark_boxes_overlapping_rectangle(
    low_corners: Array, high_corners: Array, middle: tuple[float, float], half_size: Array
) -> Any:
    """Return an array of truth values: whether each box, seen from above, overlaps a rectangle.

    Each box has a low and a high corner. ``half_size`` is half the size of the rectangle.
    """
    low, high = np.array(middle) - half_size[:2], np.array(middle) + half_size[:2]
    return ((low_corners[:, :2] < high) & (high_corners[:, :2] > low)).all(1)


def _select_boxes_near_area(area: Box, low: Array, high: Array) -> _AreaWithBoxes:
    """Return the area, and the low and high corners of the boxes that overlap it or are within 1 cm of it.

    Each such box has a low corner and a high corner.
    """
    near = ((low < area[1] + 0.01) & (high > area[0] - 0.01)).all(1)
    return area, low[near], high[near]


def _intersect(first: Box, second: Box) -> Box:
    return np.array([np.maximum(first[0], second[0]), np.minimum(first[1], second[1])])


def _resize_box_to_height(area: Box, height: float) -> Box:
    raised: Box = area.copy()
    raised[1, 2] = raised[0, 2] + height
    return raised
