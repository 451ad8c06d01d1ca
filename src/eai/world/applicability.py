"""Applicability: with which objects no check of an operator fails."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from eai.logic.formula import And, Formula
from eai.logic.traversal import free_variables
from eai.world.condition import Conditions
from eai.world.frame import UNBOUND, Binding, Extension, Frame, Truth
from eai.world.operator import Operator
from eai.world.relation import mask_of
from eai.world.state import State
from eai.world.vocabulary import Vocabulary


class Applicability:
    """Finds the arguments with which no check of an operator fails, one parameter after the other.

    A check is asked as soon as the last of the parameters that it is about has its turn, of all objects at
    once. What the operator tries is not asked.
    """

    def __init__(self, operator: Operator, vocabulary: Vocabulary) -> None:
        names = [parameter.name for parameter in operator.parameters]
        ready: list[list[Formula]] = [[] for _ in range(len(names) + 1)]
        for check in operator.checks:
            about = free_variables(check.condition)
            last = max([i for i, name in enumerate(names, 1) if name in about], default=0)
            ready[last].append(check.condition)
        self._frame = Frame(operator.parameters)
        conditions = Conditions(vocabulary, self._frame)
        self._first: Truth = conditions.truth(And(tuple(ready[0])))
        self._parameters: Sequence[Extension] = [
            conditions.extension(And(tuple(asked)), slot, self._frame.scope)
            for slot, asked in enumerate(ready[1:], 1)
        ]

    def arguments(self, state: State, objects: Sequence[int]) -> Iterator[tuple[int, ...]]:
        """The arguments among some objects, in the order of `itertools.product`."""
        binding = self._frame.bind(state.scene, [UNBOUND] * len(self._parameters))
        if self._first(state, binding):
            yield from self._complete(state, binding, 1, objects, mask_of(objects))

    def _complete(
        self, state: State, binding: Binding, slot: int, objects: Sequence[int], among: int
    ) -> Iterator[tuple[int, ...]]:
        """The arguments that begin as those of a binding before a slot."""
        if slot > len(self._parameters):
            yield tuple(binding[1:slot])
            return
        matching = self._parameters[slot - 1](state, binding, among)
        for index in objects:
            if matching >> index & 1:
                binding[slot] = index
                yield from self._complete(state, binding, slot + 1, objects, among)
        binding[slot] = UNBOUND
