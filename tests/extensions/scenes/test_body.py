"""Kinds and shapes: each line of the tables is a body."""

from __future__ import annotations

import numpy as np
import pytest

from eai.extensions.scenes.arranging import _STANDS
from eai.extensions.scenes.body import (
    find_body_shape_of_object_kind,
    find_object_kind_for_body_shape,
    read_shape_size_and_colour_by_object_kind,
)
from eai.extensions.scenes.scene import _TYPES
from extensions.scenes import installed  # noqa: F401 - skips all of this where MuJoCo is not installed


def test_every_kind_has_a_body_whose_parts_are_near_its_size() -> None:
    for name in read_shape_size_and_colour_by_object_kind():
        body = find_body_shape_of_object_kind(name)
        assert body is not None
        assert body.stand in _STANDS
        assert {part.form for part in body.parts} <= {*_TYPES}
        assert any(part.is_solid and not part.when for part in body.parts), name
        boxes = [part.box for part in body.parts if part.when != "open"]
        low, high = np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))
        assert (high - low > 0.55 * np.array(body.size)).all(), name
        assert (np.abs(low + high)[:2] < 1.5 * np.array(body.size[:2])).all(), name


@pytest.mark.parametrize(
    ("name", "category", "kind"),
    [
        ("apple_0", "apple.n.01", "apple"),
        ("apple_0_part_1", "half_apple", "half_apple"),
        ("room_apple.n.01_3", "apple.n.01", "apple"),
        ("t-shirt_12", "jersey.n.03", "t-shirt"),
        ("unicorn_1", "unicorn.n.01", "unicorn"),
        ("olive_oil__bottle_1", "olive_oil__bottle.n.01", "olive_oil"),
        ("vinegar__bottle_1", "vinegar__bottle.n.01", "bottle"),
        ("can__of__soda_2", "can__of__soda.n.01", "can"),
    ],
)
def test_kinds_are_told_by_name_or_category(name: str, category: str, kind: str) -> None:
    assert find_object_kind_for_body_shape(name, category) == kind


def test_half_a_thing_is_half_as_wide_and_what_is_unknown_has_no_body() -> None:
    half, whole = find_body_shape_of_object_kind("half_apple"), find_body_shape_of_object_kind("apple")
    assert half is not None
    assert whole is not None
    assert half.size == (whole.size[0] / 2, *whole.size[1:])
    assert find_body_shape_of_object_kind("unicorn") is None
    assert find_body_shape_of_object_kind("half_unicorn") is None
