from __future__ import annotations

from eai.logic.formula import Atom, Constant, Not
from eai.planning.additive_heuristic import Regression
from eai.planning.agenda import Agenda
from eai.planning.best_first import BestFirst, Effort, Target
from eai.planning.planner import alone
from eai.planning.successor_generator import Moves, Node
from eai.planning.wanted import Wanted
from world import toy

START = Node(toy.initial())
INDEX = START.state.scene.index
REGRESSION = Regression(toy.DOMAIN)
MOVES = Moves(toy.DOMAIN, alone, tuple(range(len(INDEX))), ())
EFFORT = Effort(50, complete=False)


def wanted(predicate: str, *names: str) -> Wanted:
    return Wanted(Atom(predicate, tuple(Constant(name) for name in names)), {}, True)


LIT, HELD, CARRIED = wanted("lit", "lamp"), wanted("holding", "red"), wanted("at", "red", "shed")
FIXED = wanted("at", "lamp", "hall")


def agenda(*goals: Wanted, states: int = 1_000) -> Agenda:
    return Agenda(REGRESSION, MOVES, BestFirst(REGRESSION, MOVES, states), goals)


def told(node: Node | None) -> list[str]:
    names = list(INDEX)
    return [] if node is None else [f"{a.operator} {names[a.arguments[0]]}" for a in node.plan()]


def test_the_nearest_goal_comes_first_and_is_kept() -> None:
    goals = agenda(LIT, HELD)
    first = goals.advance(START, EFFORT)
    assert told(first) == ["LIFT red"]
    assert first is not None
    assert told(goals.advance(first, EFFORT)) == ["LIFT red", "GO shed", "PRESS lamp"]


def test_what_could_not_be_reached_comes_first_the_next_time() -> None:
    goals = agenda(HELD, FIXED)
    held = goals.advance(START, EFFORT)
    assert held is not None
    assert goals.advance(held, EFFORT) is None
    assert goals.learn()
    assert goals.advance(held, EFFORT) is None
    assert not goals.learn(), "nothing new"


def test_a_search_ends_at_its_target_or_with_its_effort() -> None:
    search = BestFirst(REGRESSION, MOVES, 1_000)
    dropped = Target((CARRIED, HELD.negated, LIT), 0)
    found = search.search(START, dropped, EFFORT)
    assert found.node is not None
    assert len(found.node.plan()) == 4
    assert search.search(START, dropped, Effort(2, complete=True)) == (None, False)
    assert search.search(START, Target((FIXED,), 0), Effort(1_000, complete=True)).exhausted
    assert BestFirst(REGRESSION, MOVES, 0).search(START, dropped, EFFORT) == (None, False)


def test_a_denied_atom_is_a_goal_too() -> None:
    away = Wanted(Not(Atom("at", (Constant("robot"), Constant("hall")))), {}, True)
    assert told(agenda(away).advance(START, EFFORT)) == ["GO shed"]
