"""Build the scene of a task in MuJoCo: arrange the bodies, let them settle, check all relations.

The sizes of objects are invented for this package (`kinds.txt`), so no verdict depends on a scene. Only this
module and `camera` load MuJoCo, which reads bodies, rooms and lamps as XML text.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from ctypes.util import find_library
from importlib.resources import files
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as Xml

import numpy as np

from eai.base.errors import InputError
from eai.extensions.scenes import geometry
from eai.extensions.scenes.arranging import WALL_HEIGHT, arrange_objects, place_remaining_objects
from eai.extensions.scenes.body import Array, Box, ObjectBodyPart, ObjectBodyShape, Vector
from eai.extensions.scenes.locations import BESIDE, INSIDE, ON, UNDER, ObjectLocations, read_object_locations
from eai.extensions.scenes.looks import make_parts_that_show_states, tint_colour_by_states
from eai.extensions.scenes.placing import ObjectPlacer, Pose
from eai.tasks.task import Task
from eai.world.state import State

if TYPE_CHECKING:
    import mujoco

_TYPES = {"box": "box", "ball": "ellipsoid", "post": "cylinder", "pipe": "cylinder", "bar": "cylinder"}
_TURNS = {"pipe": (0.70710678, 0.70710678, 0.0, 0.0), "bar": (0.70710678, 0.0, 0.70710678, 0.0)}
_AXES = {"post": 2, "pipe": 1, "bar": 0}
_FIXED, _LOOSE = ("1", "2"), ("2", "3")
"""MuJoCo's masks for contacts: furniture collides only with loose objects, loose objects with everything."""

_FLOORS = {
    "tiles": ("kitchen", "bath", "utility"),
    "concrete": ("garage", "garden", "storage", "driveway", "lawn"),
}
_WALLS = {
    "kitchen": "0.95 0.92 0.84",
    "bath": "0.80 0.89 0.93",
    "bed": "0.88 0.86 0.94",
    "dining": "0.94 0.87 0.78",
    "garage": "0.84 0.84 0.83",
    "living": "0.92 0.91 0.82",
}


def write_mujoco_model(
    placer: ObjectPlacer,
    locations: ObjectLocations,
    rooms: Mapping[int, Box],
    position_of_unplaced_objects: Vector,
) -> str:
    """Return the MuJoCo model of arranged bodies as XML.

    Args:
        placer: the bodies with their poses.
        locations: the locations of the objects in a state. They determine the room with most objects, whose
            lamp alone casts shadows, because shadows take most of the rendering time.
        rooms: the box of each room.
        position_of_unplaced_objects: location of objects without a pose, and of objects that may appear
            later.
    """
    text = (files("eai.extensions.scenes") / "world.xml").read_text(encoding="utf-8")
    root = Xml.fromstring(text)  # noqa: S314 - our own text
    world = root.find("worldbody")
    if world is None:
        raise ValueError(
            "world.xml, a file of this package, has no element worldbody: install the package again"
        )
    for floor, box in rooms.items():
        edges = {round(float(other[i, 0]), 3) for i in (0, 1) for other in rooms.values() if other is not box}
        walls = [round(float(x), 3) not in edges for x in box[:, 0]]
        world.extend(_make_room(box, placer.names[floor], walls))
        world.append(_make_lamp(box, shadows=floor == locations.fullest_room))
    for object_index, body in {**placer.bodies, **locations.absent}.items():
        pose = placer.poses.get(object_index, Pose(position_of_unplaced_objects))
        is_fixed = object_index in placer.furniture
        states = placer.states.get(object_index, frozenset())
        world.append(
            _make_body_element(
                object_index, body, pose, states, is_fixed=is_fixed, is_there=object_index in placer.poses
            )
        )
    return Xml.tostring(root, encoding="unicode")


def _make_body_element(
    object_index: int,
    body: ObjectBodyShape,
    pose: Pose,
    states: frozenset[str],
    *,
    is_fixed: bool,
    is_there: bool,
) -> Xml.Element:
    """Return the XML element of an object. Furniture and absent objects cannot move."""
    element = Xml.Element(
        "body", name=f"b{object_index}", pos=_format_numbers(pose.at), quat=_format_numbers(pose.turn)
    )
    if not is_fixed and is_there:
        Xml.SubElement(element, "freejoint")
    for part in (*body.parts, *make_parts_that_show_states(body)):
        seen = not part.when or part.when in states
        meets = (_FIXED if is_fixed else _LOOSE) if part.is_solid and seen and is_there else ("0", "0")
        element.append(_make_geom(part, meets, (*tint_colour_by_states(part.colour, states), float(seen))))
    return element


def _make_geom(
    part: ObjectBodyPart, collision_masks: tuple[str, str], rgba: tuple[float, ...]
) -> Xml.Element:
    geom = Xml.Element(
        "geom",
        type=_TYPES[part.form],
        pos=_format_numbers(part.box.mean(0).tolist()),
        rgba=_format_numbers(rgba),
    )
    geom.set("contype", collision_masks[0])
    geom.set("conaffinity", collision_masks[1])
    half = ((part.box[1] - part.box[0]) / 2).tolist()
    axis = _AXES.get(part.form)
    if axis is not None:
        across = [half[i] for i in range(3) if i != axis]
        half = [sum(across) / 2, half[axis], 0.0]
        geom.set("quat", _format_numbers(_TURNS.get(part.form, (1.0, 0.0, 0.0, 0.0))))
    if part.turn:
        geom.set("euler", f"0 0 {part.turn:.6g}")
        geom.attrib.pop("quat", None)
    if not part.is_solid:
        geom.set("mass", "0")
    geom.set("size", _format_numbers([max(1e-4, length) for length in half]))
    return geom


def _make_room(box: Box, name: str, walls: Sequence[bool]) -> Iterator[Xml.Element]:
    """Yield the floor, the back wall and the side walls of a room.

    ``walls`` has two truth values: whether the left and the right wall exist.
    """
    (x0, y0, _), (x1, y1, _) = box
    look = next((look for look, words in _FLOORS.items() if any(word in name for word in words)), "wood")
    yield _make_slab((x0, x1, y0, y1, -0.1, 0.0), material=look)
    wall = next((colour for word, colour in _WALLS.items() if word in name), "0.9 0.89 0.85")
    sides = [
        side for side, is_there in zip(((x0 - 0.08, x0), (x1, x1 + 0.08)), walls, strict=True) if is_there
    ]
    for side in ((x0, x1, y1, y1 + 0.08), *[(*x, y0, y1 + 0.08) for x in sides]):
        yield _make_slab((*side, 0.0, WALL_HEIGHT), rgba=f"{wall} 1")
    trim = "0.97 0.97 0.95 1"
    yield _make_slab((x0, x1, y1 - 0.012, y1, 0.0, 0.09), rgba=trim, contype="0", conaffinity="0")
    yield _make_slab((x0, x1, y0 - 0.08, y0, 0.0, WALL_HEIGHT), rgba="0 0 0 0")


def _make_lamp(box: Box, *, shadows: bool) -> Xml.Element:
    x, y, _ = box.mean(0)
    lamp = Xml.Element(
        "light",
        pos=_format_numbers([x, y - 0.5, 2.9]),
        dir="0.05 0.15 -1",
        diffuse="0.4 0.4 0.38",
        cutoff="85",
    )
    lamp.set("specular", "0.04 0.04 0.04")
    lamp.set("castshadow", str(shadows).lower())
    return lamp


def _make_slab(bounds: tuple[float, ...], **attributes: str) -> Xml.Element:
    pairs = list(zip(bounds[::2], bounds[1::2], strict=True))
    size, middle = [(high - low) / 2 for low, high in pairs], [(low + high) / 2 for low, high in pairs]
    slab = Xml.Element("geom", type="box", size=_format_numbers(size), pos=_format_numbers(middle))
    slab.attrib |= {"contype": _FIXED[0], "conaffinity": _FIXED[1], **attributes}
    return slab


def _format_numbers(numbers: tuple[float, ...] | list[float]) -> str:
    return " ".join([f"{number:.6g}" for number in numbers])


MAX_ATTEMPTS = 8
"""Maximum number of attempts to arrange a scene. An attempt fails if an object falls or does not fit."""

_MAX_STEPS, _DAMPING_STEPS = 240, 8
"""Maximum number of steps (4 ms each) until a scene rests, and number of steps between dampings of motion."""

_MAX_RESTING_SPEED = 0.03
"""Speed below which a scene counts as at rest: in m/s for motion, in radians/s for rotation."""

_ABSENT_LOCATION = (0.0, 0.0, -30.0)
"""Location below all rooms, for bodies of absent objects, such as halves of an object that is not cut."""


def _load_mujoco() -> Any:
    """Import MuJoCo. On Linux it renders through EGL if EGL is installed and MUJOCO_GL is not set."""
    if sys.platform == "linux" and "MUJOCO_GL" not in os.environ:
        os.environ["MUJOCO_GL"] = "egl" if find_library("EGL") else "disabled"
    import mujoco

    return mujoco


class MujocoScene:
    """The three-dimensional scene of a task. The geometry fulfils all relations of the initial state.

    Args:
        task: the task.

    Attributes:
        task: the task.
        locations: the objects of the state that is shown; at first, the initial state.
        rooms: the box of each room, by the index of the room's floor.
        attempts: number of attempts that arranging the scene took.
        mujoco: the MuJoCo module.
        model: the MuJoCo model.
        data: the MuJoCo data: the poses and contacts of the model.
        mujoco_body_of_object: the MuJoCo body of each object.
        mujoco_geoms_of_object: the MuJoCo geoms (shapes) of each object, one for each part.

    Raises:
        InputError: the scene cannot be arranged. The message says why.
        ImportError: MuJoCo is not installed.
    """

    def __init__(self, task: Task) -> None:
        self.mujoco = _load_mujoco()
        self.task = task
        self._names = [item.name for item in task.scene.objects]
        self.locations = read_object_locations(task.initial)
        self._bodies = {**self.locations.bodies, **self.locations.absent}
        problem: InputError | None = None
        for self.attempts in range(1, MAX_ATTEMPTS + 1):
            try:
                self._arrange_objects_and_simulate_until_rest(f"{task.id} 0 {self.attempts}")
            except InputError as error:
                problem = error
                continue
            return
        raise InputError(
            f"{task.id}: {MAX_ATTEMPTS} attempts to arrange the objects failed; the last one: {problem}"
        ) from problem

    def _arrange_objects_and_simulate_until_rest(self, seed: str) -> None:
        """Arrange all objects, let them settle, and check their relations.

        Raises:
            InputError: an object does not fit, or a relation does not hold.
        """
        placer, self.rooms = arrange_objects(self.locations, self._names, seed)
        self._build_mujoco_model(placer)
        self._simulate_until_rest()
        lost = self.list_relations_not_met_by_geometry()
        if lost:
            first, relation, second = lost[0]
            raise InputError(
                f"{self._names[first]} fell in the physics simulation, and is no longer {relation} "
                f"{self._names[second]}; choose another task"
            )

    def _build_mujoco_model(self, placer: ObjectPlacer) -> None:
        text = write_mujoco_model(placer, self.locations, self.rooms, _ABSENT_LOCATION)
        self.model: mujoco.MjModel = self.mujoco.MjModel.from_xml_string(text)
        self.data: mujoco.MjData = self.mujoco.MjData(self.model)
        find, kind = self.mujoco.mj_name2id, self.mujoco.mjtObj.mjOBJ_BODY
        self.mujoco_body_of_object = {
            object_index: find(self.model, kind, f"b{object_index}") for object_index in self._bodies
        }
        first, many = self.model.body_geomadr, self.model.body_geomnum
        self.mujoco_geoms_of_object = {
            i: range(first[b], first[b] + many[b]) for i, b in self.mujoco_body_of_object.items()
        }
        self.mujoco.mj_forward(self.model, self.data)

    def _simulate_until_rest(self) -> None:
        """Simulate until all objects rest. Their motion is damped so that nothing rolls away."""
        mj, model, data = self.mujoco, self.model, self.data
        for step in range(0, _MAX_STEPS, _DAMPING_STEPS):
            mj.mj_step(model, data, _DAMPING_STEPS)
            if step > _DAMPING_STEPS and (not model.nv or abs(data.qvel).max() < _MAX_RESTING_SPEED):
                break
            data.qvel *= 0.75
        data.qvel[:] = 0
        mj.mj_forward(model, data)

    def show_state(self, state: State) -> None:
        """Show another state of the task. Objects whose location did not change keep their pose.

        This simulates nothing, so nothing falls. An object that does not fit overlaps others in the middle of
        its room, support or container.

        Raises:
            InputError: an object has no body.
        """
        before, locations = self.locations, read_object_locations(state)
        placer = ObjectPlacer(locations, self._names, f"{self.task.id} {hash(state)}")
        kept = self._list_unmoved_objects(before, locations)
        for object_index in kept:
            placer.put(object_index, self._read_pose(object_index))
        place_remaining_objects(placer, locations, self.rooms, crowded=True)
        for object_index in self._bodies:
            if object_index not in kept:
                self.move_object(object_index, placer.poses.get(object_index, Pose(_ABSENT_LOCATION)))
            self._colour_by_states(object_index, placer)
        self.locations = locations
        self.mujoco.mj_forward(self.model, self.data)

    def _list_unmoved_objects(self, before: ObjectLocations, locations: ObjectLocations) -> list[int]:
        """Return the objects whose location is equal in both states.

        An object comes before the objects in or on it.
        """
        kept: list[int] = []
        moved = {*before.hands.values(), *locations.hands.values()}
        for object_index in sorted(locations.bodies, key=locations.count_carriers):
            carrier = locations.find_relation_and_carrier(object_index)
            stays = (
                object_index in before.bodies
                and object_index not in moved
                and before.make_location_key(object_index) == locations.make_location_key(object_index)
            )
            if stays and (carrier is None or carrier[1] in kept):
                kept.append(object_index)
        return kept

    def _read_pose(self, object_index: int) -> Pose:
        body = self.mujoco_body_of_object[object_index]
        x, y, z = self.data.xpos[body].tolist()
        a, b, c, d = self.data.xquat[body].tolist()
        return Pose((x, y, z), (a, b, c, d))

    def _colour_by_states(self, object_index: int, placer: ObjectPlacer) -> None:
        body = self._bodies[object_index]
        states = placer.states.get(object_index, frozenset())
        for geom, part in zip(
            self.mujoco_geoms_of_object[object_index],
            (*body.parts, *make_parts_that_show_states(body)),
            strict=True,
        ):
            seen = object_index in placer.bodies and (not part.when or part.when in states)
            self.model.geom_rgba[geom] = (*tint_colour_by_states(part.colour, states), float(seen))
            self.model.geom_contype[geom] = int(seen and part.is_solid)

    def find_front_direction(self, object_index: int) -> Array:
        """Return the horizontal direction in which the front of an object points, as a vector."""
        axes = self.data.xmat[self.mujoco_body_of_object[object_index]].reshape(3, 3)
        way: Array = -axes[:, 1] if abs(axes[2, 1]) < 0.5 else np.array([0.0, -1.0, 0.0])
        return way

    def move_object(self, object_index: int, pose: Pose) -> None:
        """Put an object into a pose. It may overlap other objects."""
        body = self.mujoco_body_of_object[object_index]
        if self.model.body_dofnum[body]:
            start = self.model.jnt_qposadr[self.model.body_jntadr[body]]
            self.data.qpos[start : start + 7] = (*pose.at, *pose.turn)
        else:
            self.model.body_pos[body], self.model.body_quat[body] = pose.at, pose.turn
        self.mujoco.mj_kinematics(self.model, self.data)

    def list_relations_not_met_by_geometry(self) -> list[tuple[int, str, int]]:
        """Return the relations of the state that the scene's geometry does not fulfil.

        Each is a triple: the index of the first object, the relation, and the index of the second object.
        """
        locations = self.locations
        tests = {
            INSIDE: geometry.is_inside,
            ON: geometry.is_on_top,
            UNDER: geometry.is_under,
            BESIDE: geometry.is_next_to,
        }
        lost = [
            (first, relation, second)
            for relation, test in tests.items()
            for first, second in locations.relations[relation]
            if not test(self, first, second)
        ]
        on_floor = [
            (i, floor)
            for i, floor in locations.floor_of.items()
            if locations.find_relation_and_carrier(i) is None
        ]
        outside = [
            (i, "on the floor of", f) for i, f in on_floor if not geometry.is_on_floor(self, i, self.rooms[f])
        ]
        return lost + [relation for relation in outside if relation[0] not in locations.hands.values()]
