"""Programs: subgoals as instructions for the search that carries them out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from eai.logic.formula import TRUE
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.state import State

Plan: TypeAlias = Sequence[Action]

MAX_ACTIONS = 2
"""How many actions carry out one subgoal at most, movement included."""


TOO_FAR = Check(
    TRUE,
    FaultKind.MISSING_STEP,
    f"it takes more than {MAX_ACTIONS} actions: what lies between is a subgoal, too",
    id="too_many_actions",
)
"""The offence of a subgoal that takes more actions than it may."""


class Found(NamedTuple):
    """The actions to take for a subgoal in a state.

    Attributes:
        plans: the plans for it, each to be tried; none if nothing is to be done there.
        effort: how many actions were applied to states to find them.
        refused: why nothing is done, and the subgoal fails; None where it does not.
        has_failed: whether nothing brings it about, and not for the kind of its objects.
    """

    plans: Sequence[Plan]
    effort: int = 0
    refused: Check | None = None
    has_failed: bool = False


Plans: TypeAlias = Callable[[State], Found]
"""The actions to take for a subgoal in a state."""


class Do(NamedTuple):
    """Carry out a subgoal by one of the plans for it in the state at hand; if there is none, do nothing.

    No more than ``most`` actions are executed for one subgoal, if that is given.
    """

    plans: Plans
    subgoal: int
    then: int
    most: int | None = None


class Held(NamedTuple):
    """Go on one way if a subgoal holds already, and another way if not; ``effort`` is what the test costs."""

    holds: Callable[[State], bool]
    subgoal: int
    then: int
    otherwise: int
    effort: int


class Require(NamedTuple):
    """Go on only if a subgoal holds; ``check`` says what is wrong if not, ``effort`` what the test costs."""

    holds: Callable[[State], bool]
    check: Check
    subgoal: int
    then: int
    effort: int = 1


class Split(NamedTuple):
    """Go on with a subgoal in each of several ways, those with greater numbers first."""

    targets: tuple[int, ...]
    subgoal: int


class End(NamedTuple):
    """All subgoals are carried out."""


Instruction: TypeAlias = Do | Held | Require | Split | End
Program: TypeAlias = Sequence[Instruction]
"""Instructions that lead to earlier ones only; the last one is the first to run, number 0 is the `End`."""
