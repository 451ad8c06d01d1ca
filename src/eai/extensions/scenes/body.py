"""Bodies of objects: sizes and colours by kind of object, and shapes that consist of simple parts."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from eai.base.files import parse_toml

Vector: TypeAlias = tuple[float, float, float]
"""Three numbers: metres to the right, to the back and up; or red, green and blue from 0 to 1."""

Array: TypeAlias = "np.ndarray[Any, np.dtype[np.float64]]"

Box: TypeAlias = Array
"""An axis-aligned box in metres, as two rows of three numbers: the low corner and the high corner."""

HALF_PREFIX = "half_"
"""Prefix of the category of an object that is half of a cut object."""

_SHADES = {"own": 1.0, "light": 1.25, "dark": 0.72, "deep": 0.5}
_STATES = ("open", "closed", "on", "off")
_NUMBER = re.compile(r"(_part)?[._]\d+$")


@dataclass(frozen=True, slots=True, eq=False)
class ObjectBodyPart:
    """A part of a body.

    Attributes:
        form: shape of the part: `box`; `ball` (an ellipsoid); or a cylinder: `post` (upright), `pipe` (from
            front to back), `bar` (from left to right).
        box: the box around the part before its rotation, relative to the middle of the body.
        turn: rotation about the part's own upright axis, in radians.
        colour: red, green and blue from 0 to 1.
        is_solid: whether other bodies collide with the part.
        when: the state of the object, such as `open`, in which the part exists; empty for always.
    """

    form: str
    box: Box
    turn: float
    colour: Vector
    is_solid: bool = True
    when: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ObjectBodyShape:
    """The shape of an object, relative to its middle. Its front is towards negative y.

    Attributes:
        size: width, depth and height in metres.
        parts: the parts of the body.
        stand: location in a room if no other object carries this object: free, wall, high, door, window or
            middle.
        tops: surfaces that can carry other objects, as flat boxes, the best first.
        spaces: spaces that can contain other objects, as boxes, the best first.
        below: the space under the object, as a tuple of one box; empty without such a space.
        slack: height by which contents may rise above a space, as a share of the height of the space.
    """

    size: Vector
    parts: tuple[ObjectBodyPart, ...]
    stand: str = "free"
    tops: tuple[Box, ...] = ()
    spaces: tuple[Box, ...] = ()
    below: tuple[Box, ...] = ()
    slack: float = 0.0


def find_object_kind_for_body_shape(object_name: str, category: str) -> str:
    """Return the kind of an object: its name without a number, or else its category.

    If the table of kinds lacks the whole name, the first word of the name is tried, then the last word:
    ``bottle`` of ``olive_oil__bottle``.
    """
    kind = _NUMBER.sub("", _NUMBER.sub("", object_name)) if not category.startswith(HALF_PREFIX) else category
    words = kind.split("__")
    known = (word for word in (kind, words[0], words[-1]) if find_body_shape_of_object_kind(word) is not None)
    return next(known, category.partition(".")[0])


@cache
def find_body_shape_of_object_kind(kind: str) -> ObjectBodyShape | None:
    """Return the shape of a kind of object, or None if the table of kinds lacks the kind.

    A kind with the prefix `HALF_PREFIX` is half of a sliced object. It has the left half of the object's
    shape.
    """
    if kind.startswith(HALF_PREFIX):
        whole = find_body_shape_of_object_kind(kind.removeprefix(HALF_PREFIX))
        return None if whole is None else _cut_left_half(whole)
    known = read_shape_size_and_colour_by_object_kind().get(kind)
    if known is None:
        return None
    return _make_body_shape_of_object_kind(_read_body_shape_families_and_colours()[known.family], known)


class _ShapeFamilySizeAndColour(NamedTuple):
    """A line of the table of kinds of object: the family of shapes, the size in metres and the colour."""

    family: str
    size: Vector
    colour: Vector


@cache
def read_shape_size_and_colour_by_object_kind() -> Mapping[str, _ShapeFamilySizeAndColour]:
    """Return the size, colour and family of shapes of each kind of object, by the name of the kind."""
    table: dict[str, _ShapeFamilySizeAndColour] = {}
    for line in (files("eai.extensions.scenes") / "kinds.txt").read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            kind, family, width, depth, height, colour, _ = line.split()
            table[kind] = _ShapeFamilySizeAndColour(
                family, (float(width), float(depth), float(height)), _read_hex_colour(colour)
            )
    return table


@cache
def _read_body_shape_families_and_colours() -> Mapping[str, Any]:
    """Return the content of ``shapes.toml``: the colours, and the shapes of each family of objects.

    Objects of a family, such as tables, have one shape in different sizes and colours.
    """
    return parse_toml((files("eai.extensions.scenes") / "shapes.toml").read_text(encoding="utf-8"))


def _make_body_shape_of_object_kind(
    family_shapes: Mapping[str, Any], table_row: _ShapeFamilySizeAndColour
) -> ObjectBodyShape:
    size = table_row.size
    return ObjectBodyShape(
        size,
        tuple([part for line in family_shapes["parts"] for part in _read_object_body_parts(line, table_row)]),
        family_shapes.get("stand", "free"),
        tuple([_read_flat_box_scaled_to_body_size(line, size) for line in family_shapes.get("tops", ())]),
        tuple([_read_box(line.split(), size) for line in family_shapes.get("spaces", ())]),
        (_read_box(family_shapes["below"].split(), size),) if "below" in family_shapes else (),
        float(family_shapes.get("slack", 1.0)),
    )


def _cut_left_half(whole: ObjectBodyShape) -> ObjectBodyShape:
    """Return the left half of a drawn body. Its cut surface, on the right, is pale."""
    width, depth, height = whole.size
    half = np.array([width / 2, depth, height])
    form = "box" if whole.parts[0].form == "box" else "ball"
    colour = whole.parts[0].colour
    red, green, blue = (0.4 * share + 0.6 for share in colour)
    cut = np.array(
        [[half[0] / 2, -0.4 * depth, -0.4 * height], [half[0] / 2 + 0.004, 0.4 * depth, 0.4 * height]]
    )
    parts = (
        ObjectBodyPart(form, np.array([-half / 2, half / 2]), 0.0, colour),
        ObjectBodyPart(form, cut, 0.0, (red, green, blue), is_solid=False),
    )
    return ObjectBodyShape((width / 2, depth, height), parts)


def _read_object_body_parts(line: str, table_row: _ShapeFamilySizeAndColour) -> Iterator[ObjectBodyPart]:
    form, *rest = line.split()
    part = ObjectBodyPart(form, _read_box(rest[:6], table_row.size), 0.0, table_row.colour)
    copies = ""
    for word in rest[6:]:
        if word == "ghost":
            part = replace(part, is_solid=False)
        elif word in _STATES:
            part = replace(part, when=word)
        elif word.startswith("turn-"):
            part = replace(part, turn=math.radians(float(word.removeprefix("turn-"))))
        elif word.startswith(("mirror-", "ring-")):
            copies = word
        else:
            part = replace(part, colour=_read_colour(word, table_row.colour))
    yield from _mirror_or_repeat_part(part, copies)


def _mirror_or_repeat_part(part: ObjectBodyPart, mirror_axes_or_ring_count: str) -> Iterator[ObjectBodyPart]:
    if mirror_axes_or_ring_count.startswith("ring-"):
        number = int(mirror_axes_or_ring_count.removeprefix("ring-"))
        yield from [_rotate_part(part, 2 * math.pi * i / number) for i in range(number)]
        return
    parts = [part]
    for axis, letter in enumerate("xy"):
        if mirror_axes_or_ring_count.startswith(
            "mirror-"
        ) and letter in mirror_axes_or_ring_count.removeprefix("mirror-"):
            parts += [_mirror_part(original, axis) for original in parts]
    yield from parts


def rotate_point(at: Array, angle: float) -> Array:
    """Return a point rotated about the upright axis, by an angle in radians."""
    x, y, z = at
    return np.array([x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle), z])


def _rotate_part(part: ObjectBodyPart, angle: float) -> ObjectBodyPart:
    middle = part.box.mean(0)
    return replace(part, box=part.box - middle + rotate_point(middle, angle), turn=part.turn + angle)


def _mirror_part(part: ObjectBodyPart, axis: int) -> ObjectBodyPart:
    box = part.box.copy()
    box[:, axis] = -box[::-1, axis]
    return replace(part, box=box, turn=-part.turn)


def _read_box(fractions: Sequence[str], size: Vector) -> Box:
    """Return a box relative to the middle of a body, from six coordinates as shares of the body's size."""
    box: Box = (np.array(fractions, dtype=float).reshape(3, 2).T - 0.5) * size
    return box


def _read_flat_box_scaled_to_body_size(line: str, size: Vector) -> Box:
    fractions = line.split()
    return _read_box([*fractions, fractions[-1]], size)


def _read_colour(word: str, body_colour: Vector) -> Vector:
    if word in _SHADES:
        red, green, blue = (min(1.0, share * _SHADES[word]) for share in body_colour)
        return (red, green, blue)
    return _read_hex_colour(
        _read_body_shape_families_and_colours()["colours"].get(word, word.removeprefix("#"))
    )


def _read_hex_colour(digits: str) -> Vector:
    red, green, blue = (int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4))
    return (red, green, blue)
