"""Goals of questions about all plans: their distance, and that each has facts."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pytest

from eai.extensions.questions import plans as module
from eai.world.state import Fact


@dataclass
class _FakeGraph:
    """States with their depths and their added facts."""

    depths: Sequence[int]
    added_facts: Sequence[Sequence[Fact]]


@pytest.mark.parametrize(
    ("gained", "number", "distance"),
    [
        ([2, 3, 4, 5], 0, 2),
        ([2, 3, 4, 5], 1, 3),
        ([2, 3, 4, 5], 2, 4),
        ([4, 5], 0, 4),  # the nearest distance to the wanted one
        ([2], 2, None),  # no state at this distance has added facts
        ([1], 0, None),
        ([], 0, None),
    ],
)
def test_a_goal_has_the_distance_that_the_number_asks_for_if_possible(
    monkeypatch: pytest.MonkeyPatch, gained: Sequence[int], number: int, distance: int | None
) -> None:
    depths = list(range(6))
    graph = _FakeGraph(depths, [[Fact("lit", (depth,))] if depth in gained else [] for depth in depths])
    made: list[Sequence[Fact]] = []

    class RecordedGoal(module._GoalNeedingSeveralActions):
        def __init__(self, graph: Any, facts: Sequence[Fact]) -> None:
            made.append(facts)
            super().__init__(graph, facts)

    monkeypatch.setattr(module, "_draw_or_reuse_state_graph", lambda setting, rng: graph)
    monkeypatch.setattr(module, "_GoalNeedingSeveralActions", RecordedGoal)
    goal = module._draw_distant_goal(None, random.Random(0), number)  # type: ignore[arg-type]
    assert (goal.distance if goal else None) == distance
    assert all(made), "a goal without facts"
