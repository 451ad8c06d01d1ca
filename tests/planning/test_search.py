from __future__ import annotations

import pytest

from eai.planning.search import OpenList, SearchEffort, SearchEndReason, SearchNode, run_best_first_search

GRAPH = {"a": {"b": 1, "c": 5}, "b": {"c": 1, "d": 9}, "c": {"d": 1}, "d": {}, "e": {}}


def find_path(goal: str, limit: float = 10) -> SearchNode[str, str] | SearchEndReason:
    """Return the cheapest path, by uniform-cost search."""
    effort, costs = SearchEffort(limit), {"a": 0}
    waiting: OpenList[SearchNode[str, str]] = OpenList()
    waiting.push(SearchNode("a"), 0)

    def visit(node: SearchNode[str, str]) -> SearchNode[str, str] | SearchEndReason | None:
        if node.state == goal:
            return node
        effort.used += 1
        for state, price in GRAPH[node.state].items():
            cost = costs[node.state] + price
            if cost < costs.get(state, 100):
                costs[state] = cost
                waiting.push(SearchNode(state, 0, node.depth + 1, node, (state,)), cost)
        return SearchEndReason.STATES if effort.is_limit_reached else None

    return run_best_first_search(waiting.pop, visit)


def test_the_cheapest_path_comes_first_and_its_node_returns_it() -> None:
    found = find_path("d")
    assert isinstance(found, SearchNode)
    assert (found.list_actions(), found.depth) == (("b", "c", "d"), 3)
    assert [node.state for node in found.list_path_nodes()] == ["a", "b", "c", "d"]


@pytest.mark.parametrize(("limit", "end"), [(10, SearchEndReason.UNREACHABLE), (2, SearchEndReason.STATES)])
def test_a_search_returns_the_reason_why_it_found_no_goal(limit: int, end: SearchEndReason) -> None:
    assert find_path("e", limit) is end


def test_several_actions_may_lead_to_a_node() -> None:
    start: SearchNode[int, str] = SearchNode(0)
    node = SearchNode(3, 0, 3, SearchNode(1, 0, 1, start, ("one",)), ("two", "three"))
    assert node.list_actions() == ("one", "two", "three")
    assert start.list_actions() == ()
