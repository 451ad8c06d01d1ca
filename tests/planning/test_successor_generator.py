from __future__ import annotations

from eai.planning.planner import alone
from eai.planning.successor_generator import Moves, Node, possible_actions
from eai.world.execution import Action
from world import toy

START = Node(toy.initial())
INDEX = START.state.scene.index
EVERYTHING = tuple(range(len(INDEX)))
MOVES = Moves(toy.DOMAIN, alone, EVERYTHING, (("PRESS",), ("LIFT", "DROP")))


def action(operator: str, name: str) -> Action:
    return Action(operator, (INDEX[name],))


def walk(*actions: Action) -> Node:
    node = START
    for each in actions:
        after = MOVES.after(node, each)
        assert after is not None
        node = after
    return node


def test_a_node_knows_its_way_and_the_action_goals_on_it() -> None:
    plan = [action("LIFT", "red"), action("GO", "shed"), action("PRESS", "lamp"), action("DROP", "red")]
    node = walk(*plan)
    assert (node.plan(), node.depth, node.taken) == (plan, 4, 2), "the first LIFT came before its turn"
    assert MOVES.after(START, action("PRESS", "lamp")) is None


def test_all_that_is_possible_is_found() -> None:
    possible = [action("GO", "shed"), action("LIFT", "red")]
    assert list(MOVES.possible(START)) == possible
    assert list(possible_actions(toy.DOMAIN, toy.GO, START.state, [INDEX["hall"]])) == []


def test_what_is_not_needed_is_left_out_with_what_hangs_on_it() -> None:
    end = walk(
        action("LIFT", "red"),
        action("DROP", "red"),
        action("GO", "shed"),
        action("LIFT", "blue"),
        action("PRESS", "lamp"),
    )
    lit = MOVES.without_detours(START, end, lambda node: node.state.has("lit", INDEX["lamp"]))
    assert lit.plan() == [action("GO", "shed"), action("PRESS", "lamp")]
    assert MOVES.without_detours(START, end, lambda node: True).plan() == []
