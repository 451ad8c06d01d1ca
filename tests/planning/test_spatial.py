from __future__ import annotations

import pytest

from eai.benchmark.registry import find_benchmark
from eai.planning.spatial import SpatialRoles, spatial_roles
from world import toy


@pytest.mark.parametrize(
    ("name", "held", "supports"),
    [
        ("virtualhome", ("HOLDS_RH", "HOLDS_LH"), {"INSIDE", "ONTOP"}),
        ("behavior", ("in_left_hand", "in_right_hand"), {"stands_on", "lies_on", "lies_in", "stands_under"}),
    ],
)
def test_households_say_where_things_are(name: str, held: tuple[str, ...], supports: set[str]) -> None:
    roles = spatial_roles(find_benchmark(name).domain)
    assert (roles.held, {*roles.supports}) == (held, supports)


def test_a_world_in_which_nothing_is_put_has_no_supports() -> None:
    without = toy.DOMAIN.with_operators(without=[each.name for each in toy.DOMAIN.operators])
    assert spatial_roles(without) == SpatialRoles((), ())
