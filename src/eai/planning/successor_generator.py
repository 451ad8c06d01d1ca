"""The successor generator: the actions that are applicable in a state, and the states after these actions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from eai.planning.search import SearchEffort, SearchNode
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.operator import Operator
from eai.world.state import State

ACTION_BINDINGS = 10
"""Effort of one tried action in a search with limited effort. One tried parameter value has effort 1.

An action takes more time to try than a value.
"""

PlanNode: TypeAlias = SearchNode[State, Action]
"""Node of a search for a plan; ``met`` is the number of required operators that the path has executed."""


class SuccessorGenerator:
    """Generates applicable actions, and the states after the actions.

    Args:
        domain: the domain.
        objects: the objects that actions may use, by index.
        goals: operators that a plan must contain, one after the other. Each entry lists the names of
            alternative operators.
        allowed: function that tests whether an action may lead to a state; None allows all states.
    """

    def __init__(
        self,
        domain: Domain,
        objects: Sequence[int],
        goals: Sequence[Sequence[str]] = (),
        allowed: Callable[[State], bool] | None = None,
    ) -> None:
        self._domain = domain
        self._allowed = allowed
        self.objects = objects
        self.goals = goals

    def make_successor(self, node: PlanNode, action: Action) -> PlanNode | None:
        """Return the search node after an action; None for an impossible action or a forbidden state."""
        compiled = self._domain.compiled_operators[action.operator]
        binding = compiled.bind(node.state, action.arguments)
        if not compiled.is_possible(node.state, binding):
            return None
        after = compiled.apply(node.state, binding)
        if self._allowed is not None and not self._allowed(after):
            return None
        counts = node.met < len(self.goals) and action.operator in self.goals[node.met]
        return SearchNode(after, node.met + counts, node.depth + 1, node, (action,))

    def generate_applicable_actions(
        self, node: PlanNode, binding_effort: SearchEffort | None = None
    ) -> Iterator[Action]:
        """Yield all actions that are possible in a node's state, up to the limit of ``binding_effort``."""
        for operator in self._domain.operators:
            yield from generate_applicable_actions_of_operator(
                self._domain, operator, node.state, self.objects, binding_effort
            )

    def remove_needless_actions(
        self, start: PlanNode, end: PlanNode, reached: Callable[[PlanNode], bool]
    ) -> PlanNode:
        """Return the last node of a plan without needless actions. The shorter plan still reaches the goal.

        This is action elimination (Nakhost and Mueller 2010). Each action in turn is left out, together with
        the later actions that become impossible, until the goal needs all remaining actions.
        """
        path = end.list_path_nodes()[start.depth + 1 :]
        position, needed = 0, 0
        while needed < len(path):
            position %= len(path)
            node = start if position == 0 else path[position - 1]
            for later in path[position + 1 :]:
                for action in later.actions:
                    node = self.make_successor(node, action) or node
            if reached(node):
                end, path, needed = node, node.list_path_nodes()[start.depth + 1 :], 0
            else:
                position, needed = position + 1, needed + 1
        return end


def generate_applicable_actions_of_operator(
    domain: Domain,
    operator: Operator,
    state: State,
    objects: Sequence[int],
    binding_effort: SearchEffort | None = None,
) -> Iterator[Action]:
    """Yield the actions by an operator that are possible in a state.

    Args:
        domain: the domain.
        operator: the operator.
        state: the state.
        objects: the objects that actions may use, by index.
        binding_effort: counter of values tried for parameters. Each action counts as `ACTION_BINDINGS` more
            values. If the limit of the counter is exceeded, no more actions follow. None for no limit.
    """
    binding_effort = binding_effort or SearchEffort()
    compiled = domain.compiled_operators[operator.name]
    for arguments in domain.argument_finder_by_operator[operator.name](
        state, objects, binding_effort.spend_and_check_limit
    ):
        if binding_effort.spend_and_check_limit(ACTION_BINDINGS):
            return
        if not compiled.alternatives or compiled.is_possible(state, compiled.bind(state, arguments)):
            yield Action(operator.name, arguments)
