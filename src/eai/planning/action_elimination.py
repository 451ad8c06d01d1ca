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
    plan = end.plan()
    position, needed = 0, 0
    while needed < len(plan):
        position %= len(plan)
        node = start
        for i, action in enumerate(plan):
            after = successors.successor(node, action) if i != position else None
            node = node if after is None else after
        if reached(node):
            end, plan, needed = node, node.plan(), 0
        else:
            position, needed = position + 1, needed + 1
    return end
