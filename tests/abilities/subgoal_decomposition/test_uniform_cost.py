"""Movement paths: the shortest come first, no state comes twice, and the budget limits their length."""

from __future__ import annotations

import pytest

import eai.world as w
from eai.abilities.subgoal_decomposition.repertoire import CandidateAction, OperatorIndex
from eai.abilities.subgoal_decomposition.uniform_cost import (
    MovementPath,
    PermittedActions,
    SearchGoal,
    _find_best_failed_plan,
    _MovementPathFinder,
    _UniformCostSearch,
)
from eai.planning.search import SearchEffort
from eai.world.action import Action
from eai.world.execution import execute_plan
from eai.world.state import State
from world import toy

UP = w.Predicate("up", 1)
STAND = w.Operator(
    "STAND",
    (),
    (w.additional_step(~UP(w.AGENT), "it stands"),),
    (w.Add(UP(w.AGENT)),),
    role=w.OperatorRole.MOVEMENT,
)
STRIDE = w.Operator(
    "STRIDE",
    (toy.X,),
    (w.missing_step(UP(w.AGENT), "it sits"), *toy.GO.checks),
    toy.GO.effects,
    role=w.OperatorRole.MOVEMENT,
)
VOCABULARY = w.Vocabulary((*toy.VOCABULARY.predicates, UP), toy.VOCABULARY.derived)
DOMAIN = w.Domain("toy", VOCABULARY, (STRIDE, STAND))
NAMES = {"robot": "robot", "hall": "place", "shed": "place", "attic": "place"}
SCENE = w.Scene(VOCABULARY, [w.WorldObject(*each) for each in NAMES.items()], agent=0)
SITTING = SCENE.state([("at", (0, SCENE.index["hall"]))])
ACTIONS = [
    Action("STAND", ()),
    *(Action("STRIDE", (SCENE.index[name],)) for name in ("hall", "shed", "attic")),
]


def movement(allowed: int) -> tuple[_MovementPathFinder, SearchEffort]:
    known, effort = OperatorIndex(DOMAIN).operators, SearchEffort(allowed)
    moves = [CandidateAction.create(action, known[action.operator], SITTING) for action in ACTIONS]
    return _MovementPathFinder(moves, effort), effort


def written(way: MovementPath) -> str:
    return ", ".join(
        " ".join([a.operator, *(SCENE.objects[i].name for i in a.arguments)]) for a in way.list_actions()
    )


@pytest.mark.parametrize(
    ("before", "ways"),
    [
        # Each operator is used once: the agent neither comes back nor makes a detour.
        ([], ["STAND", "STAND, STRIDE shed", "STAND, STRIDE attic"]),
        (["STAND"], ["STRIDE shed", "STRIDE attic"]),
    ],
)
@pytest.mark.parametrize("allowed", [0, 1, 2, 3, 9])
def test_movement_paths_are_listed_from_the_shortest(
    before: list[str], ways: list[str], allowed: int
) -> None:
    start = execute_plan(DOMAIN, SITTING, [Action(name, ()) for name in before]).final_state
    moving, effort = movement(allowed)
    found = list(moving.list_paths(start))
    assert [written(way) for way in found] == ways[:allowed]
    assert effort.used == len(found), "an action for each, and no others"
    assert all(execute_plan(DOMAIN, start, way.list_actions()).final_state == way.state for way in found)


def test_movement_paths_are_explored_once_and_lazily() -> None:
    moving, effort = movement(9)
    first = next(iter(moving.list_paths(SITTING)))
    assert effort.used == 1
    assert next(iter(moving.list_paths(SITTING))) is first
    assert effort.used == 1
    assert list(moving.list_paths(SITTING)) == list(moving.list_paths(SITTING))
    assert effort.used == 3


def test_a_domain_without_movement_has_no_movement_paths() -> None:
    assert not _MovementPathFinder([], SearchEffort(9))
    assert movement(0)[0]


KNOWN = OperatorIndex(toy.DOMAIN).operators
MOST = 200_000


@pytest.mark.parametrize("lamps", [10, 300])
def test_few_parts_are_tested_and_the_effort_is_counted(lamps: int) -> None:
    """The goal requires all lamps to be lit. One action lights one lamp."""
    things = [w.WorldObject("robot", "robot"), w.WorldObject("hall", "place")]
    things += [w.WorldObject(f"lamp_{i}", "lamp") for i in range(lamps)]
    scene = w.Scene(toy.VOCABULARY, things, agent=0)
    start = scene.state(("at", (i, 1)) for i in range(lamps + 2) if i != 1)
    everything, tested = (1 << lamps) - 1, [0]

    def met(state: State, touched: int, before: int) -> int:
        tested[0] += touched.bit_count()
        return before & ~touched | sum(1 << i for i in range(lamps) if touched >> i & state.has("lit", i + 2))

    press = [
        CandidateAction.create(Action("PRESS", (i + 2,)), KNOWN["PRESS"], start).with_literal_masks(
            1 << i, everything
        )
        for i in range(lamps)
    ]
    goal = SearchGoal(0, met, everything, lambda _: False, ())
    search = _UniformCostSearch(goal, PermittedActions(press, (), (), (), 0), 600)
    assert search.find_shortest_plans(start) == []
    tested[0] = 0
    found = _find_best_failed_plan([search])
    assert found.failed_check is not None or found.plans
    assert 0 < tested[0] <= MOST
    assert found.effort >= tested[0] // 32, "effort stands for tests, too"
