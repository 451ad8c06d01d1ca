from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from by_path import ROOT
from eai.benchmarks.registry import find_benchmark
from eai.logic.formula import Atom, Constant, Exists, Formula, Not, Or
from eai.planning.additive_heuristic import AdditiveHeuristic
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import Limits, SearchEndReason, SearchResult
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.tasks.planning import find_plan
from eai.tasks.source import Source
from eai.world.action import Action
from eai.world.execution import attempt_action, execute_plan
from eai.world.history import History
from eai.world.state import State
from world import toy
from world.toy import X, at, holding

START = toy.initial()
SCENE = START.scene
EVERYTHING = tuple(range(len(SCENE.objects)))
PLANNER = Planner(toy.DOMAIN)
HEURISTIC = AdditiveHeuristic(toy.DOMAIN)


def named(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


LAMP_LIT = named("lit", "lamp")
RED_IN_SHED = named("at", "red", "shed")


def plan(goal: PlanningGoal, limits: Limits | None = None) -> SearchResult[Action]:
    return PLANNER.find_plan(START, goal, EVERYTHING, limits)


def steps_of(found: SearchResult[Action]) -> list[str]:
    return [" ".join([a.operator, *(SCENE.objects[i].name for i in a.arguments)]) for a in found.plan]


def test_a_plan_makes_all_conditions_hold_at_the_end() -> None:
    found = plan(PlanningGoal((RED_IN_SHED, LAMP_LIT, Not(named("holding", "red")))))
    assert found.end is SearchEndReason.SOLVED
    trajectory = execute_plan(toy.DOMAIN, START, found.plan)
    assert trajectory.failure is None
    assert trajectory.needless_step_count == 0
    assert all(toy.DOMAIN.holds(c, trajectory.final_state) for c in (RED_IN_SHED, LAMP_LIT))
    assert steps_of(found) == ["LIFT red", "GO shed", "DROP red", "PRESS lamp"]


def test_actions_are_taken_in_order() -> None:
    found = plan(PlanningGoal((named("at", "robot", "hall"),), (("PRESS",), ("LIFT", "DROP"))))
    steps = steps_of(found)
    assert found.end is SearchEndReason.SOLVED
    assert [step.split()[0] for step in steps if not step.startswith("GO")] == ["PRESS", "LIFT"]


def test_a_goal_that_already_holds_has_an_empty_plan() -> None:
    assert plan(PlanningGoal((named("at", "red", "hall"),))) == SearchResult(SearchEndReason.SOLVED)


def test_a_goal_that_no_action_establishes_has_no_plan() -> None:
    lamp_in_hall = named("at", "lamp", "hall")
    found = plan(PlanningGoal((lamp_in_hall, LAMP_LIT), (("FLY",),)))
    assert found.end is SearchEndReason.UNREACHABLE
    assert found.plan == ()


def test_plans_use_the_given_objects_only() -> None:
    objects = [SCENE.index[name] for name in ("robot", "hall", "red")]
    found = PLANNER.find_plan(START, PlanningGoal((LAMP_LIT,)), objects)
    assert found.end is SearchEndReason.UNREACHABLE


def test_a_goal_about_another_object_permits_no_action_on_this_object() -> None:
    objects = [SCENE.index[name] for name in ("robot", "hall", "red")]
    for goal in (named("holding", "blue"), named("at", "robot", "shed")):
        assert plan(PlanningGoal((goal,))).end is SearchEndReason.SOLVED
        assert PLANNER.find_plan(START, PlanningGoal((goal,)), objects).end is SearchEndReason.UNREACHABLE


def test_the_limit_ends_a_search() -> None:
    goal = PlanningGoal((RED_IN_SHED, LAMP_LIT))
    found = plan(goal, Limits(states=2))
    assert (found.end, found.states) == (SearchEndReason.STATES, 2)


def test_a_plan_that_is_found_at_the_limit_counts() -> None:
    goal = PlanningGoal((RED_IN_SHED, LAMP_LIT))
    found = plan(goal)
    assert plan(goal, Limits(states=found.states)) == found
    assert plan(goal, Limits(states=found.states - 1)).end is SearchEndReason.STATES


def test_a_planner_may_be_restricted_to_allowed_states() -> None:
    goal = PlanningGoal((LAMP_LIT, RED_IN_SHED))
    empty = Not(Exists(X, holding(X)))
    planner = PLANNER.restrict_states(lambda state: toy.DOMAIN.holds(empty, state))
    assert PLANNER.find_plan(START, goal, EVERYTHING).end is SearchEndReason.SOLVED
    assert planner.find_plan(START, goal, EVERYTHING).end is SearchEndReason.UNREACHABLE, (
        "red is carried there"
    )
    assert steps_of(planner.find_plan(START, PlanningGoal((LAMP_LIT,)), EVERYTHING)) == [
        "GO shed",
        "PRESS lamp",
    ]


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
            for action in generate_applicable_actions_of_operator(toy.DOMAIN, operator, state, EVERYTHING):
                compiled = toy.DOMAIN.compiled_operators[action.operator]
                subgoal = goal.actions[taken] if taken < len(goal.actions) else ()
                after = compiled.apply(state, compiled.bind(state, action.arguments))
                node = (after, taken + (action.operator in subgoal))
                if node not in seen:
                    seen.add(node)
                    queue.append(node)
    return False


def reaches(steps: list[Action], goal: PlanningGoal) -> bool:
    """Whether a plan reaches the goal if its impossible steps are skipped."""
    state, taken = START, 0
    for step in steps:
        after = attempt_action(toy.DOMAIN, History(state), step)
        if isinstance(after, State):
            state = after
            taken += taken < len(goal.actions) and step.operator in goal.actions[taken]
    return taken == len(goal.actions) and all(toy.DOMAIN.holds(c, state) for c in goal.conditions)


@settings(deadline=None)
@given(
    st.lists(CONDITIONS, max_size=3),
    st.lists(st.sampled_from([("PRESS",), ("LIFT",), ("DROP", "GO")]), max_size=2),
)
def test_a_plan_is_found_if_and_only_if_the_goal_is_reachable(
    conditions: list[Formula], actions: list[tuple[str, ...]]
) -> None:
    goal = PlanningGoal(tuple(conditions), tuple(actions))
    found = plan(goal)
    assert (found.end is SearchEndReason.SOLVED) == reachable(goal)
    if found.end is SearchEndReason.SOLVED:
        trajectory = execute_plan(toy.DOMAIN, START, found.plan)
        assert trajectory.failure is None
        assert all(toy.DOMAIN.holds(c, trajectory.final_state) for c in conditions)
        for i in range(len(found.plan)):
            assert not reaches([*found.plan[:i], *found.plan[i + 1 :]], goal)


BLOCKS = ROOT / "tests" / "pddl" / "domains" / "blocksworld" / "domain.pddl"
DEPOT = ROOT / "bench" / "domains" / "depot.pddl"


def solve(domain: Path, problem: str, folder: Path, limits: Limits | None = None) -> SearchResult[Action]:
    """Plan for a problem in PDDL, which is written to a file in a folder."""
    file = folder / "problem.pddl"
    file.write_text(problem)
    benchmark = find_benchmark(f"pddl:{domain},{file}")
    (task,) = benchmark.tasks(Source()).values()
    return find_plan(task, Planner(benchmark.domain), limits)


def restack(folder: Path, towers: Sequence[Sequence[str]], goal: Sequence[str]) -> SearchResult[Action]:
    """Plan for a tower of blocks that stand in other towers; blocks are listed from the bottom."""
    initial = ["(hand-empty)"]
    for tower in towers:
        initial += [f"(on-table {tower[0]})", f"(clear {tower[-1]})"]
        initial += [f"(on {upper} {lower})" for lower, upper in pairwise(tower)]
    conditions = [f"(on {upper} {lower})" for lower, upper in pairwise(goal)]
    Random(0).shuffle(conditions)
    problem = (
        f"(define (problem tower) (:domain blocksworld) (:objects {' '.join(sorted(goal))})"
        f" (:init {' '.join(initial)}) (:goal (and {' '.join(conditions)})))"
    )
    return solve(BLOCKS, problem, folder)


@pytest.mark.parametrize("size", [8, 16, 24])
@pytest.mark.parametrize("start", ["reversed", "shuffled", "two towers", "on the table"])
def test_a_tower_takes_few_states_for_each_block(size: int, start: str, tmp_path: Path) -> None:
    goal = [f"b{number:02}" for number in range(size)]
    blocks = Random(1).sample(goal, size)
    towers = {
        "reversed": [goal[::-1]],
        "shuffled": [blocks],
        "two towers": [blocks[: size // 2], blocks[size // 2 :]],
        "on the table": [[name] for name in blocks],
    }
    found = restack(tmp_path, towers[start], goal)
    assert found.end is SearchEndReason.SOLVED
    assert found.states <= 12 * size
    assert len(found.plan) <= 5 * size


def test_a_goal_that_holds_too_early_is_undone(tmp_path: Path) -> None:
    found = restack(tmp_path, [["b", "a"], ["c"]], ["c", "b", "a"])
    assert [action.operator for action in found.plan] == [
        *("unstack", "put-down"),
        *("pick-up", "stack"),
        *("pick-up", "stack"),
    ]
    assert found.states < 20


def test_a_search_returns_to_dead_ends(tmp_path: Path) -> None:
    """The shortest way to free a hoist is to put its crate back. This leads nowhere, so a truck must come."""
    problem = (
        "(define (problem pile) (:domain depot)"
        " (:objects t - truck h - hoist near far - place s - pallet c0 c1 - crate)"
        " (:init (truck-at t far) (hoist-at h near) (free h) (at s near) (at c0 near) (at c1 near)"
        " (on c0 s) (on c1 c0) (clear c1))"
        " (:goal (on c1 s)))"
    )
    found = solve(DEPOT, problem, tmp_path, Limits(30, thorough=False))
    assert [action.operator for action in found.plan] == [
        *("lift", "drive", "load"),
        *("lift", "load"),
        *("unload", "drop"),
    ]
