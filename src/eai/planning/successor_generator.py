"""The successor generator: what has been done on the way to a state, and what can be done in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.operator import Operator
from eai.world.state import State

CarryOut: TypeAlias = Callable[[Action, State], Sequence[Action]]
"""What is done when an action is chosen in a state; nothing, if it cannot be chosen."""


class Node(NamedTuple):
    """A state that was reached, with the number of action goals taken on the way, and the way."""

    state: State
    taken: int = 0
    depth: int = 0
    parent: Node | None = None
    action: Action | None = None

    def plan(self) -> list[Action]:
        """The actions that led here."""
        actions: list[Action] = []
        node: Node | None = self
        while node is not None and node.action is not None:
            actions.append(node.action)
            node = node.parent
        return actions[::-1]


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

    def successor(self, node: Node, action: Action) -> Node | None:
        """The node after an action is chosen, or None if it cannot be carried out without a fault."""
        state, taken = node.state, node.taken
        steps = self._carry_out(action, state)
        for step in steps:
            compiled = self._domain.compiled[step.operator]
            binding = compiled.bind(state, step.arguments)
            if not compiled.is_possible(state, binding):
                return None
            if taken < len(self.goals) and step.operator in self.goals[taken]:
                taken += 1
            state = compiled.apply(state, binding)
        return Node(state, taken, node.depth + 1, node, action) if steps else None

    def applicable(self, node: Node) -> Iterator[Action]:
        """All applicable actions: those that no check forbids in a node."""
        for operator in self._domain.operators:
            yield from applicable_actions(self._domain, operator, node.state, self.objects)


def applicable_actions(
    domain: Domain, operator: Operator, state: State, objects: Sequence[int]
) -> Iterator[Action]:
    """The actions by an operator on some objects that no check forbids in a state."""
    compiled = domain.compiled[operator.name]
    for arguments in domain.applicability[operator.name].arguments(state, objects):
        if not compiled.tries or compiled.is_possible(state, compiled.bind(state, arguments)):
            yield Action(operator.name, arguments)
