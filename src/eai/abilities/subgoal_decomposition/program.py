"""Programs: instructions by which a search executes the subgoals of an answer. Also rejections of answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory
from eai.abilities.verdict import AnswerSpan, ErrorReport
from eai.logic.formula import TRUE, Formula
from eai.logic.signature import NameMisuse
from eai.world.action import Action
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.state import State

ActionSequence: TypeAlias = Sequence[Action]
"""A sequence of actions on objects."""

MAX_ACTIONS_PER_SUBGOAL = 2
"""Maximum number of actions for one subgoal, including movement."""


TOO_FAR = Check(
    TRUE,
    FaultKind.MISSING_STEP,
    f"it takes more than {MAX_ACTIONS_PER_SUBGOAL} actions: the states in between must be subgoals, too",
    id="too_many_actions",
)
"""The check that fails if a subgoal needs more than `MAX_ACTIONS_PER_SUBGOAL` actions."""


class SubgoalPlanningResult(NamedTuple):
    """The plans that reach a subgoal from a state.

    Attributes:
        plans: the plans. The search tries each. Empty if nothing must be done.
        effort: number of actions that the search for plans applied to states.
        failed_check: the check that fails before any action; None if the subgoal can be tried.
        has_failed: whether no plan reaches the subgoal, although its objects are of the right kind.
    """

    plans: Sequence[ActionSequence]
    effort: int = 0
    failed_check: Check | None = None
    has_failed: bool = False


SubgoalPlanner: TypeAlias = Callable[[State], SubgoalPlanningResult]
"""Function that finds the plans which reach a subgoal from a state."""


class ExecuteSubgoalPlansInstruction(NamedTuple):
    """An instruction: execute each plan for a subgoal, from the present state. Without a plan, do nothing.

    Attributes:
        plans: finds the plans.
        subgoal: number of the subgoal, from 0.
        then: number of the next instruction.
        max_actions: maximum number of actions for one subgoal; None for no limit.
    """

    plans: SubgoalPlanner
    subgoal: int
    then: int
    max_actions: int | None = None


class CheckSubgoalHoldsInstruction(NamedTuple):
    """An instruction: test whether a subgoal holds, and continue only then.

    Attributes:
        holds: tests the subgoal in a state.
        check: the check that fails if the subgoal does not hold.
        subgoal: number of the subgoal, from 0.
        then: number of the next instruction.
        effort: cost of the test, in applied actions.
    """

    holds: Callable[[State], bool]
    check: Check
    subgoal: int
    then: int
    effort: int = 1


class SubgoalForkInstruction(NamedTuple):
    """An instruction: continue a subgoal in several branches.

    The branch with the greatest instruction number is explored first.

    Attributes:
        targets: takes a state, and returns the number of the next instruction of each branch.
        subgoal: number of the subgoal, from 0.
        effort: cost of a call of ``targets``, as a number of applied actions.
    """

    targets: Callable[[State], Sequence[int]]
    subgoal: int
    effort: int = 0


Instruction: TypeAlias = (
    ExecuteSubgoalPlansInstruction | CheckSubgoalHoldsInstruction | SubgoalForkInstruction | None
)
"""An instruction of a `SubgoalProgram`. None is the instruction that ends the program, after all subgoals."""

SubgoalProgram: TypeAlias = Sequence[Instruction]
"""A sequence of instructions, which run from the last to the first.

Instruction 0 is None and ends the program. Every other instruction leads only to instructions with smaller
numbers.
"""


@dataclass(frozen=True, slots=True)
class CompiledSubgoalAnswer:
    """An answer that can be executed.

    Attributes:
        subgoals: the subgoals.
        program: the program that executes the subgoals.
        repairs: names of the repairs that were needed to read the answer.
        spans: parts of the answer's text, and how each was treated.
    """

    subgoals: tuple[Formula, ...]
    program: SubgoalProgram
    repairs: tuple[str, ...] = ()
    spans: tuple[AnswerSpan, ...] = ()


MisusedName: TypeAlias = tuple[int, NameMisuse]
"""A pair: the number of a subgoal, from 0, and the wrong use of a name in the subgoal."""


@dataclass(frozen=True, slots=True)
class RejectedAnswer:
    """An answer that cannot be executed.

    Attributes:
        category: the answer's outcome, such as unparseable.
        error: the error that makes the answer impossible to execute.
        repairs: names of the repairs that were needed to read the answer.
        misused_names: the names whose use is not allowed.
        spans: parts of the answer's text, and how each was treated.
    """

    category: SubgoalAnswerCategory
    error: ErrorReport
    repairs: tuple[str, ...] = ()
    misused_names: tuple[MisusedName, ...] = ()
    spans: tuple[AnswerSpan, ...] = ()


def reject_unparseable(
    reason: str, repairs: tuple[str, ...] = (), subgoal: int | None = None
) -> RejectedAnswer:
    """Return the rejection of an answer that cannot be parsed.

    Args:
        reason: the reason in words.
        repairs: names of the repairs that were needed to read the answer.
        subgoal: number of the subgoal that cannot be parsed; None if the reason is about the whole answer.
    """
    error = ErrorReport(FaultKind.PARSING, subgoal, reason)
    return RejectedAnswer(SubgoalAnswerCategory.NOT_PARSEABLE, error, repairs)


_PRECEDENCE = ("unknown_predicate", "wrong_arity", "unknown_object")


def reject_misused_names(offences: Sequence[MisusedName], repairs: tuple[str, ...]) -> RejectedAnswer:
    """Return the rejection of an answer that uses names in wrong ways.

    The first misused name is reported as the error of the answer. Unknown predicates come before wrong
    numbers of arguments, and wrong numbers before unknown objects.
    """
    subgoal, worst = min(offences, key=lambda offence: _PRECEDENCE.index(offence[1].kind))
    wrong_number = worst.kind == "wrong_arity"
    kind = FaultKind.ARGUMENT_NUMBER if wrong_number else FaultKind.HALLUCINATION
    objects = (worst.name,) if worst.kind == "unknown_object" else ()
    error = ErrorReport(kind, subgoal, worst.detail, worst.kind, objects)
    return RejectedAnswer(SubgoalAnswerCategory.HALLUCINATION, error, repairs, tuple(offences))
