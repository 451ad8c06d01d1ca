"""Models: arranged bodies, rooms and light as a text for MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from xml.etree import ElementTree as Xml

from eai.bodies.arranging import HEIGHT
from eai.bodies.body import Body, Box, Part, Vector
from eai.bodies.looks import painted, specks
from eai.bodies.placing import Placing, Pose
from eai.bodies.told import Told

_TYPES = {"box": "box", "ball": "ellipsoid", "post": "cylinder", "pipe": "cylinder", "bar": "cylinder"}
_TURNS = {"pipe": (0.70710678, 0.70710678, 0.0, 0.0), "bar": (0.70710678, 0.0, 0.70710678, 0.0)}
_AXES = {"post": 2, "pipe": 1, "bar": 0}
_FIXED, _LOOSE = ("1", "2"), ("2", "3")
"""The masks of contacts: furniture meets loose things alone, these meet everything."""

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


def model_text(placing: Placing, told: Told, rooms: Mapping[int, Box], away: Vector) -> str:
    """The model of arranged bodies.

    Args:
        placing: the bodies that are there, with their poses.
        told: what a state tells of them. Only in the fullest room there are shadows, which take most of the
            time.
        rooms: the box of each room.
        away: where things are that may be there later, and those without a pose.
    """
    text = (files("eai.bodies") / "world.xml").read_text(encoding="utf-8")
    root = Xml.fromstring(text)  # noqa: S314 - our own text
    world = root.find("worldbody")
    if world is None:
        raise ValueError("a model has a world")
    for floor, box in rooms.items():
        edges = {round(float(other[i, 0]), 3) for i in (0, 1) for other in rooms.values() if other is not box}
        walls = [round(float(x), 3) not in edges for x in box[:, 0]]
        world.extend(_room(box, placing.names[floor], walls))
        world.append(_lamp(box, shadows=floor == told.fullest))
    for thing, body in {**placing.bodies, **told.absent}.items():
        pose = placing.poses.get(thing, Pose(away))
        is_fixed = thing in placing.furniture
        states = placing.states.get(thing, frozenset())
        world.append(_body(thing, body, pose, states, is_fixed=is_fixed, is_there=thing in placing.poses))
    return Xml.tostring(root, encoding="unicode")


def _body(
    thing: int, body: Body, pose: Pose, states: frozenset[str], *, is_fixed: bool, is_there: bool
) -> Xml.Element:
    """A thing; what is furniture or not there does not move."""
    element = Xml.Element("body", name=f"b{thing}", pos=_said(pose.at), quat=_said(pose.turn))
    if not is_fixed and is_there:
        Xml.SubElement(element, "freejoint")
    for part in (*body.parts, *specks(body)):
        seen = not part.when or part.when in states
        meets = (_FIXED if is_fixed else _LOOSE) if part.is_solid and seen and is_there else ("0", "0")
        element.append(_geom(part, meets, (*painted(part.colour, states), float(seen))))
    return element


def _geom(part: Part, meets: tuple[str, str], rgba: tuple[float, ...]) -> Xml.Element:
    """A part."""
    geom = Xml.Element("geom", type=_TYPES[part.form], pos=_said(part.box.mean(0).tolist()), rgba=_said(rgba))
    geom.set("contype", meets[0])
    geom.set("conaffinity", meets[1])
    half = ((part.box[1] - part.box[0]) / 2).tolist()
    axis = _AXES.get(part.form)
    if axis is not None:
        across = [half[i] for i in range(3) if i != axis]
        half = [sum(across) / 2, half[axis], 0.0]
        geom.set("quat", _said(_TURNS.get(part.form, (1.0, 0.0, 0.0, 0.0))))
    if part.turn:
        geom.set("euler", f"0 0 {part.turn:.6g}")
        geom.attrib.pop("quat", None)
    if not part.is_solid:
        geom.set("mass", "0")
    geom.set("size", _said([max(1e-4, each) for each in half]))
    return geom


def _room(box: Box, name: str, walls: Sequence[bool]) -> Iterator[Xml.Element]:
    """The floor and walls of a room; none in front, and left and right where they are wanted."""
    (x0, y0, _), (x1, y1, _) = box
    look = next((look for look, words in _FLOORS.items() if any(word in name for word in words)), "wood")
    yield _slab((x0, x1, y0, y1, -0.1, 0.0), material=look)
    wall = next((colour for word, colour in _WALLS.items() if word in name), "0.9 0.89 0.85")
    sides = [
        side for side, is_there in zip(((x0 - 0.08, x0), (x1, x1 + 0.08)), walls, strict=True) if is_there
    ]
    for side in ((x0, x1, y1, y1 + 0.08), *[(*x, y0, y1 + 0.08) for x in sides]):
        yield _slab((*side, 0.0, HEIGHT), rgba=f"{wall} 1")
    trim = "0.97 0.97 0.95 1"
    yield _slab((x0, x1, y1 - 0.012, y1, 0.0, 0.09), rgba=trim, contype="0", conaffinity="0")
    yield _slab((x0, x1, y0 - 0.08, y0, 0.0, HEIGHT), rgba="0 0 0 0")


def _lamp(box: Box, *, shadows: bool) -> Xml.Element:
    """The lamp of a room."""
    x, y, _ = box.mean(0)
    lamp = Xml.Element(
        "light", pos=_said([x, y - 0.5, 2.9]), dir="0.05 0.15 -1", diffuse="0.4 0.4 0.38", cutoff="85"
    )
    lamp.set("specular", "0.04 0.04 0.04")
    lamp.set("castshadow", str(shadows).lower())
    return lamp


def _slab(sides: tuple[float, ...], **more: str) -> Xml.Element:
    """A fixed box between six planes."""
    pairs = list(zip(sides[::2], sides[1::2], strict=True))
    size, middle = [(high - low) / 2 for low, high in pairs], [(low + high) / 2 for low, high in pairs]
    slab = Xml.Element("geom", type="box", size=_said(size), pos=_said(middle))
    slab.attrib |= {"contype": _FIXED[0], "conaffinity": _FIXED[1], **more}
    return slab


def _said(numbers: tuple[float, ...] | list[float]) -> str:
    return " ".join([f"{number:.6g}" for number in numbers])
