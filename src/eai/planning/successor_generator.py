"""The successor generator: what has been done on the way to a state, and what can be done in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from eai.planning.search import Node
from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.operator import Operator
from eai.world.state import State

CarryOut: TypeAlias = Callable[[Action, State], Sequence[Action]]
"""The actions carried out when one is chosen in a state; none, if it cannot be chosen."""

PlanNode: TypeAlias = Node[State, Action]
"""A state of the world; ``met`` is the number of action goals taken on the way."""


class SuccessorGenerator:
    """Gives the states that one action leads to from a state, and the actions that are applicable in it.

    Args:
        domain: the domain.
        carry_out: what is done when an action is chosen.
        objects: what actions may be about, by index.
        goals: operators to be taken, one after the other; each entry lists alternatives.
    """

    def __init__(
        self, domain: Domain, carry_out: CarryOut, objects: Sequence[int], goals: Sequence[Sequence[str]]
    ) -> None:
        self._domain = domain
        self._carry_out = carry_out
        self.objects = objects
        self.goals = goals

    def successor(self, node: PlanNode, action: Action) -> PlanNode | None:
        """The node after an action is chosen, or None if it cannot be carried out without a fault."""
        state, taken = node.state, node.met
        steps = self._carry_out(action, state)
        for step in steps:
            compiled = self._domain.compiled[step.operator]
            binding = compiled.bind(state, step.arguments)
            if not compiled.is_possible(state, binding):
                return None
            if taken < len(self.goals) and step.operator in self.goals[taken]:
                taken += 1
            state = compiled.apply(state, binding)
        return Node(state, taken, node.depth + 1, node, (action,)) if steps else None

    def applicable(self, node: PlanNode) -> Iterator[Action]:
        """All applicable actions: those that no check forbids in a node."""
        for operator in self._domain.operators:
            yield from applicable_actions(self._domain, operator, node.state, self.objects)

    def without_needless(
        self, start: PlanNode, end: PlanNode, reached: Callable[[PlanNode], bool]
    ) -> PlanNode:
        """The end of a plan from the start that still ends as it must, and needs all of its actions.

        Action elimination (Nakhost and Mueller 2010): each action in turn is left out, and with it those
        after it that are impossible then, until all are needed.
        """
        way = end.way()[start.depth + 1 :]
        position, needed = 0, 0
        while needed < len(way):
            position %= len(way)
            node = start if position == 0 else way[position - 1]
            for later in way[position + 1 :]:
                for action in later.actions:
                    node = self.successor(node, action) or node
            if reached(node):
                end, way, needed = node, node.way()[start.depth + 1 :], 0
            else:
                position, needed = position + 1, needed + 1
        return end


def applicable_actions(
    domain: Domain, operator: Operator, state: State, objects: Sequence[int]
) -> Iterator[Action]:
    """The actions by an operator on some objects that no check forbids in a state."""
    compiled = domain.compiled[operator.name]
    for arguments in domain.applicability[operator.name](state, objects):
        if not compiled.tries or compiled.is_possible(state, compiled.bind(state, arguments)):
            yield Action(operator.name, arguments)
