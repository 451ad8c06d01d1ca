from __future__ import annotations

from eai.planning.search import SearchNode
from eai.planning.successor_generator import (
    PlanNode,
    SuccessorGenerator,
    generate_applicable_actions_of_operator,
)
from eai.world.action import Action
from world import toy

START: PlanNode = SearchNode(toy.initial())
INDEX = START.state.scene.index
EVERYTHING = tuple(range(len(INDEX)))
SUCCESSORS = SuccessorGenerator(toy.DOMAIN, EVERYTHING, (("PRESS",), ("LIFT", "DROP")))


def action(operator: str, name: str) -> Action:
    return Action(operator, (INDEX[name],))


def walk(*actions: Action) -> PlanNode:
    node = START
    for each in actions:
        after = SUCCESSORS.make_successor(node, each)
        assert after is not None
        node = after
    return node


def test_a_node_has_its_path_and_the_action_goals_taken_on_it() -> None:
    plan = [action("LIFT", "red"), action("GO", "shed"), action("PRESS", "lamp"), action("DROP", "red")]
    node = walk(*plan)
    assert (node.list_actions(), node.depth, node.met) == (tuple(plan), 4, 2), (
        "the first LIFT came before its turn"
    )
    assert SUCCESSORS.make_successor(START, action("PRESS", "lamp")) is None


def test_all_applicable_actions_are_found() -> None:
    applicable = [action("GO", "shed"), action("LIFT", "red")]
    assert list(SUCCESSORS.generate_applicable_actions(START)) == applicable
    assert (
        list(generate_applicable_actions_of_operator(toy.DOMAIN, toy.GO, START.state, [INDEX["hall"]])) == []
    )


def test_a_needless_action_is_left_out_with_the_actions_that_depend_on_it() -> None:
    end = walk(
        action("LIFT", "red"),
        action("DROP", "red"),
        action("GO", "shed"),
        action("LIFT", "blue"),
        action("PRESS", "lamp"),
    )
    lit = SUCCESSORS.remove_needless_actions(START, end, lambda node: node.state.has("lit", INDEX["lamp"]))
    assert lit.list_actions() == (action("GO", "shed"), action("PRESS", "lamp"))
    assert SUCCESSORS.remove_needless_actions(START, end, lambda node: True).list_actions() == ()
