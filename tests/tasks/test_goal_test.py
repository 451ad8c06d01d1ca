from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.logic.formula import And, Atom, Constant, Exists, ForAll, Formula, Not, Occurs, Or, Variable
from eai.tasks.goal_test import GoalTest, find_longest_series_of_met_action_goals, find_remaining_goals
from eai.tasks.share import Share, TalliesByGoalKind
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.action import Action
from eai.world.execution import execute_plan
from world import toy

BOX, PLACE = Variable("b", "box"), Variable("p", "place")
RED, BLUE, HALL, SHED = (Constant(name) for name in ("red", "blue", "hall", "shed"))
LIT: Formula = Atom("lit", (Constant("lamp"),))
RED_IN_HALL = Atom("at", (RED, HALL))
BLUE_IN_HALL = Atom("at", (BLUE, HALL))


def task(*goals: Goal | Formula) -> Task:
    """A task in the toy world; formulas are goals about states."""
    goals_of_task = tuple(goal if isinstance(goal, Goal) else Goal(GoalKind.STATE, goal) for goal in goals)
    return Task("1", "Toy", "Play.", toy.initial(), goals_of_task, tuple(range(6)))


def action(*alternatives: str) -> Goal:
    return Goal(GoalKind.ACTION, Or(tuple(Occurs(name) for name in alternatives)))


def test_goals_are_told_one_by_one_and_counted_by_kind() -> None:
    given = task(LIT, RED_IN_HALL, action("LIFT"), BLUE_IN_HALL)
    test = GoalTest(given)
    reached = test.evaluate_each_goal(given.initial, ["GO", "LIFT"])
    assert reached == (False, True, True, False)
    assert test.tally_by_kind(reached) == TalliesByGoalKind(Share(0, 1), Share(1, 2), Share(1, 1))
    assert test.tally_by_kind(test.none_reached) == TalliesByGoalKind(Share(0, 1), Share(0, 2), Share(0, 1))


def test_a_goal_of_both_kinds_counts_half_as_each_and_whole_numbers_are_whole() -> None:
    test = GoalTest(task(Exists(BOX, Atom("at", (BOX, HALL)) & Atom("holding", (BOX,))), Not(LIT)))
    first, second, both = (
        test.tally_by_kind(reached) for reached in ((True, False), (False, True), (True, True))
    )
    assert first == TalliesByGoalKind(Share(0.5, 1.5), Share(0.5, 0.5), Share(0, 0))
    assert second == TalliesByGoalKind(Share(1, 1.5), Share(0, 0.5), Share(0, 0))
    assert all(share.numerator == share.denominator for share in both)
    assert isinstance(second.state.numerator, int)


def test_other_formulas_may_be_asked_in_the_goals_place() -> None:
    given = task(LIT, RED_IN_HALL)
    test = GoalTest(given, [RED_IN_HALL, BLUE_IN_HALL])
    assert test.evaluate_each_goal(given.initial, ()) == (True, False)
    assert test.tally_by_kind((True, False)) == TalliesByGoalKind(Share(1, 1), Share(0, 1), Share(0, 0))


def test_a_task_without_goals_reaches_all_of_them() -> None:
    test = GoalTest(task())
    assert test.evaluate_each_goal(toy.initial(), ()) == ()
    assert test.tally_by_kind(()) == TalliesByGoalKind(Share(0, 0), Share(0, 0), Share(0, 0))


@pytest.mark.parametrize(
    ("goals", "actions", "met"),
    [
        (["GRAB"], [], ()),
        (["GRAB"], ["WALK", "GRAB"], (0,)),
        (["LOOKAT|WATCH"], ["WATCH"], (0,)),
        (["LOOKAT|WATCH"], ["READ"], ()),
        (["LOOKAT"], ["LOOKAT_SHORT"], ()),
        (["GRAB", "WASH|RINSE"], ["GRAB", "WALK", "RINSE"], (0, 1)),
        (["GRAB", "WASH|RINSE"], ["RINSE", "GRAB"], (1,)),
        (["GRAB", "GRAB"], ["GRAB"], (0,)),
        (["GRAB", "WASH"], ["WASH"], (1,)),
        (["A", "B", "C"], ["B", "C", "A"], (1, 2)),
    ],
)
def test_action_goals_are_reached_in_their_order(
    goals: list[str], actions: list[str], met: tuple[int, ...]
) -> None:
    test = GoalTest(task(*(action(*goal.split("|")) for goal in goals)))
    assert test.evaluate_each_goal(toy.initial(), actions) == tuple(i in met for i in range(len(goals)))


@given(
    st.lists(st.sampled_from(["A", "B", "AB", "C"]).map(tuple), max_size=5),
    st.lists(st.sampled_from("ABCD"), max_size=7),
)
def test_the_longest_run_of_goals_in_order_counts(goals: list[tuple[str, ...]], actions: list[str]) -> None:
    def is_met(chosen: tuple[int, ...]) -> bool:
        rest = iter(actions)
        return all(any(action in goals[i] for action in rest) for i in chosen)

    found = find_longest_series_of_met_action_goals(goals, actions)
    assert is_met(found)
    longer = combinations(range(len(goals)), len(found) + 1)
    assert not any(is_met(chosen) for chosen in longer)


@pytest.mark.parametrize(
    ("actions", "left"),
    [("", [0, 1, 2, 3]), ("DROP", [0, 1, 2, 3]), ("GO", [1, 2, 3]), ("GO GO", [1, 3]), ("GO GO DROP", [1])],
)
def test_repeated_action_goals_remain_until_each_is_met(actions: str, left: list[int]) -> None:
    given = task(action("GO"), LIT, action("GO"), action("DROP", "LIFT"))
    assert find_remaining_goals(given, actions.split()) == tuple([given.goals[i] for i in left])


@pytest.fixture
def hasty_threads() -> Iterator[None]:
    """Threads that give way to each other all the time."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("hasty_threads")
def test_threads_may_share_a_test() -> None:
    """Quantifiers bind their variables anew for every state, also while others do."""
    boxes_lie = ForAll(BOX, Exists(PLACE, Atom("at", (BOX, PLACE)) & Not(Atom("holding", (BOX,)))))
    together = Exists(PLACE, ForAll(BOX, Atom("at", (BOX, PLACE))))
    apart = And((Exists(BOX, Atom("at", (BOX, HALL))), Exists(BOX, Atom("at", (BOX, SHED)))))
    given = task(boxes_lie, together, apart)
    scene = given.scene
    steps = [("LIFT", "red"), ("GO", "shed"), ("DROP", "red"), ("LIFT", "blue"), ("GO", "hall")]
    plan = [Action(name, (scene.index[thing],)) for name, thing in steps]
    states = execute_plan(toy.DOMAIN, given.initial, plan).states
    test = GoalTest(given)
    expected = [GoalTest(given).evaluate_each_goal(state, ()) for state in states]
    assert len(set(expected)) > 2

    def differing(start: int) -> int:
        numbers = [(start + i) % len(states) for i in range(1_500)]
        return sum(test.evaluate_each_goal(states[i], ()) != expected[i] for i in numbers)

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(differing, range(8))) == 0
