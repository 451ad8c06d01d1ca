from __future__ import annotations

from eai.benchmark.benchmark import Benchmark
from eai.planning.planner import Planner
from eai.questions.repertoire import Edge, exhaust
from eai.questions.rules import Rules
from eai.questions.setting import Setting, open_setting
from eai.tasks.source import Source
from eai.world.execution import Action
from eai.world.state import Fact

ROBOT, LAMP_1, LAMP_2, BALL, BOX = range(5)
TO_LAMP_1, TO_LAMP_2 = Action("GO", (LAMP_1,)), Action("GO", (LAMP_2,))
PRESS_1, PRESS_2 = Action("PRESS", (LAMP_1,)), Action("PRESS", (LAMP_2,))


def setting(lamps: Benchmark, task: str = "light") -> Setting:
    rules, planner = Rules(lamps.domain), Planner(lamps.domain)
    return open_setting(lamps.tasks(Source())[task], rules, planner, "0")


def test_everything_that_some_actions_lead_to_is_found_nearest_first(lamps: Benchmark) -> None:
    world = setting(lamps)
    ways = exhaust(world, world.states[0], [TO_LAMP_1, PRESS_1, PRESS_2], 100)
    assert ways is not None
    assert [world.facts(state) for state in ways.states[1:]] == [
        [("at", (ROBOT, LAMP_1))],
        [("lit", (LAMP_1,)), ("at", (ROBOT, LAMP_1))],
    ]
    assert ways.depths == (0, 1, 2)
    assert ways.edges == ((Edge(0, 1),), (Edge(1, 2),), ())


def test_what_some_of_the_actions_lead_to_is_what_they_lead_to_by_themselves(lamps: Benchmark) -> None:
    world = setting(lamps)
    actions = [TO_LAMP_1, PRESS_2, TO_LAMP_2, PRESS_1]
    at_a_lamp = world.after(world.states[0], TO_LAMP_1)
    assert at_a_lamp is not None
    for start in (at_a_lamp, world.states[0]):  # to the first of them one may come back
        ways = exhaust(world, start, actions, 100)
        assert ways is not None
        for kept in ([], [0], [0, 3], [1, 2], [0, 1, 2, 3], [0, 2, 3]):
            alone = exhaust(world, start, [actions[n] for n in kept], 100)
            assert ways.within(kept) == alone
    assert ways is not None
    assert ways.becoming_true == {
        Fact("lit", (LAMP_1,)),
        Fact("lit", (LAMP_2,)),
        Fact("at", (ROBOT, LAMP_1)),
        Fact("at", (ROBOT, LAMP_2)),
    }


def test_distances_with_and_without_an_action(lamps: Benchmark) -> None:
    world = setting(lamps)
    ways = exhaust(world, world.states[0], [TO_LAMP_1, TO_LAMP_2, PRESS_1, PRESS_2], 100)
    assert ways is not None

    def both_lit(number: int) -> bool:
        return ways is not None and ways.states[number].those("lit").bit_count() == 2

    assert ways.distance(both_lit) == 4
    assert [ways.distance(both_lit, without=n) for n in range(4)] == [None] * 4
    assert ways.distance(lambda n: n == 0, without=0) == 0
    left = ways.from_here(both_lit)
    assert left[0] == 4
    assert {left[edge.target] for edge in ways.edges[0]} == {3}
    assert ways.from_here(lambda n: False) == {}


def test_more_states_than_may_be_are_no_answer(lamps: Benchmark) -> None:
    world = setting(lamps)
    assert exhaust(world, world.states[0], [TO_LAMP_1, PRESS_1], 3) is not None
    assert exhaust(world, world.states[0], [TO_LAMP_1, PRESS_1], 2) is None


def test_a_setting_without_a_plan_of_its_own_takes_what_search_finds(lamps: Benchmark) -> None:
    world = setting(lamps, "pack")
    assert world.works
    assert [action.operator for action in world.way] == ["GO", "OPEN", "GO", "TAKE", "GO", "PUT"]
    assert len(world.states) == len(world.way) + 1
