"""Arranging: a room for each floor, and in it everything where a state says that it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from eai.bodies.body import Box
from eai.bodies.placing import Placing, Pose
from eai.bodies.rooms import furnished
from eai.bodies.told import BESIDE, INSIDE, UNDER, Told
from eai.errors import InputError


def arranged(told: Told, names: Sequence[str], seed: str) -> tuple[Placing, Mapping[int, Box]]:
    """Poses for all things of a state, and the boxes of rooms, drawn from a seed.

    Raises:
        InputError: a thing finds no place where the state says that it is.
    """
    if not told.floors:
        raise InputError("no room: the state has no floor")
    joined = _joined(told)
    floors = dict.fromkeys((*(floor for pair in joined.values() for floor in pair), *told.floors))
    boxes, furniture = furnished(told.bodies, {floor: _furniture(told, floor) for floor in floors}, joined)
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
