"""Appearance of objects: colours, dust, stains, drops and frost that show their states."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

import numpy as np

from eai.extensions.scenes.body import Array, Box, ObjectBodyPart, ObjectBodyShape, Vector, rotate_point

_TINTS: tuple[tuple[str, Vector, float], ...] = (
    ("cooked", (0.42, 0.22, 0.08), 0.6),
    ("burnt", (0.05, 0.04, 0.04), 0.85),
    ("frozen", (0.75, 0.9, 1.0), 0.65),
    ("soaked", (0.15, 0.3, 0.5), 0.45),
    ("dusty", (0.5, 0.47, 0.42), 0.3),
)
"""States that tint a whole object, each with the colour and the strength (0 to 1) of the tint."""

_SPECKS: dict[str, tuple[Vector, int, float]] = {
    "dusty": ((0.8, 0.77, 0.72), 80, 0.03),
    "stained": ((0.32, 0.12, 0.08), 12, 0.09),
    "soaked": ((0.35, 0.65, 0.95), 14, 0.055),
    "frozen": ((0.97, 0.99, 1.0), 16, 0.07),
}
"""States that put specks on an object, each with colour, number and size of the specks.

The size is relative to the size of the object.
"""

_GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))


def tint_colour_by_states(colour: Vector, states: Collection[str]) -> Vector:
    """Return the colour of a body part, tinted by the states of its object."""
    for state, towards, share in _TINTS:
        if state in states:
            red, green, blue = ((1 - share) * a + share * b for a, b in zip(colour, towards, strict=True))
            colour = (red, green, blue)
    return colour


def make_parts_that_show_states(body: ObjectBodyShape) -> Iterator[ObjectBodyPart]:
    """Yield the specks that states add to a body: dust, stains, drops, frost; and a light for `on`."""
    if not any(part.when == "on" for part in body.parts):
        yield _make_power_light(body)
    whole = [part for part in body.parts if part.is_solid and not part.when] or list(body.parts)
    largest = sorted(whole, key=lambda part: -_estimate_area(part.box))[:3]
    total = sum([_estimate_area(part.box) for part in largest])
    for state, (colour, many, size) in _SPECKS.items():
        for part in largest:
            number = max(3, round(many * _estimate_area(part.box) / total))
            yield from _make_dots_on_part(part, state, colour, number, size)


def _make_power_light(body: ObjectBodyShape) -> ObjectBodyPart:
    width, depth, height = body.size
    at, radius = np.array([0.35 * width, -depth / 2, 0.4 * height]), max(0.004, 0.04 * min(body.size))
    box = np.array([at - radius, at + radius])
    return ObjectBodyPart("ball", box, 0.0, (0.1, 1.0, 0.3), is_solid=False, when="on")


def _estimate_area(box: Box) -> float:
    """Return an estimate of the visible area of a part in square metres."""
    x, y, z = (box[1] - box[0]) / 2
    return float(x * y + y * z + z * x)


def _make_dots_on_part(
    part: ObjectBodyPart, state: str, colour: Vector, dot_count: int, size: float
) -> Iterator[ObjectBodyPart]:
    half = (part.box[1] - part.box[0]) / 2
    radius = min(0.05, max(0.0025, size * math.sqrt(_estimate_area(part.box) * 2)))
    flat = np.array([radius, radius, radius * (1.1 if state == "frozen" else 0.35)])
    for index in range(dot_count):
        spot = (
            _find_point_on_box(half, index)
            if part.form == "box"
            else _find_point_on_ball(half, index, dot_count)
        )
        at = rotate_point(spot, part.turn) + part.box.mean(0)
        yield ObjectBodyPart(
            "ball", np.array([at - flat, at + flat]), 0.0, colour, is_solid=False, when=state
        )


def _find_point_on_box(half_size: Array, point_index: int) -> Array:
    """Return one of several points on the surface of a box, given its index.

    Two of three points are on the top of the box, the third is on its front.
    """
    first = ((point_index * 0.754877) % 1 * 2 - 1) * 0.9
    second = ((point_index * 0.569840) % 1 * 2 - 1) * 0.9
    return half_size * ((first, -1.0, second) if point_index % 3 == 2 else (first, second, 1.0))


def _find_point_on_ball(half_size: Array, point_index: int, point_count: int) -> Array:
    height = 1 - 1.4 * (point_index + 0.5) / point_count
    level = math.sqrt(max(0.0, 1 - height * height))
    return half_size * (
        level * math.cos(point_index * _GOLDEN_ANGLE),
        level * math.sin(point_index * _GOLDEN_ANGLE),
        height,
    )
