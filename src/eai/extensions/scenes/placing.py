"""Placing: poses for bodies in rooms so that each has what is said of where it is, drawn from a seed.

Nothing is simulated here: bodies stand upright or lie on a side, turned by quarters, as boxes along the axes.
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
from eai.extensions.scenes.told import Told

_GAP = 0.004
"""The air below a thing that is placed, in metres: settling lets it down."""

_TRIES = 80
"""How many places are drawn before things are packed from the corners."""


_Turn: TypeAlias = tuple[float, float, float, float]
"""How a body is turned, as in a `Pose`."""

_Spot: TypeAlias = tuple[Box, Array, Array]
"""An area, and the low and the high corners of the boxes that reach into it."""


class Pose(NamedTuple):
    """Where the middle of a body is, and how it is turned: a quaternion, its real part first."""

    at: Vector
    turn: _Turn = (1.0, 0.0, 0.0, 0.0)

    @property
    def axes(self) -> Array:
        """The rotation as a matrix: local axes in its columns."""
        w, x, y, z = self.turn
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    def box(self, local: Box, turn: float = 0.0) -> Box:
        """The box in the world around a local box, which is turned about its own upright axis."""
        axes = self.axes
        cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
        x, y, z = (local[1] - local[0]) / 2
        half = np.abs(axes) @ np.array([cos * x + sin * y, sin * x + cos * y, z])
        middle = np.array(self.at) + axes @ local.mean(0)
        return np.array([middle - half, middle + half])


def turned(quarters: int) -> _Turn:
    """The turn by so many quarters to the left, seen from above."""
    return (math.cos(quarters * math.pi / 4), 0.0, 0.0, math.sin(quarters * math.pi / 4))


FLAT = tuple(turned(quarters) for quarters in range(4))
_R = math.sqrt(0.5)
UPRIGHT = ((_R, _R, 0.0, 0.0), (_R, 0.0, _R, 0.0), (0.5, 0.5, 0.5, 0.5), (0.5, 0.5, -0.5, 0.5))
"""Turns of things that stand on a side, as a book does between others."""


class Placing:
    """Bodies with their poses, and room for more.

    Args:
        told: the bodies, and the states in which they are, such as open: which of their parts are there.
        names: what things are called.
        seed: of all that is drawn.

    Attributes:
        poses: where things are that have been put.
        furniture: those of them that do not move.
    """

    def __init__(self, told: Told, names: Sequence[str], seed: str) -> None:
        self.bodies, self.states, self.names = told.bodies, told.states, names
        self.poses: dict[int, Pose] = {}
        self.furniture: frozenset[int] = frozenset()
        self._random = random.Random(seed)  # noqa: S311 - a place, not a secret
        self._low, self._high = np.zeros((0, 3)), np.zeros((0, 3))
        self._owner = np.zeros(0, dtype=int)

    def put(self, thing: int, pose: Pose) -> None:
        """Put a thing into a pose; it stays there."""
        self.poses[thing] = pose
        solid = [
            part for part in self.bodies[thing].parts if part.is_solid and self.is_there(thing, part.when)
        ]
        boxes = np.array([pose.box(part.box, part.turn) for part in solid]).reshape(-1, 2, 3)
        self._low = np.concatenate([self._low, boxes[:, 0]])
        self._high = np.concatenate([self._high, boxes[:, 1]])
        self._owner = np.concatenate([self._owner, np.full(len(boxes), thing)])

    def is_there(self, thing: int, when: str) -> bool:
        """Whether a part is there that is so in some state only."""
        return not when or when in self.states[thing]

    def on(self, thing: int, support: int, near: int | None = None) -> Pose:
        """A free place on a thing, next to another thing if one is given.

        Raises:
            InputError: there is none.
        """
        body = self.bodies[support]
        x, y, z = (size / 2 for size in body.size)
        tops = body.tops or (np.array([[-x, -y, z], [x, y, z]]),)
        areas = [self._roomy(thing, _raised(self.poses[support].box(top), 3.0)) for top in tops]
        if near is not None:
            areas = [_common(strip, area) for area in areas for strip in self._strips(thing, near)]
        return self._place(thing, areas, FLAT, f"on {self.names[support]}")

    def _roomy(self, thing: int, area: Box) -> Box:
        """An area, widened where a thing is a little larger than it and juts out."""
        size, sides = np.sort(self.bodies[thing].size[:2]), np.ptp(area, 0)[:2]
        lacking = size[np.argsort(np.argsort(sides))] + 2.5 * _GAP - sides
        juts = np.append(np.where((lacking > 0) & (lacking < 0.4 * sides), lacking / 2, 0.0), 0.0)
        wider: Box = area + juts * np.array([[-1.0], [1.0]])
        return wider

    def inside(self, thing: int, container: int) -> Pose:
        """A free place in a thing, where need be on top of what lies there.

        Raises:
            InputError: there is none.
        """
        body, pose = self.bodies[container], self.poses[container]
        areas = [pose.box(space) for space in body.spaces]
        closed = "closed" in self.states[container] or not body.slack
        slack = 1 if closed else 1 + body.slack
        raised = [_raised(area, (area[1, 2] - area[0, 2]) * slack) for area in areas]
        where = f"in {self.names[container]}"
        try:
            return self._place(thing, raised, (*FLAT, *UPRIGHT), where)
        except InputError:
            return self._place(thing, raised, (*FLAT, *UPRIGHT), where, container)

    def below(self, thing: int, roof: int, room: Box) -> Pose:
        """A free place under a thing, in a room.

        Raises:
            InputError: there is none.
        """
        areas = [_common(self.poses[roof].box(space), room) for space in self.bodies[roof].below]
        return self._place(thing, areas, FLAT, f"under {self.names[roof]}")

    def beside(self, thing: int, other: int, room: Box) -> Pose:
        """A free place on the floor next to a thing.

        Raises:
            InputError: there is none.
        """
        within = [_common(strip, room) for strip in self._strips(thing, other)]
        return self._place(thing, within, FLAT, f"next to {self.names[other]}")

    def _strips(self, thing: int, other: int) -> list[Box]:
        """The strips along the four sides of a thing in which another one is next to it."""
        (x0, y0, _), (x1, y1, _) = self.around(other)
        narrow, wide = sorted(self.bodies[thing].size[:2])
        reach, more = narrow + 0.03, 0.4 * wide
        sides = [(x1, y0 - more, x1 + reach, y1 + more), (x0 - reach, y0 - more, x0, y1 + more)]
        sides += [(x0 - more, y0 - reach, x1 + more, y0), (x0 - more, y1, x1 + more, y1 + reach)]
        return [np.array([[left, front, 0], [right, back, 3]]) for left, front, right, back in sides]

    def on_floor(self, thing: int, room: Box) -> Pose:
        """A free place on the floor of a room.

        Raises:
            InputError: there is none.
        """
        middle = room + np.array([[0.2, 0.7, 0.0], [-0.2, -0.3, 0.0]])
        return self._place(thing, [middle, room], FLAT, "on the floor")

    def around(self, thing: int) -> Box:
        """The box around the solid parts of a thing that is there."""
        own = self._owner == thing
        return np.array([self._low[own].min(0), self._high[own].max(0)])

    def _place(
        self, thing: int, areas: Sequence[Box], turns: Sequence[_Turn], where: str, within: int | None = None
    ) -> Pose:
        """A free pose in one of some areas; with a container, on top of what is in it."""
        size = np.array(self.bodies[thing].size) / 2
        others = self._owner != thing
        spots = [_spot(area, self._low[others], self._high[others]) for area in areas]
        found = self._drawn(size, spots, turns, within) or _packed(size, spots, turns)
        if found is None:
            raise InputError(f"{self.names[thing]} finds no place {where}")
        return found

    def _drawn(
        self, size: Array, spots: Sequence[_Spot], turns: Sequence[_Turn], within: int | None
    ) -> Pose | None:
        """The first of some poses drawn at random that is free."""
        draw = self._random
        for number in range(_TRIES):
            which = 0 if number < _TRIES // 3 else draw.randrange(len(spots)) if spots else 0
            turn = draw.choice(turns[:4] if number < _TRIES // 2 else turns)
            if not spots:
                return None
            half, (area, low, high) = np.abs(Pose((0, 0, 0), turn).axes) @ size, spots[which]
            spare = (area[1] - area[0])[:2] / 2 - half[:2] - _GAP
            if (spare < 0).any():
                continue
            x, y = area.mean(0)[:2] + spare * [draw.uniform(-1, 1), draw.uniform(-1, 1)]
            base = area[0, 2]
            if within is not None:
                below = _crossing(low, high, (x, y), half)
                inner = below & (high[:, 2] < area[1, 2])
                base = max([base, *high[inner, 2]])
            pose = Pose((x, y, base + half[2] + _GAP), turn)
            if pose.at[2] + half[2] <= area[1, 2] and _is_free(pose.at, half, low, high):
                return pose
        return None


def _packed(size: Array, spots: Sequence[_Spot], turns: Sequence[_Turn]) -> Pose | None:
    """A free pose against the sides of an area or of what is in it."""
    for (area, low, high), turn in product(spots, turns):
        half = np.abs(Pose((0, 0, 0), turn).axes) @ size
        z = area[0, 2] + half[2] + _GAP
        if z + half[2] > area[1, 2]:
            continue
        for x, y in product(_stops(area, low, high, half, 0), _stops(area, low, high, half, 1)):
            if _is_free((x, y, z), half, low, high):
                return Pose((x, y, z), turn)
    return None


def _stops(area: Box, low: Array, high: Array, half: Array, axis: int) -> Iterator[float]:
    """Where along an axis a thing touches a side of the area or of another thing."""
    first, last = area[0, axis] + half[axis] + _GAP, area[1, axis] - half[axis] - _GAP
    edges = [first, last, *(high[:, axis] + half[axis] + _GAP), *(low[:, axis] - half[axis] - _GAP)]
    return (edge for edge in sorted(edges) if first <= edge <= last)


def _is_free(at: Sequence[float], half: Array, low: Array, high: Array) -> bool:
    """Whether a box overlaps none of others."""
    middle = np.array(at)
    overlaps = (low < middle + half + 0.001) & (high > middle - half - 0.001)
    return not overlaps.all(1).any()


def _crossing(low: Array, high: Array, at: tuple[float, float], half: Array) -> Any:
    """Which boxes are above or below a rectangle."""
    middle = np.array(at)
    return ((low[:, :2] < middle + half[:2]) & (high[:, :2] > middle - half[:2])).all(1)


def _spot(area: Box, low: Array, high: Array) -> _Spot:
    """An area, with those of some boxes that reach into it, or near it."""
    near = ((low < area[1] + 0.01) & (high > area[0] - 0.01)).all(1)
    return area, low[near], high[near]


def _common(first: Box, second: Box) -> Box:
    """The box that two boxes have in common."""
    return np.array([np.maximum(first[0], second[0]), np.minimum(first[1], second[1])])


def _raised(area: Box, height: float) -> Box:
    """An area with so much height."""
    raised: Box = area.copy()
    raised[1, 2] = raised[0, 2] + height
    return raised
