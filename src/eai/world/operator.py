"""Operators: actions of a domain, each with an ordered list of checks and a list of effects."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache
from string import Formatter

from eai.base.errors import DomainError, did_you_mean
from eai.logic.formula import Exists, Formula, Variable
from eai.logic.signature import join_with_or
from eai.world.effect import Effect, ForEach, Let, When
from eai.world.fault import FAULT_PRECEDENCE, FaultKind
from eai.world.vocabulary import require_tuple

_PARAMETER = re.compile(r"{(\w+)}")
_WORD = re.compile(r"\w+")
_PAPER_ORDER = (
    FaultKind.UNCATEGORISED,
    FaultKind.AFFORDANCE,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.MISSING_STEP,
)


@dataclass(frozen=True, slots=True)
class Check:
    """A condition that an action must meet, and the kind of error if the action does not meet it.

    Attributes:
        condition: the formula that must hold in the state in which the action is tried.
        fault: the kind of error if the condition does not hold.
        reason: description of the failure; ``{x}`` stands for the name of the object of parameter ``x``.
        history_conditions: formulas by which the history rule recognizes a wrong order: each of them must
            have held in some earlier state. None means ``condition``.
        id: name of the check in stored verdicts (records); by default the words of ``reason`` without
            the objects. Give the old id here when you reword a reason.
        witness: a quantified formula. Explanations name the objects that make its body true, because
            ``reason`` does not name them.

    Raises:
        DomainError: the reason is empty, or ``fault`` is a kind of error that never comes from one check.
    """

    condition: Formula
    fault: FaultKind
    reason: str
    history_conditions: tuple[Formula, ...] | None = None
    id: str = ""
    witness: Exists | None = None

    def __post_init__(self) -> None:
        if not self.reason:
            raise DomainError(f"a check for {self.fault.value} has an empty reason: describe the failure")
        if self.fault not in FAULT_PRECEDENCE or self.fault is FaultKind.WRONG_ORDER:
            expected = join_with_or(
                [kind.value for kind in FAULT_PRECEDENCE if kind is not FaultKind.WRONG_ORDER]
            )
            raise DomainError(
                f"the check with the reason {self.reason!r} has the fault kind {self.fault.value}:"
                f" expected {expected}"
            )
        if not self.id:
            words = _WORD.findall(_PARAMETER.sub("", self.reason))
            object.__setattr__(self, "id", "_".join(words).lower())

    @property
    def mentioned_parameters(self) -> tuple[str, ...]:
        """Names of the operator's parameters that `reason` mentions as ``{x}``, in order of first mention."""
        return _find_mentioned_parameters(self.reason)


@lru_cache(maxsize=1024)
def _find_mentioned_parameters(reason: str) -> tuple[str, ...]:
    try:
        fields = [field for _, field, _, _ in Formatter().parse(reason) if field is not None]
    except ValueError as error:
        raise DomainError(
            f"reason {reason!r}: {error}; write {{{{ and }}}} for braces in the text"
        ) from error
    return tuple(dict.fromkeys(fields))


def affordance(condition: Formula, reason: str) -> Check:
    """Return a check that the objects have the properties that the action needs.

    If it fails, the fault of the action is an affordance error.
    """
    return Check(condition, FaultKind.AFFORDANCE, reason)


def additional_step(condition: Formula, reason: str) -> Check:
    """Return a check that fails if the action is needless; the action is then an additional step."""
    return Check(condition, FaultKind.ADDITIONAL_STEP, reason)


def missing_step(
    condition: Formula,
    reason: str,
    history_conditions: tuple[Formula, ...] | None = None,
    witness: Exists | None = None,
) -> Check:
    """Return a check of a condition that earlier steps must make true. If it fails, a step is missing."""
    return Check(condition, FaultKind.MISSING_STEP, reason, history_conditions, witness=witness)


@dataclass(frozen=True, slots=True)
class OperatorAlternative:
    """One of several ways in which an operator can act, with its own checks and effects.

    Attributes:
        condition: the alternative is attempted if this holds in the state in which the action is tried.
        checks: the first check that fails gives the error of the alternative.
        effects: the effects, in order, if no check fails. Their conditions are evaluated in the state before
            the action.
    """

    condition: Formula
    checks: tuple[Check, ...]
    effects: tuple[Effect, ...]

    @property
    def conditions(self) -> tuple[Formula, ...]:
        """The condition on which this alternative (way to act) is tried, and the conditions of its checks."""
        return (self.condition, *(check.condition for check in self.checks))


class OperatorRole(str, Enum):
    """The kind of change that an operator makes.

    Movement changes only the place of the agent, the objects that it faces, and its posture. Taking or
    releasing an object changes only the contents of the agent's hands. All other operators change the world.
    """

    MOVEMENT = "movement"
    TAKES = "takes"
    RELEASES = "releases"
    CHANGE = "change"


@dataclass(frozen=True, slots=True)
class Operator:
    """An action of a domain.

    Attributes:
        name: the name of the action in plans.
        parameters: the variables that stand for the objects of an action, in order, without the agent.
        checks: the first check that fails gives the error of the action.
        effects: the effects, in order. Their conditions are evaluated in the state before the action.
        description: description for prompts.
        alternatives: further ways to act, tried if all ``checks`` pass. An alternative is attempted if its
            condition holds. The action succeeds if any attempted alternative succeeds, or if none is
            attempted. It has the effects of all alternatives that succeed, then ``effects``. If all attempted
            alternatives fail, their errors are reported together.
        role: the kind of change; by default inferred from the effects (`eai.planning.role`).

    Raises:
        DomainError: two parameters have the same name, a reason mentions an unknown parameter, or a value is
            not a tuple.
    """

    name: str
    parameters: tuple[Variable, ...]
    checks: tuple[Check, ...]
    effects: tuple[Effect, ...]
    description: str = ""
    alternatives: tuple[OperatorAlternative, ...] = ()
    role: OperatorRole | None = None

    def __post_init__(self) -> None:
        location = f"operator {self.name}"
        parts = ((self.checks, self.effects), *((check.checks, check.effects) for check in self.alternatives))
        require_tuple(f"{location}, parameters", self.parameters, Variable)
        for checks, effects in parts:
            require_tuple(f"{location}, checks", checks, Check)
            require_tuple(f"{location}, effects", effects, Effect)
        names = [parameter.name for parameter in self.parameters]
        for name in names:
            if names.count(name) > 1:
                raise DomainError(
                    f"{location}: two parameters are called {name}: give each a name of its own"
                )
        for name in (name for checks, _ in parts for check in checks for name in check.mentioned_parameters):
            if name not in names:
                raise DomainError(
                    f"{location}: the reason of a check mentions {{{name}}}, which is no parameter of the"
                    f" operator{did_you_mean(name, names)}"
                )

    @property
    def arity(self) -> int:
        """The number of arguments."""
        return len(self.parameters)

    def map_parameters(self, arguments: Sequence[int]) -> dict[str, int]:
        """Return a mapping from the names of the parameters to the objects of an action."""
        return {p.name: index for p, index in zip(self.parameters, arguments, strict=True)}


def find_operator_conditions(operator: Operator) -> Iterator[Formula]:
    """Yield the conditions of an operator's checks, effects and alternatives (other ways to act)."""
    yield from (check.condition for check in operator.checks)
    yield from _find_effect_conditions(operator.effects)
    for attempt in operator.alternatives:
        yield from attempt.conditions
        yield from _find_effect_conditions(attempt.effects)


def _find_effect_conditions(effects: Iterable[Effect]) -> Iterator[Formula]:
    for effect in effects:
        if isinstance(effect, When | ForEach | Let):
            yield effect.condition
            yield from _find_effect_conditions(effect.effects)
        if isinstance(effect, When):
            yield from _find_effect_conditions(effect.otherwise)


def sort_checks_in_paper_order(operator: Operator) -> Operator:
    """Return a copy of an operator, with its checks in the order of the paper "Embodied Agent Interface".

    The order is affordance, additional step, missing step. Checks of one kind keep their order. Checks of the
    kind `FaultKind.UNCATEGORISED`, which the paper lacks, come first.
    """
    tries = tuple(
        replace(attempt, checks=_sort_checks_by_kind(attempt.checks)) for attempt in operator.alternatives
    )
    return replace(operator, checks=_sort_checks_by_kind(operator.checks), alternatives=tries)


def _sort_checks_by_kind(checks: tuple[Check, ...]) -> tuple[Check, ...]:
    return tuple(sorted(checks, key=lambda check: _PAPER_ORDER.index(check.fault)))
