"""Programs: subgoals as instructions for the search that carries them out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from eai.world.execution import Action
from eai.world.operator import Check
from eai.world.state import State

Plan: TypeAlias = Sequence[Action]

Plans: TypeAlias = Callable[[State], Sequence[Plan]]
"""The plans for a subgoal in a state, each to be tried; none if nothing is to be done there."""


class Do(NamedTuple):
    """Carry out a subgoal by one of the plans for it in the state at hand; if there is none, do nothing."""

    plans: Plans
    subgoal: int
    then: int


class Require(NamedTuple):
    """Go on only if a subgoal holds that no action brings about; ``check`` says what is wrong if not."""

    holds: Callable[[State], bool]
    check: Check
    subgoal: int
    then: int


class Split(NamedTuple):
    """Go on in each of several ways."""

    targets: tuple[int, ...]


class Halt(NamedTuple):
    """End the whole search: the reference would abort."""

    reason: str


class End(NamedTuple):
    """All subgoals are carried out."""


Instruction: TypeAlias = Do | Require | Split | Halt | End
Program: TypeAlias = Sequence[Instruction]
"""Instructions that lead to earlier ones only; the last one is the first to run, number 0 is the `End`."""
