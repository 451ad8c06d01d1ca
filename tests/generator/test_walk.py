"""Walks from goal to goal."""

from __future__ import annotations

from eai.benchmark.benchmark import Benchmark
from eai.generator.walk import Walk, _course
from eai.logic.formula import Atom, Constant
from eai.planning.planner import Planner
from eai.planning.search import Node
from eai.planning.successor_generator import PlanNode
from eai.tasks.source import Source
from eai.world.execution import Action, execute


def test_the_way_to_a_node_is_that_of_its_plan(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["light"]
    lamp = task.scene.index["lamp_1"]
    plan = (Action("GO", (lamp,)), Action("PRESS", (lamp,)))
    way = execute(lamps.domain, task.initial, plan)
    node: PlanNode = Node(way.states[0])
    for action, state in zip(plan, way.states[1:], strict=True):
        node = Node(state, depth=node.depth + 1, parent=node, actions=(action,))
    course = _course(node)
    assert course.states == way.states
    assert course.executed == plan == way.executed


def test_a_plan_is_followed_that_runs_and_reaches_its_goals(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["light"]
    wanted = Atom("lit", (Constant("lamp_1"),))
    lamp = task.scene.index["lamp_1"]
    go, press = Action("GO", (lamp,)), Action("PRESS", (lamp,))
    walk = Walk(lamps.domain, Planner(lamps.domain), task.initial)
    assert not walk.follow((go,), (wanted,)), "the goal is not met"
    assert not walk.follow((go, press, Action("TAKE", (lamp,))), (wanted,)), (
        "the last action fails, though the goal is met"
    )
    assert walk.state == task.initial
    assert walk.follow((go, press), (wanted,))
    assert walk.trail == [go, press]
