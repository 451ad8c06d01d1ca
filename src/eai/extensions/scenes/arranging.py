"""Arrange the objects of a state in rooms, one room for each object that is a floor.

Furniture stands side by side along the walls or in rows. Rooms are as large as their furniture needs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from eai.base.errors import InputError
from eai.extensions.scenes.body import Box, ObjectBodyShape
from eai.extensions.scenes.locations import BESIDE, INSIDE, UNDER, ObjectLocations
from eai.extensions.scenes.placing import ObjectPlacer, Pose, make_rotation_by_quarter_turns

WALL_HEIGHT = 2.6
"""Height of walls in metres."""

_FURNITURE_GAP = 0.3
"""Gap in metres between pieces of furniture along a wall. It leaves space for doors to swing."""

_ROOM_DISTANCE = 0.35
"""Distance between the walls of neighbouring rooms in metres."""

_WALL_CABINET_HEIGHT, _WINDOW_HEIGHT = 1.42, 0.9
"""Heights in metres of the lower edges of wall cabinets and windows."""


def arrange_objects(
    locations: ObjectLocations, names: Sequence[str], seed: str
) -> tuple[ObjectPlacer, Mapping[int, Box]]:
    """Return poses of objects, in the `ObjectPlacer`, and a mapping from each floor to its room's box.

    The seed determines all random draws.

    Raises:
        InputError: the state has no floor, or an object does not fit into its place in the state.
    """
    if not locations.floors:
        raise InputError(
            "cannot build a room: the state has no object that is a floor; use a task with a floor"
        )
    joined = _map_first_object_spanning_rooms_to_floors(locations)
    floors = dict.fromkeys((*(floor for pair in joined.values() for floor in pair), *locations.floors))
    boxes, furniture = _place_rooms_and_furniture(
        locations.bodies, {floor: _list_furniture(locations, floor) for floor in floors}, joined
    )
    placer = ObjectPlacer(locations, names, seed)
    for object_index, pose in furniture.items():
        placer.put(object_index, pose)
    placer.furniture = frozenset(furniture)
    place_remaining_objects(placer, locations, boxes)
    return placer, boxes


def place_remaining_objects(
    placer: ObjectPlacer, locations: ObjectLocations, boxes: Mapping[int, Box], *, crowded: bool = False
) -> None:
    """Place the objects that have no pose yet: supports before their contents, large objects before small.

    Args:
        placer: the bodies of objects; some have a pose.
        locations: the locations of objects in a state.
        boxes: the box of each room.
        crowded: whether an object that does not fit may overlap other objects. If not,
            InputError is raised.

    Raises:
        InputError: an object does not fit where the state puts it.
    """
    waiting = [i for i in locations.bodies if i not in placer.poses and not locations.is_held(i)]
    for object_index in sorted(
        waiting, key=lambda i: (locations.count_carriers(i), -_compute_volume(locations, i), i)
    ):
        try:
            pose = _find_pose(placer, locations, boxes, object_index)
        except InputError:
            if not crowded:
                raise
            pose = _compute_pose_that_may_overlap(placer, locations, boxes, object_index)
        placer.put(object_index, pose)


def _map_first_object_spanning_rooms_to_floors(locations: ObjectLocations) -> dict[int, tuple[int, int]]:
    """Return the first object under which an object of another room stands, with the floors of both rooms.

    The result maps the upper object to two floors: that of its own room, then that of the lower object's
    room. The result is empty if there is no such object.
    """
    rooms = [
        (roof, (locations.find_room(roof), locations.find_room(object_index)))
        for object_index, roof in locations.relations[UNDER]
    ]
    return dict([(roof, floors) for roof, floors in rooms if floors[0] != floors[1]][:1])


def _list_furniture(locations: ObjectLocations, floor: int) -> list[int]:
    held = set(locations.hands.values())
    return [
        i
        for i, body in locations.bodies.items()
        if body.stand != "free"
        and locations.find_relation_and_carrier(i) is None
        and i not in held
        and locations.find_room(i) == floor
        and not (body.stand == "middle" and _is_next_to_furniture(locations, i))
    ]


def _is_next_to_furniture(locations: ObjectLocations, object_index: int) -> bool:
    """Whether an object stands next to furniture that gets its place earlier than this object."""
    others = [
        second
        for first, second in locations.relations[BESIDE]
        if first == object_index and second in locations.bodies
    ]
    stands = {other: locations.bodies[other].stand for other in others}
    return any(
        stand not in ("free", "middle") or (stand == "middle" and i < object_index)
        for i, stand in stands.items()
    )


def _find_pose(
    placer: ObjectPlacer, locations: ObjectLocations, boxes: Mapping[int, Box], object_index: int
) -> Pose:
    carrier = locations.find_relation_and_carrier(object_index)
    beside = [b for a, b in locations.relations[BESIDE] if a == object_index and b in placer.poses]
    if carrier is not None:
        relation, other = carrier
        near = next(
            (neighbour for neighbour in beside if locations.find_relation_and_carrier(neighbour) == carrier),
            None,
        )
        if relation == INSIDE:
            return placer.find_pose_inside(object_index, other)
        return placer.find_pose_on(object_index, other, near)
    room = boxes[locations.find_room(object_index)]
    roofs = [b for a, b in locations.relations[UNDER] if a == object_index and b in placer.poses]
    if roofs:
        return placer.find_pose_below(object_index, roofs[0], room)
    if beside:
        return placer.find_pose_beside(object_index, beside[0], room)
    return placer.find_pose_on_floor(object_index, room)


def _compute_pose_that_may_overlap(
    placer: ObjectPlacer, locations: ObjectLocations, boxes: Mapping[int, Box], object_index: int
) -> Pose:
    """Return a pose in the middle of an object's support, container or room. Objects may overlap there."""
    carrier = locations.find_relation_and_carrier(object_index)
    height = locations.bodies[object_index].size[2]
    if carrier is None:
        x, y, _ = boxes[locations.find_room(object_index)].mean(0)
        return Pose((x, y, height / 2))
    relation, other = carrier
    body = placer.bodies[other]
    areas = (body.spaces if relation == INSIDE else body.tops) or (np.zeros((2, 3)),)
    area = placer.poses[other].to_scene_box(areas[0])
    x, y, _ = area.mean(0)
    return Pose((x, y, area[0, 2] + height / 2))


def _compute_volume(locations: ObjectLocations, object_index: int) -> float:
    width, depth, height = locations.bodies[object_index].size
    return width * depth * height


@dataclass(slots=True)
class _RoomLayout:
    """A room to which furniture is added. Its left front corner is the origin; y grows to the back."""

    bodies: Mapping[int, ObjectBodyShape]
    width: float
    depth: float
    poses: dict[int, tuple[float, float, float, int]] = field(default_factory=dict)

    def put_object(
        self, object_index: int, x: float, y: float, quarter_turns: int, above: float = 0.0
    ) -> None:
        """Put an object over a point of the floor; ``above`` is the height of its underside in metres."""
        self.poses[object_index] = (x, y, above + self.bodies[object_index].size[2] / 2, quarter_turns)


def _place_rooms_and_furniture(
    bodies: Mapping[int, ObjectBodyShape],
    furniture_by_floor: Mapping[int, Sequence[int]],
    floors_by_object_spanning_two_rooms: Mapping[int, tuple[int, int]],
) -> tuple[dict[int, Box], dict[int, Pose]]:
    """Arrange rooms in a row from left to right. Return the box of each room, and the pose of its furniture.

    Args:
        bodies: the body of each object.
        furniture_by_floor: the furniture of each room. The key is the object that is the room's floor.
        floors_by_object_spanning_two_rooms: the floors of both rooms, for each object that stands in two
            rooms. No wall separates these two rooms, which must follow each other in ``furniture_by_floor``.
    """
    boxes: dict[int, Box] = {}
    poses: dict[int, Pose] = {}
    left = 0.0
    for floor, object_indices in furniture_by_floor.items():
        plan = _furnish_room({object_index: bodies[object_index] for object_index in object_indices})
        boxes[floor] = np.array([[left, 0.0, 0.0], [left + plan.width, plan.depth, WALL_HEIGHT]])
        for object_index, (x, y, z, quarter_turns) in plan.poses.items():
            poses[object_index] = Pose((left + x, y, z), make_rotation_by_quarter_turns(quarter_turns))
        left += plan.width + (
            0.0
            if floor in [first for first, _ in floors_by_object_spanning_two_rooms.values()]
            else _ROOM_DISTANCE
        )
    for object_index, (floor, _) in floors_by_object_spanning_two_rooms.items():
        poses[object_index] = Pose((float(boxes[floor][1, 0]) - 0.02, 1.2, bodies[object_index].size[2] / 2))
    return boxes, poses


def _furnish_room(bodies: Mapping[int, ObjectBodyShape]) -> _RoomLayout:
    standing = {stand: [i for i, body in bodies.items() if body.stand == stand] for stand in _STANDS}
    wall = sorted(standing["wall"], key=lambda i: (-bodies[i].size[2], i))
    tall = sum([bodies[i].size[0] + _FURNITURE_GAP for i in wall if bodies[i].size[2] > _WALL_CABINET_HEIGHT])
    hung = sum([bodies[i].size[0] + _FURNITURE_GAP for i in standing["high"]])
    along = sum([bodies[i].size[0] + _FURNITURE_GAP for i in wall])
    rows = _split_into_rows(
        bodies, standing["middle"], max(4.0, min(along + 0.4, 6.5), tall + hung + 0.4) - 0.8
    )
    widest = max([sum([bodies[i].size[0] + 0.7 for i in row]) for row in rows], default=0.0)
    width = max(4.0, min(along + 0.4, 6.5), tall + hung + 0.4, widest + 0.4)
    back = max([bodies[i].size[1] for i in wall], default=0.4)
    besides = max(
        sum([bodies[i].size[0] + _FURNITURE_GAP for i in standing[stand]]) for stand in ("door", "window")
    )
    sides = max(0.0, along + 0.4 - width) / 2 + besides
    deep = [max([bodies[i].size[1] for i in row]) + 0.6 for row in rows]
    depth = max(3.6, back + sum(deep) + 2.0, back + sides + 1.6)
    plan = _RoomLayout(bodies, width, depth)
    _put_furniture_along_walls(plan, wall, standing)
    y = depth - back - 0.6
    for row in rows:
        _put_objects_in_row(plan, row, y)
        y -= max([bodies[i].size[1] for i in row]) + 0.6
    return plan


_STANDS = ("wall", "high", "door", "window", "middle", "free")


def _split_into_rows(
    bodies: Mapping[int, ObjectBodyShape], object_indices: Sequence[int], width: float
) -> list[list[int]]:
    """Split objects into rows of at most the given width. An object that is wider gets its own row."""
    rows: list[list[int]] = []
    left = 0.0
    for object_index in object_indices:
        need = bodies[object_index].size[0] + 0.7
        if not rows or need > left:
            rows.append([])
            left = width
        rows[-1].append(object_index)
        left -= need
    return rows


def _put_objects_in_row(plan: _RoomLayout, row: Sequence[int], y: float) -> None:
    """Put objects side by side in a row that is centred in the room."""
    sizes = [plan.bodies[object_index].size for object_index in row]
    x = plan.width / 2 - (sum([size[0] for size in sizes]) + 0.7 * (len(row) - 1)) / 2
    for object_index, (width, depth, _) in zip(row, sizes, strict=True):
        plan.put_object(object_index, x + width / 2, y - depth / 2, 0)
        x += width + 0.7


def _put_furniture_along_walls(
    plan: _RoomLayout,
    back_wall_furniture: Sequence[int],
    furniture_by_location_in_room: Mapping[str, Sequence[int]],
) -> None:
    """Put furniture along the back wall, then the side walls; doors to the left, windows to the right."""
    bodies, x = plan.bodies, 0.2
    back = max([bodies[i].size[1] for i in back_wall_furniture], default=0.4)
    side = {3: plan.depth - back - 0.5, 1: plan.depth - back - 0.5}
    for object_index in back_wall_furniture:
        width, depth, _ = bodies[object_index].size
        if x + width <= plan.width - 0.15:
            plan.put_object(object_index, x + width / 2, plan.depth - depth / 2 - 0.01, 0)
            x += width + _FURNITURE_GAP
            continue
        quarter_turns = 1 if side[1] >= side[3] else 3
        _put_at_side_wall(plan, object_index, quarter_turns, side)
    x = plan.width - 0.2
    for object_index in furniture_by_location_in_room["high"]:
        width, depth, _ = bodies[object_index].size
        plan.put_object(object_index, x - width / 2, plan.depth - depth / 2 - 0.01, 0, _WALL_CABINET_HEIGHT)
        x -= width + _FURNITURE_GAP
    for object_index in furniture_by_location_in_room["door"]:
        _put_at_side_wall(plan, object_index, 1, side)
    for object_index in furniture_by_location_in_room["window"]:
        _put_at_side_wall(plan, object_index, 3, side, _WINDOW_HEIGHT)


def _put_at_side_wall(
    plan: _RoomLayout,
    object_index: int,
    quarter_turns: int,
    free_depth_by_turns: dict[int, float],
    height: float = 0.0,
) -> None:
    """Put an object with its back to the left wall (1 quarter turn) or the right wall (3 quarter turns)."""
    width, depth, _ = plan.bodies[object_index].size
    x = depth / 2 + 0.01 if quarter_turns == 1 else plan.width - depth / 2 - 0.01
    plan.put_object(object_index, x, free_depth_by_turns[quarter_turns] - width / 2, quarter_turns, height)
    free_depth_by_turns[quarter_turns] -= width + _FURNITURE_GAP
