"""The best failed attempt is found by a bounded number of tests, however much is asked for."""

from __future__ import annotations

import pytest

import eai.world as w
from eai.abilities.subgoal_decomposition.best_attempt import best_failed_attempt
from eai.abilities.subgoal_decomposition.ground import Ground
from eai.abilities.subgoal_decomposition.repertoire import Repertoire
from eai.abilities.subgoal_decomposition.uniform_cost import Permitted, SearchGoal, UniformCostSearch
from eai.world.execution import Action
from eai.world.state import State
from world import toy

KNOWN = Repertoire(toy.DOMAIN).known
MOST = 200_000


@pytest.mark.parametrize("lamps", [10, 300])
def test_few_parts_are_tested_and_what_it_takes_is_told(lamps: int) -> None:
    """Every lamp can be lit by itself, and all of them are wanted."""
    things = [w.WorldObject("robot", "robot"), w.WorldObject("hall", "place")]
    things += [w.WorldObject(f"lamp_{i}", "lamp") for i in range(lamps)]
    scene = w.Scene(toy.VOCABULARY, things, agent=0)
    start = scene.state(("at", (i, 1)) for i in range(lamps + 2) if i != 1)
    everything, tested = (1 << lamps) - 1, [0]

    def met(state: State, touched: int, before: int) -> int:
        tested[0] += touched.bit_count()
        return before & ~touched | sum(1 << i for i in range(lamps) if touched >> i & state.has("lit", i + 2))

    press = [
        Ground.of(Action("PRESS", (i + 2,)), KNOWN["PRESS"], start).for_parts(1 << i, everything)
        for i in range(lamps)
    ]
    goal = SearchGoal(0, met, everything, lambda _: False, ())
    search = UniformCostSearch(goal, Permitted(press, (), (), (), 0), 600)
    assert search.shortest(start) == []
    tested[0] = 0
    found = best_failed_attempt([search])
    assert found.refused is not None or found.plans
    assert 0 < tested[0] <= MOST
    assert found.effort >= tested[0] // 32, "effort stands for tests, too"
