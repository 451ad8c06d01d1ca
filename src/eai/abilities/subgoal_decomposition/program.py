"""Programs: the subgoals of an answer as instructions for the search, or what keeps them from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from eai.abilities.subgoal_decomposition.verdict import SubgoalCategory
from eai.abilities.verdict import ErrorReport, Span
from eai.logic.formula import TRUE, Formula
from eai.logic.signature import Misuse
from eai.world.action import Action
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.state import State

ActionSequence: TypeAlias = Sequence[Action]

MAX_ACTIONS = 2
"""How many actions carry out one subgoal at most, movement included."""


TOO_FAR = Check(
    TRUE,
    FaultKind.MISSING_STEP,
    f"it takes more than {MAX_ACTIONS} actions: the states in between must be subgoals, too",
    id="too_many_actions",
)
"""The offence of a subgoal that takes more actions than it may."""


class SubgoalPlans(NamedTuple):
    """The actions to take for a subgoal in a state.

    Attributes:
        plans: the plans for it, each to be tried; none if nothing is to be done there.
        effort: how many actions were applied to states to find them.
        refused: why nothing is done, and the subgoal fails; None where it does not.
        has_failed: whether nothing brings it about, and not for the kind of its objects.
    """

    plans: Sequence[ActionSequence]
    effort: int = 0
    failed_check: Check | None = None
    has_failed: bool = False


SubgoalPlanner: TypeAlias = Callable[[State], SubgoalPlans]
"""The actions to take for a subgoal in a state."""


class Perform(NamedTuple):
    """Carry out a subgoal by one of the plans for it in the state at hand; if there is none, do nothing.

    No more than ``most`` actions are executed for one subgoal, if that is given.
    """

    plans: SubgoalPlanner
    subgoal: int
    then: int
    max_actions: int | None = None


class Require(NamedTuple):
    """Continue if a subgoal holds; ``check`` says what is wrong if not, ``effort`` what the test costs."""

    holds: Callable[[State], bool]
    check: Check
    subgoal: int
    then: int
    effort: int = 1


class Fork(NamedTuple):
    """Continue a subgoal in each of the ways that are open in a state, those with greater numbers first.

    ``effort`` is what it costs to find them.
    """

    targets: Callable[[State], Sequence[int]]
    subgoal: int
    effort: int = 0


Instruction: TypeAlias = Perform | Require | Fork | None
"""The next thing to do; None where all subgoals are carried out."""

Program: TypeAlias = Sequence[Instruction]
"""Instructions that lead to earlier ones only; the last one is the first to run, number 0 is None."""


@dataclass(frozen=True, slots=True)
class CompiledAnswer:
    """An answer that can be carried out: its subgoals, their program, and how its text was read."""

    subgoals: tuple[Formula, ...]
    program: Program
    repairs: tuple[str, ...] = ()
    spans: tuple[Span, ...] = ()


MisusedName: TypeAlias = tuple[int, Misuse]
"""The number of a subgoal, from 0, and a name in it that is not allowed."""


@dataclass(frozen=True, slots=True)
class RejectedAnswer:
    """An answer that cannot be carried out: why, what is wrong with its names, and how its text was read."""

    category: SubgoalCategory
    error: ErrorReport
    repairs: tuple[str, ...] = ()
    misused_names: tuple[MisusedName, ...] = ()
    spans: tuple[Span, ...] = ()


def reject_unparseable(
    reason: str, repairs: tuple[str, ...] = (), subgoal: int | None = None
) -> RejectedAnswer:
    """The rejection of what no plan can be made of, for the sake of this subgoal if it is one."""
    error = ErrorReport(FaultKind.PARSING, subgoal, reason)
    return RejectedAnswer(SubgoalCategory.NOT_PARSEABLE, error, repairs)


_PRECEDENCE = ("unknown_predicate", "wrong_arity", "unknown_object")


def reject_names(offences: Sequence[MisusedName], repairs: tuple[str, ...]) -> RejectedAnswer:
    """The rejection for names that are not allowed: unknown predicates first, then numbers of objects."""
    subgoal, worst = min(offences, key=lambda offence: _PRECEDENCE.index(offence[1].kind))
    wrong_number = worst.kind == "wrong_arity"
    kind = FaultKind.ARGUMENT_NUMBER if wrong_number else FaultKind.HALLUCINATION
    objects = (worst.name,) if worst.kind == "unknown_object" else ()
    error = ErrorReport(kind, subgoal, worst.detail, worst.kind, objects)
    return RejectedAnswer(SubgoalCategory.HALLUCINATION, error, repairs, tuple(offences))
