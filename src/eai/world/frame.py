"""Frames of compiled formulas. A frame has a numbered slot for the object of each variable and constant."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from eai.base.errors import DomainError, InputError
from eai.logic.formula import Constant, Term, Variable
from eai.world.relation import ObjectMask
from eai.world.state import Scene, State

ObjectBySlot: TypeAlias = list[int]
"""List of object indices, one for each slot of a frame (variable or constant); slot 0 holds the agent."""

SlotByVariable: TypeAlias = Mapping[str, int]
"""Mapping from the name of a variable to the number of its slot (its position in a binding)."""

ConditionTest: TypeAlias = Callable[[State, ObjectBySlot], bool]

ObjectFilter: TypeAlias = Callable[[State, ObjectBySlot, ObjectMask], ObjectMask]
"""Function of a state, a binding and objects. It returns those of the objects that make a formula true."""

AGENT = Constant("agent")
"""Name that stands for the acting object in any formula of a domain."""

UNBOUND = -1
"""Value of a slot (a position in a binding) that holds no object."""


class SlotAllocator:
    """Numbers the slots of a frame: one for each variable and constant of the compiled formulas.

    The agent has slot 0; then come the parameters, then all other variables and constants.
    """

    def __init__(self, parameters: Sequence[Variable] = ()) -> None:
        self._first_other = 1 + len(parameters)
        self._others: list[int] = []  # UNBOUND for each constant and each variable that is not a parameter
        self._constants: dict[str, int] = {}
        self.scope: dict[str, int] = {v.name: i + 1 for i, v in enumerate(parameters)}
        self.mentions_agent = False

    def add_slot(self) -> int:
        """Add a slot (a position in each binding), and return its number."""
        self._others.append(UNBOUND)
        return self._first_other + len(self._others) - 1

    def find_slot(self, term: Term, scope: SlotByVariable) -> int:
        """Return the index of the slot that holds the object of a term.

        Raises:
            DomainError: the term is a variable that is not in ``scope``.
        """
        if isinstance(term, Constant):
            if term == AGENT:
                self.mentions_agent = True
                return 0
            if term.name not in self._constants:
                self._constants[term.name] = self.add_slot()
            return self._constants[term.name]
        if term.name not in scope:
            raise DomainError(f"variable {term.name} is not bound: make it a parameter, or quantify over it")
        return scope[term.name]

    def bind_arguments(self, scene: Scene, arguments: Sequence[int]) -> ObjectBySlot:
        """Return a binding in which the slots of the parameters hold these arguments.

        The slots of constants hold the objects that the constants name. All other slots hold no object.

        Raises:
            InputError: a formula mentions the agent, but the scene has no agent.
        """
        if scene.agent is None and self.mentions_agent:
            raise InputError("the scene has no agent, but the domain needs one: write Scene(..., agent=NAME)")
        binding = [UNBOUND if scene.agent is None else scene.agent, *arguments, *self._others]
        if self._constants:
            for name, slot in self._constants.items():
                binding[slot] = scene.index[name]
        return binding
