from __future__ import annotations

import pytest

import eai.world as w
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.registry import find_benchmark
from eai.planning.planner import Planner
from eai.questions.rules import Edge, Rules, exhaust
from eai.questions.setting import Setting, open_setting
from eai.tasks.source import Source
from eai.world.execution import Action
from eai.world.state import Fact

PUT = """\
PUT(x, y)
  requirement 1: is_a(y, box)   [otherwise "y is no box"]
  requirement 2: holds(agent, x)   [otherwise "the robot does not hold x"]
  requirement 3: at(agent, y)   [otherwise "the robot is not at y"]
  requirement 4: is_open(y)   [otherwise "y is closed"]
  becomes false: holds(agent, x)
  becomes true: inside(x, y)"""


def test_an_operator_is_told_as_it_is_declared(lamps: Benchmark) -> None:
    assert Rules(lamps.domain).text({"PUT"}) == PUT


def test_operators_are_told_in_the_order_of_the_declaration(lamps: Benchmark) -> None:
    text = Rules(lamps.domain).text({"PUT", "GO"})
    assert text.splitlines()[0] == "GO(x)"
    assert text.endswith(PUT)


x, y = w.Variable("x"), w.Variable("y")
on, near = w.Predicate("on", 1), w.Predicate("near", 2)
hidden, tag = w.Predicate("hidden", 1, visible=False), w.Predicate("tag", 1, static=True, visible=False)
ready = w.Defined("ready", (x,), ~on(x) & w.Exists(y, near(x, y)))
counted = w.Computed("counted", 1, lambda state, things: True, ("on",))
OPERATORS = (
    w.Operator(
        "START",
        (x,),
        (w.missing(ready(x), "{x} is not ready"),),
        (
            w.Add(on(x)),
            w.Add(hidden(x)),
            w.When(tag(x), (w.Add(hidden(x)),)),
            w.When(
                tag(x), (w.Delete(near(x, w.ANYTHING)), w.Delete(near(w.ANYTHING, x))), (w.Add(near(x, x)),)
            ),
            w.ForEach(y, near(x, y), (w.Let(x, near(x, y), (w.Add(on(x)),)),)),
        ),
        "make it run",
    ),
    w.Operator("RECALL", (x,), (w.missing(hidden(x), "{x} is not hidden"),), (w.Add(on(x)),)),
    w.Operator("COUNT", (x,), (w.missing(counted(x), "{x} does not count"),), ()),
    w.Operator("TRY", (x,), (), (), tries=(w.Try(on(x), (), (w.Delete(on(x)),)),)),
    w.Operator("LOOK", (), (), ()),
)
WORLD = Rules(w.Domain("world", w.Vocabulary((on, near, hidden, tag), (ready, counted)), OPERATORS))


def test_what_cannot_be_told_is_left_out() -> None:
    assert [operator.name for operator in WORLD.operators] == ["START", "LOOK"]
    assert WORLD.memory == {"hidden"}
    assert WORLD.fluents == {"on", "near"}
    assert WORLD.written("START") == {"on", "near"}
    assert WORLD.predicates({"START"}) == {"on", "near", "tag"}
    assert WORLD.predicates({"LOOK"}) == frozenset()
    assert WORLD.predicates({"LOOK"}, [ready(x)]) == {"on", "near"}


def test_effects_are_told_with_their_conditions_and_definitions_once() -> None:
    assert WORLD.text({"START", "LOOK"}) == (
        "START(x): make it run\n"
        '  requirement 1: ready(x)   [otherwise "x is not ready"]\n'
        "  becomes true: on(x)\n"
        "  if tag(x):\n"
        "    becomes false: near(x, *), near(*, x)\n"
        "  if not tag(x):\n"
        "    becomes true: near(x, x)\n"
        "  for each y with near(x, y):\n"
        "    for the first x with near(x, y):\n"
        "      becomes true: on(x)\n"
        "LOOK()\n"
        "  changes nothing\n"
        "ready(x) means: not on(x) and exists y. (near(x, y))"
    )


@pytest.mark.parametrize(("domain", "left_out"), [("virtualhome", {"PUTOBJBACK"}), ("behavior", {"CLEAN"})])
def test_of_households_one_operator_cannot_be_told(domain: str, left_out: set[str]) -> None:
    rules = Rules(find_benchmark(domain).domain)
    assert set(rules.domain.arities) - rules.names == left_out
    text = rules.text(rules.names)
    assert not any(name in text for name in rules.memory)


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
    assert {left[n] for n in left if both_lit(n)} == {0}
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
