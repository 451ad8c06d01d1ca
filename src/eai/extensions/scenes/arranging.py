"""Arranging: a room for each floor, and in it everything where a state says that it is.

Furniture stands side by side along the walls or in rows; rooms are as large as that makes them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from eai.base.errors import InputError
from eai.extensions.scenes.body import Body, Box
from eai.extensions.scenes.placing import Placing, Pose, turned
from eai.extensions.scenes.told import BESIDE, INSIDE, UNDER, Told

HEIGHT = 2.6
"""The height of walls, in metres."""

_GAP = 0.3
"""The air between pieces of furniture along a wall, where doors may swing."""

_BETWEEN = 0.35
"""The distance between the walls of neighbouring rooms."""

_HIGH, _SILL = 1.42, 0.9
"""How high wall cabinets hang, and windows begin."""


def arranged(told: Told, names: Sequence[str], seed: str) -> tuple[Placing, Mapping[int, Box]]:
    """Poses for all things of a state, and the boxes of rooms, drawn from a seed.

    Raises:
        InputError: a thing finds no place where the state says that it is.
    """
    if not told.floors:
        raise InputError("no room: the state has no floor")
    joined = _joined(told)
    floors = dict.fromkeys((*(floor for pair in joined.values() for floor in pair), *told.floors))
    boxes, furniture = _furnished(told.bodies, {floor: _furniture(told, floor) for floor in floors}, joined)
    placing = Placing(told, names, seed)
    for thing, pose in furniture.items():
        placing.put(thing, pose)
    placing.furniture = frozenset(furniture)
    place_rest(placing, told, boxes)
    return placing, boxes


def place_rest(placing: Placing, told: Told, boxes: Mapping[int, Box], *, crowded: bool = False) -> None:
    """Place what has no pose yet: what carries others first, large before small.

    Args:
        placing: the bodies, of which some have a pose.
        told: where they are.
        boxes: the boxes of rooms.
        crowded: whether what finds no place shares one with others.

    Raises:
        InputError: a thing finds no place where the state says that it is.
    """
    waiting = [i for i in told.bodies if i not in placing.poses and not told.is_held(i)]
    for thing in sorted(waiting, key=lambda i: (told.depth(i), -_volume(told, i), i)):
        try:
            pose = _pose(placing, told, boxes, thing)
        except InputError:
            if not crowded:
                raise
            pose = _amid(placing, told, boxes, thing)
        placing.put(thing, pose)


def _joined(told: Told) -> dict[int, tuple[int, int]]:
    """The thing under which one lies that is in another room, and both floors: its own first."""
    rooms = [(roof, (told.room_of(roof), told.room_of(thing))) for thing, roof in told.relations[UNDER]]
    return dict([(roof, floors) for roof, floors in rooms if floors[0] != floors[1]][:1])


def _furniture(told: Told, floor: int) -> list[int]:
    """The things that stand in a room by themselves and stay where they are."""
    held = set(told.hands.values())
    return [
        i
        for i, body in told.bodies.items()
        if body.stand != "free"
        and told.carrier(i) is None
        and i not in held
        and told.room_of(i) == floor
        and not (body.stand == "middle" and _is_beside(told, i))
    ]


def _is_beside(told: Told, thing: int) -> bool:
    """Whether a thing stands next to furniture that is placed before it."""
    others = [second for first, second in told.relations[BESIDE] if first == thing and second in told.bodies]
    stands = {other: told.bodies[other].stand for other in others}
    return any(
        stand not in ("free", "middle") or (stand == "middle" and i < thing) for i, stand in stands.items()
    )


def _pose(placing: Placing, told: Told, boxes: Mapping[int, Box], thing: int) -> Pose:
    """A free pose for a thing that accords with what is told of it."""
    carrier = told.carrier(thing)
    beside = [b for a, b in told.relations[BESIDE] if a == thing and b in placing.poses]
    if carrier is not None:
        relation, other = carrier
        near = next((each for each in beside if told.carrier(each) == carrier), None)
        return placing.inside(thing, other) if relation == INSIDE else placing.on(thing, other, near)
    room = boxes[told.room_of(thing)]
    roofs = [b for a, b in told.relations[UNDER] if a == thing and b in placing.poses]
    if roofs:
        return placing.below(thing, roofs[0], room)
    return placing.beside(thing, beside[0], room) if beside else placing.on_floor(thing, room)


def _amid(placing: Placing, told: Told, boxes: Mapping[int, Box], thing: int) -> Pose:
    """The pose of a thing in the middle of where it should be."""
    carrier, height = told.carrier(thing), told.bodies[thing].size[2]
    if carrier is None:
        x, y, _ = boxes[told.room_of(thing)].mean(0)
        return Pose((x, y, height / 2))
    relation, other = carrier
    body = placing.bodies[other]
    areas = (body.spaces if relation == INSIDE else body.tops) or (np.zeros((2, 3)),)
    area = placing.poses[other].box(areas[0])
    x, y, _ = area.mean(0)
    return Pose((x, y, area[0, 2] + height / 2))


def _volume(told: Told, thing: int) -> float:
    width, depth, height = told.bodies[thing].size
    return width * depth * height


@dataclass(slots=True)
class _Plan:
    """A room that is being furnished: its left front corner is at the origin, y to the back."""

    bodies: Mapping[int, Body]
    width: float
    depth: float
    poses: dict[int, tuple[float, float, float, int]] = field(default_factory=dict)

    def put(self, thing: int, x: float, y: float, quarters: int, above: float = 0.0) -> None:
        """Put a thing, whose middle is above a place on the floor."""
        self.poses[thing] = (x, y, above + self.bodies[thing].size[2] / 2, quarters)


def _furnished(
    bodies: Mapping[int, Body], rooms: Mapping[int, Sequence[int]], joined: Mapping[int, tuple[int, int]]
) -> tuple[dict[int, Box], dict[int, Pose]]:
    """The boxes of rooms that stand side by side, and the poses of their furniture.

    Args:
        bodies: the body of each thing.
        rooms: the furniture of each room, by its floor.
        joined: the things that stand between two rooms without a wall, with both floors, which follow each
            other in ``rooms``.
    """
    boxes: dict[int, Box] = {}
    poses: dict[int, Pose] = {}
    left = 0.0
    for floor, things in rooms.items():
        plan = _plan({thing: bodies[thing] for thing in things})
        boxes[floor] = np.array([[left, 0.0, 0.0], [left + plan.width, plan.depth, HEIGHT]])
        for thing, (x, y, z, quarters) in plan.poses.items():
            poses[thing] = Pose((left + x, y, z), turned(quarters))
        left += plan.width + (0.0 if floor in [first for first, _ in joined.values()] else _BETWEEN)
    for thing, (floor, _) in joined.items():
        poses[thing] = Pose((float(boxes[floor][1, 0]) - 0.02, 1.2, bodies[thing].size[2] / 2))
    return boxes, poses


def _plan(bodies: Mapping[int, Body]) -> _Plan:
    """One furnished room."""
    standing = {stand: [i for i, body in bodies.items() if body.stand == stand] for stand in _ORDER}
    wall = sorted(standing["wall"], key=lambda i: (-bodies[i].size[2], i))
    tall = sum([bodies[i].size[0] + _GAP for i in wall if bodies[i].size[2] > _HIGH])
    hung = sum([bodies[i].size[0] + _GAP for i in standing["high"]])
    along = sum([bodies[i].size[0] + _GAP for i in wall])
    rows = _rows(bodies, standing["middle"], max(4.0, min(along + 0.4, 6.5), tall + hung + 0.4) - 0.8)
    widest = max([sum([bodies[i].size[0] + 0.7 for i in row]) for row in rows], default=0.0)
    width = max(4.0, min(along + 0.4, 6.5), tall + hung + 0.4, widest + 0.4)
    back = max([bodies[i].size[1] for i in wall], default=0.4)
    besides = max(sum([bodies[i].size[0] + _GAP for i in standing[stand]]) for stand in ("door", "window"))
    sides = max(0.0, along + 0.4 - width) / 2 + besides
    deep = [max([bodies[i].size[1] for i in row]) + 0.6 for row in rows]
    depth = max(3.6, back + sum(deep) + 2.0, back + sides + 1.6)
    plan = _Plan(bodies, width, depth)
    _line_walls(plan, wall, standing)
    y = depth - back - 0.6
    for row in rows:
        _put_row(plan, row, y)
        y -= max([bodies[i].size[1] for i in row]) + 0.6
    return plan


_ORDER = ("wall", "high", "door", "window", "middle", "free")


def _rows(bodies: Mapping[int, Body], things: Sequence[int], width: float) -> list[list[int]]:
    """Things in rows that are no wider than a width, unless one alone is."""
    rows: list[list[int]] = []
    left = 0.0
    for thing in things:
        need = bodies[thing].size[0] + 0.7
        if not rows or need > left:
            rows.append([])
            left = width
        rows[-1].append(thing)
        left -= need
    return rows


def _put_row(plan: _Plan, row: Sequence[int], y: float) -> None:
    """Put things side by side, about the middle of the room."""
    sizes = [plan.bodies[thing].size for thing in row]
    x = plan.width / 2 - (sum([size[0] for size in sizes]) + 0.7 * (len(row) - 1)) / 2
    for thing, (width, depth, _) in zip(row, sizes, strict=True):
        plan.put(thing, x + width / 2, y - depth / 2, 0)
        x += width + 0.7


def _line_walls(plan: _Plan, wall: Sequence[int], standing: Mapping[str, Sequence[int]]) -> None:
    """Put furniture along the back wall and on along both others; doors are left, windows right."""
    bodies, x = plan.bodies, 0.2
    back = max([bodies[i].size[1] for i in wall], default=0.4)
    side = {3: plan.depth - back - 0.5, 1: plan.depth - back - 0.5}
    for thing in wall:
        width, depth, _ = bodies[thing].size
        if x + width <= plan.width - 0.15:
            plan.put(thing, x + width / 2, plan.depth - depth / 2 - 0.01, 0)
            x += width + _GAP
            continue
        quarters = 1 if side[1] >= side[3] else 3
        _put_aside(plan, thing, quarters, side)
    x = plan.width - 0.2
    for thing in standing["high"]:
        width, depth, _ = bodies[thing].size
        plan.put(thing, x - width / 2, plan.depth - depth / 2 - 0.01, 0, _HIGH)
        x -= width + _GAP
    for thing in standing["door"]:
        _put_aside(plan, thing, 1, side)
    for thing in standing["window"]:
        _put_aside(plan, thing, 3, side, _SILL)


def _put_aside(plan: _Plan, thing: int, quarters: int, side: dict[int, float], above: float = 0.0) -> None:
    """Put a thing with its back to the left wall (one quarter turn) or to the right one (three)."""
    width, depth, _ = plan.bodies[thing].size
    x = depth / 2 + 0.01 if quarters == 1 else plan.width - depth / 2 - 0.01
    plan.put(thing, x, side[quarters] - width / 2, quarters, above)
    side[quarters] -= width + _GAP
