from __future__ import annotations

from eai.logic.formula import Atom, Constant, Not
from eai.planning.additive_heuristic import AdditiveHeuristic
from eai.planning.greedy_search import GreedySearch
from eai.planning.planner import _GoalAgenda
from eai.planning.search import Limits, SearchEndReason, SearchNode
from eai.planning.subgoal import Subgoal
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from world import toy

START: PlanNode = SearchNode(toy.initial())
INDEX = START.state.scene.index
HEURISTIC = AdditiveHeuristic(toy.DOMAIN)
SUCCESSORS = SuccessorGenerator(toy.DOMAIN, tuple(range(len(INDEX))))
FEW = Limits(50, thorough=False)


def subgoal(predicate: str, *names: str) -> Subgoal:
    return Subgoal(Atom(predicate, tuple(Constant(name) for name in names)), {}, True)


LIT, HELD, CARRIED = subgoal("lit", "lamp"), subgoal("holding", "red"), subgoal("at", "red", "shed")
FIXED = subgoal("at", "lamp", "hall")


def agenda(*goals: Subgoal, states: int = 1_000) -> _GoalAgenda:
    return _GoalAgenda(GreedySearch(HEURISTIC, SUCCESSORS, Limits(states)), goals, START.state.scene)


def steps_to(node: PlanNode | None) -> list[str]:
    names = list(INDEX)
    return [] if node is None else [f"{a.operator} {names[a.arguments[0]]}" for a in node.list_actions()]


def test_the_cheapest_goal_is_reached_first_and_kept() -> None:
    goals = agenda(LIT, HELD)
    first = goals.reach_next_goal(START, FEW)
    assert steps_to(first) == ["LIFT red"]
    assert first is not None
    assert steps_to(goals.reach_next_goal(first, FEW)) == ["LIFT red", "GO shed", "PRESS lamp"]


def test_a_goal_that_failed_comes_first_the_next_time() -> None:
    goals = agenda(HELD, FIXED)
    held = goals.reach_next_goal(START, FEW)
    assert held is not None
    assert goals.reach_next_goal(held, FEW) is None
    assert goals.mark_newly_failed_goals_as_hard()
    assert goals.reach_next_goal(held, FEW) is None
    assert not goals.mark_newly_failed_goals_as_hard(), "nothing new"


def test_a_search_ends_at_its_target_or_at_its_limit() -> None:
    search = GreedySearch(HEURISTIC, SUCCESSORS, Limits(1_000))
    dropped = (CARRIED, HELD.negated, LIT)
    found = search.search(START, dropped, 0, FEW)
    assert isinstance(found, SearchNode)
    assert len(found.list_actions()) == 4
    assert search.search(START, dropped, 0, Limits(2)) is SearchEndReason.STATES
    assert search.search(START, (FIXED,), 0, Limits(1_000)) is SearchEndReason.UNREACHABLE
    for limits in (Limits(0), Limits(1_000, looks=3)):
        assert (
            GreedySearch(HEURISTIC, SUCCESSORS, limits).search(START, dropped, 0, FEW)
            is SearchEndReason.STATES
        )


def test_a_negated_atom_may_be_a_goal() -> None:
    away = Subgoal(Not(Atom("at", (Constant("robot"), Constant("hall")))), {}, True)
    assert steps_to(agenda(away).reach_next_goal(START, FEW)) == ["GO shed"]
