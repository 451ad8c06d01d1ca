from __future__ import annotations

import pytest

import eai.world as w
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.registry import find_benchmark
from eai.questions.rules import Rules

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
