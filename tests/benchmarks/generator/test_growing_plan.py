"""Walks from goal to goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import pytest

from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator import growing_plan as walking
from eai.benchmarks.generator.growing_plan import GoalByGoalPlan, _make_trajectory, make_shortened_plan
from eai.logic.formula import Always, Atom, Constant, Formula, Not, Occurs, Or
from eai.planning.planner import Planner
from eai.planning.search import Limits, SearchNode
from eai.planning.successor_generator import PlanNode
from eai.tasks.source import Source
from eai.world.action import Action
from eai.world.execution import execute_plan


def test_the_execution_of_a_node_follows_its_plan(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["light"]
    lamp = task.scene.index["lamp_1"]
    plan = (Action("GO", (lamp,)), Action("PRESS", (lamp,)))
    way = execute_plan(lamps.domain, task.initial, plan)
    node: PlanNode = SearchNode(way.states[0])
    for action, state in zip(plan, way.states[1:], strict=True):
        node = SearchNode(state, depth=node.depth + 1, parent=node, actions=(action,))
    course = _make_trajectory(node)
    assert course.states == way.states
    assert course.executed_actions == plan == way.executed_actions


def test_a_plan_is_followed_that_runs_and_reaches_its_goals(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["light"]
    wanted = Atom("lit", (Constant("lamp_1"),))
    lamp = task.scene.index["lamp_1"]
    go, press = Action("GO", (lamp,)), Action("PRESS", (lamp,))
    walk = GoalByGoalPlan(Planner(lamps.domain), task.initial)
    assert not walk.append_plan_if_it_reaches_goals((go,), (wanted,)), "the goal is not met"
    assert not walk.append_plan_if_it_reaches_goals((go, press, Action("TAKE", (lamp,))), (wanted,)), (
        "the last action fails, though the goal is met"
    )
    assert walk.state == task.initial
    assert walk.append_plan_if_it_reaches_goals((go, press), (wanted,))
    assert walk.trail == [go, press]


def lit(lamp: str) -> Formula:
    return Atom("lit", (Constant(lamp),))


def names(walk: GoalByGoalPlan) -> list[str]:
    return [action.operator for action in walk.trail]


def test_a_walk_reaches_one_more_goal_and_returns_to_a_mark(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["light"]
    walk = GoalByGoalPlan(Planner(lamps.domain), task.initial)
    assert walk.scene_object_indices == tuple(range(5))
    assert not walk.reach_goal(lit("robot")), "no way is found"
    assert walk.reach_goal(lit("lamp_1"))
    assert not walk.reach_goal(lit("lamp_1")), "it holds"
    assert names(walk) == ["GO", "PRESS"]
    mark, state = walk.get_plan_checkpoint(), walk.state
    taken = Or((Occurs("TAKE"), Occurs("OPEN")))
    assert walk.reach_goal(taken)
    assert not walk.goal_holds(taken, walk.state)
    assert walk.goal_holds(lit("lamp_1"), walk.state)
    assert walk.reach_goal(lit("lamp_2"))
    assert (walk.conditions, walk.actions) == ([lit("lamp_1"), lit("lamp_2")], [("TAKE", "OPEN")])
    assert walk.goals == [lit("lamp_1"), taken, lit("lamp_2")]
    assert len(walk.trail) == 6
    walk.go_back_to(mark)
    assert (walk.state, names(walk)) == (state, ["GO", "PRESS"])
    assert (walk.conditions, walk.actions, walk.goals) == ([lit("lamp_1")], [], [lit("lamp_1")])


@dataclass
class _Found:
    plan: Sequence[Action]


@dataclass
class _Stub:
    """A planner that returns one plan for everything, and records goals and limits."""

    plan_: Sequence[Action] = ()
    asked: list[tuple[object, ...]] = field(default_factory=list)

    def find_plan(self, *asked: object) -> _Found:
        self.asked.append(asked)
        return _Found(self.plan_)


STEP = Action("GO", (0,))


@pytest.mark.parametrize(
    ("walked", "found", "over_time", "left"),
    [
        (24, 2, None, 24),
        (25, 2, None, 2),
        (25, 24, None, 24),
        (25, 1, None, 1),
        (25, 0, None, 25),
        (26, 26, None, 26),
        (25, 2, Always(Not(lit("lamp_1"))), 25),
    ],
)
def test_a_shorter_plan_is_searched_for_a_long_walk(
    lamps: Benchmark,
    monkeypatch: pytest.MonkeyPatch,
    walked: int,
    found: int,
    over_time: Formula | None,
    left: int,
) -> None:
    planner, trail = _Stub([Action("PRESS", (0,))] * found), [STEP] * walked
    monkeypatch.setattr(walking, "_drop_needless_actions", lambda walk, asked, over_time: trail)
    walk = GoalByGoalPlan(planner, lamps.tasks(Source())["light"].initial)  # type: ignore[arg-type]
    certified = make_shortened_plan(walk, over_time)
    assert len(certified) == left
    assert (certified is trail) == (left == walked)
    assert len(planner.asked) == (walked >= 25 and over_time is None)
    assert all(asked[-1] == Limits(300) for asked in planner.asked)


def test_a_certificate_drops_needless_actions(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["light"]
    one, two, ball = (task.scene.index[name] for name in ("lamp_1", "lamp_2", "ball"))
    walk = GoalByGoalPlan(Planner(lamps.domain), task.initial)
    plan = [("GO", ball), ("GO", one), ("PRESS", one), ("GO", two), ("PRESS", two)]
    assert walk.append_plan_if_it_reaches_goals(
        [Action(name, (index,)) for name, index in plan], [lit("lamp_1")]
    )
    assert [(name, index) for name, (index,) in make_shortened_plan(walk)] == plan[1:3]
    never = Always(Not(Atom("at", (Constant("robot"), Constant("ball")))))
    assert len(make_shortened_plan(walk, Not(never))) == 3, "the detour is asked for"
    walk.actions.append(("GO", "TAKE"))
    walk.actions.append(("GO",))
    assert [name for name, _ in make_shortened_plan(walk)] == ["GO", "PRESS", "GO"]
