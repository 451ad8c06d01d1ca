"""Aims of questions about ways: how far they are, and that each asks for something."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pytest

from eai.extensions.questions import plans as module
from eai.world.state import Fact


@dataclass
class _Ways:
    """States by how many actions they are away, and what is new in each."""

    depths: Sequence[int]
    gained: Sequence[Sequence[Fact]]


@pytest.mark.parametrize(
    ("gained", "number", "distance"),
    [
        ([2, 3, 4, 5], 0, 2),
        ([2, 3, 4, 5], 1, 3),
        ([2, 3, 4, 5], 2, 4),
        ([4, 5], 0, 4),  # the nearest to what is wanted
        ([2], 2, None),  # what is as far gains nothing
        ([1], 0, None),
        ([], 0, None),
    ],
)
def test_an_aim_is_as_far_as_the_number_says_where_there_is_one(
    monkeypatch: pytest.MonkeyPatch, gained: Sequence[int], number: int, distance: int | None
) -> None:
    depths = list(range(6))
    found = _Ways(depths, [[Fact("lit", (depth,))] if depth in gained else [] for depth in depths])
    made: list[Sequence[Fact]] = []

    class Noted(module._Aim):
        def __init__(self, ways: Any, facts: Sequence[Fact]) -> None:
            made.append(facts)
            super().__init__(ways, facts)

    monkeypatch.setattr(module, "_some_ways", lambda setting, rng: found)
    monkeypatch.setattr(module, "_Aim", Noted)
    aim = module._some_aim(None, random.Random(0), number)  # type: ignore[arg-type]
    assert (aim.distance if aim else None) == distance
    assert all(made), "what gains nothing asks for nothing"
