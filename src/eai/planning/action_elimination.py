"""Action elimination (Nakhost and Mueller 2010): a plan without what it can do without."""

from __future__ import annotations

from collections.abc import Callable

from eai.planning.successor_generator import Node, SuccessorGenerator


def without_needless_actions(
    successors: SuccessorGenerator, start: Node, end: Node, reached: Callable[[Node], bool]
) -> Node:
    """The end of a plan from the start that still ends as it must, and needs all of its actions.

    Each action in turn is left out, and with it those after it that are impossible then, until all are
    needed.
    """
    way = _way(start, end)
    position, needed = 0, 0
    while needed < len(way):
        position %= len(way)
        node = start if position == 0 else way[position - 1]
        for later in way[position + 1 :]:
            if later.action is not None:
                node = successors.successor(node, later.action) or node
        if reached(node):
            end, way, needed = node, _way(start, node), 0
        else:
            position, needed = position + 1, needed + 1
    return end


def _way(start: Node, end: Node) -> list[Node]:
    """The nodes that actions lead to, one after the other, from the start to the end."""
    found: list[Node] = []
    node: Node | None = end
    while node is not None and node is not start:
        found.append(node)
        node = node.parent
    return found[::-1]
