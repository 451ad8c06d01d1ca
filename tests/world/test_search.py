from __future__ import annotations

from collections import deque
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.logic.formula import And, Atom, Constant, Exists, Formula, Not, Or, Variable
from eai.world.achiever import Achievers
from eai.world.execution import Action, attempt, execute
from eai.world.frame import AGENT
from eai.world.helpful import Helpful
from eai.world.moves import possible_actions
from eai.world.reading import Readings, free_variables
from eai.world.regression import INFINITE, Distances, Regression
from eai.world.search import Planned, Planner, PlanningEnd, PlanningGoal, PlanningLimits
from eai.world.state import State
from eai.world.wanted import Wanted
from world import toy
from world.toy import X, Y, at, beside, holding, lit

START = toy.initial()
SCENE = START.scene
EVERYTHING = tuple(range(len(SCENE.objects)))
PLANNER = Planner(toy.DOMAIN)
REGRESSION = Regression(toy.DOMAIN)


def named(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


LAMP_LIT = named("lit", "lamp")
RED_IN_SHED = named("at", "red", "shed")


def plan(goal: PlanningGoal, limits: PlanningLimits | None = None) -> Planned:
    return PLANNER.plan(START, goal, EVERYTHING, limits)


def told(found: Planned) -> list[str]:
    return [" ".join([a.operator, *(SCENE.objects[i].name for i in a.arguments)]) for a in found.plan]


def test_a_plan_makes_all_conditions_hold_at_the_end() -> None:
    found = plan(PlanningGoal((RED_IN_SHED, LAMP_LIT, Not(named("holding", "red")))))
    assert found.end is PlanningEnd.SOLVED
    trajectory = execute(toy.DOMAIN, START, found.plan)
    assert trajectory.failure is None
    assert trajectory.additional_steps == 0
    assert all(toy.DOMAIN.holds(c, trajectory.final) for c in (RED_IN_SHED, LAMP_LIT))
    assert told(found) == ["LIFT red", "GO shed", "DROP red", "PRESS lamp"]


def test_actions_are_taken_in_order() -> None:
    found = plan(PlanningGoal((named("at", "robot", "hall"),), (("PRESS",), ("LIFT", "DROP"))))
    steps = told(found)
    assert found.end is PlanningEnd.SOLVED
    assert [step.split()[0] for step in steps if not step.startswith("GO")] == ["PRESS", "LIFT"]


def test_nothing_is_to_be_done_where_the_goal_holds() -> None:
    assert plan(PlanningGoal((named("at", "red", "hall"),))) == Planned(PlanningEnd.SOLVED)


def test_what_no_action_brings_about_is_told() -> None:
    lamp_in_hall = named("at", "lamp", "hall")
    found = plan(PlanningGoal((lamp_in_hall, LAMP_LIT), (("FLY",),)))
    assert found.end is PlanningEnd.UNREACHABLE
    assert found.blocked == (lamp_in_hall, ("FLY",))
    assert found.plan == ()


def test_actions_are_only_about_the_objects_that_are_given() -> None:
    objects = [SCENE.index[name] for name in ("robot", "hall", "red")]
    found = PLANNER.plan(START, PlanningGoal((LAMP_LIT,)), objects)
    assert found.end is PlanningEnd.UNREACHABLE


def test_the_limit_ends_a_search() -> None:
    goal = PlanningGoal((RED_IN_SHED, LAMP_LIT))
    found = plan(goal, PlanningLimits(states=2))
    assert (found.end, found.states) == (PlanningEnd.STATES, 2)


def test_what_is_done_for_an_action_can_be_more_than_the_action() -> None:
    def there_and_back(action: Action, state: State) -> tuple[Action, ...]:
        if action.operator != "GO":
            return ()
        hall = Action("GO", (SCENE.index["hall"],))
        return (action, hall) if action != hall else ()

    planner = Planner(toy.DOMAIN, there_and_back)
    found = planner.plan(START, PlanningGoal((), (("GO",),)), EVERYTHING)
    assert told(found) == ["GO shed"]
    assert planner.plan(START, PlanningGoal((LAMP_LIT,)), EVERYTHING).end is PlanningEnd.UNREACHABLE


CONDITIONS = st.sampled_from(
    [
        LAMP_LIT,
        RED_IN_SHED,
        named("at", "blue", "hall"),
        named("at", "robot", "hall"),
        named("holding", "blue"),
        Not(named("holding", "red")),
        Exists(X, holding(X)),
        Not(Exists(X, at(X, Constant("hall")))),
        named("beside", "lamp"),
        Or((named("holding", "red"), LAMP_LIT)),
        named("lit", "red"),
    ]
)


def reachable(goal: PlanningGoal) -> bool:
    """Whether breadth-first search over all actions reaches the goal."""
    queue, seen = deque([(START, 0)]), {(START, 0)}
    while queue:
        state, taken = queue.popleft()
        if taken == len(goal.actions) and all(toy.DOMAIN.holds(c, state) for c in goal.conditions):
            return True
        for operator in toy.DOMAIN.operators:
            for action in possible_actions(toy.DOMAIN, operator, state, EVERYTHING):
                compiled = toy.DOMAIN.compiled[action.operator]
                wanted = goal.actions[taken] if taken < len(goal.actions) else ()
                after = compiled.apply(state, compiled.bind(state, action.arguments))
                node = (after, taken + (action.operator in wanted))
                if node not in seen:
                    seen.add(node)
                    queue.append(node)
    return False


def reaches(steps: list[Action], goal: PlanningGoal) -> bool:
    """Whether a plan, without the steps that are impossible, reaches the goal."""
    state, taken = START, 0
    for step in steps:
        after = attempt(toy.DOMAIN, [state], step)
        if isinstance(after, State):
            state = after
            taken += taken < len(goal.actions) and step.operator in goal.actions[taken]
    return taken == len(goal.actions) and all(toy.DOMAIN.holds(c, state) for c in goal.conditions)


@settings(deadline=None)
@given(
    st.lists(CONDITIONS, max_size=3),
    st.lists(st.sampled_from([("PRESS",), ("LIFT",), ("DROP", "GO")]), max_size=2),
)
def test_a_plan_is_found_exactly_where_there_is_one(
    conditions: list[Formula], actions: list[tuple[str, ...]]
) -> None:
    goal = PlanningGoal(tuple(conditions), tuple(actions))
    found = plan(goal)
    assert (found.end is PlanningEnd.SOLVED) == reachable(goal)
    if found.end is PlanningEnd.SOLVED:
        trajectory = execute(toy.DOMAIN, START, found.plan)
        assert trajectory.failure is None
        assert all(toy.DOMAIN.holds(c, trajectory.final) for c in conditions)
        for i in range(len(found.plan)):
            assert not reaches([*found.plan[:i], *found.plan[i + 1 :]], goal)


# Estimates.


@pytest.mark.parametrize(
    ("condition", "cost"),
    [
        (named("at", "red", "hall"), 0),
        (named("holding", "red"), 1),
        (named("holding", "blue"), 2),  # GO, LIFT
        (LAMP_LIT, 2),  # GO, PRESS
        (RED_IN_SHED, 2),  # LIFT, GO
        (Not(named("at", "robot", "hall")), 1),
        (And((LAMP_LIT, named("holding", "red"))), 3),
        (Or((LAMP_LIT, named("holding", "red"))), 1),
        (Exists(X, holding(X)), 1),
        (named("at", "lamp", "hall"), INFINITE),
    ],
)
def test_the_estimate_adds_up_what_must_be_done(condition: Formula, cost: float) -> None:
    distances = Distances(REGRESSION, START, EVERYTHING)
    assert distances.to(Wanted(condition, {}, True)) == cost


def helpful(distances: Distances, formula: Formula) -> list[Action]:
    found = Helpful(REGRESSION, distances)
    found.towards(Wanted(formula, {}, True))
    return list(found.actions)


def test_helpful_actions_are_possible_at_once() -> None:
    distances = Distances(REGRESSION, START, EVERYTHING)
    go, lift = Action("GO", (SCENE.index["shed"],)), Action("LIFT", (SCENE.index["red"],))
    both = And((LAMP_LIT, named("holding", "red")))
    assert helpful(distances, LAMP_LIT) == [go]
    assert helpful(distances, both) == [go, lift]
    way = distances.to_action(("PRESS",))
    assert (way.cost, way.action) == (2.0, Action("PRESS", (SCENE.index["lamp"],)))
    found = Helpful(REGRESSION, distances)
    found.along(way)
    assert list(found.actions) == [go]
    assert distances.to_action(("FLY",)).cost == INFINITE


def test_changes_are_found_in_the_effects() -> None:
    achievers = Achievers(toy.DOMAIN)
    adding = achievers.of("at", adding=True)
    assert [(each.change.operator.name, len(each.conditions)) for each in adding] == [("GO", 1), ("GO", 2)]
    assert adding[0].match((0, 1), agent=0) == {"x": 1}
    assert adding[0].match((2, 1), agent=0) is None
    assert adding[1].match((2, 1), agent=0) == {"y": 2, "x": 1}
    assert [each.change.operator.name for each in achievers.of("lit", adding=False)] == ["PRESS"]
    assert [operator.name for operator in achievers.writers(["lit", "holding"])] == ["PRESS", "LIFT", "DROP"]


def test_what_an_effect_hides_is_left_out() -> None:
    hidden = replace(toy.GO, name="HIDE", parameters=(X, Y))
    domain = replace(toy.DOMAIN, operators=(hidden,))
    assert [each.change.atom for each in Achievers(domain).of("at", adding=True)] == [at(AGENT, X)]


def test_formulas_are_read_with_their_free_variables() -> None:
    formula = beside(X) & ~Exists(Y, at(Y, X) & lit(Y))
    assert free_variables(formula) == frozenset("x")
    readings = Readings(toy.VOCABULARY)
    red, shed = SCENE.index["red"], SCENE.index["shed"]
    assert readings.holds(formula, {"x": red}, START)
    assert not readings.holds(formula, {"x": SCENE.index["lamp"]}, START)
    body = at(Y, X)
    assert list(readings.witnesses(Variable("y"), body, {"x": shed}, START)) == [
        SCENE.index["blue"],
        SCENE.index["lamp"],
    ]
    assert list(readings.witnesses(Variable("y", "box"), body, {"x": shed}, START)) == [SCENE.index["blue"]]
