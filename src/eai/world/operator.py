"""Operators: an ordered list of checks and a list of effects."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache

from eai.base.errors import DomainError, did_you_mean
from eai.logic.formula import Exists, Formula, Variable
from eai.world.effect import Effect, ForEach, Let, When
from eai.world.fault import FaultKind
from eai.world.vocabulary import require_tuple

_PARAMETER = re.compile(r"{(\w+)}")
_WORD = re.compile(r"\w+")
_PAPER_ORDER = (FaultKind.AFFORDANCE, FaultKind.ADDITIONAL_STEP, FaultKind.MISSING_STEP)


@dataclass(frozen=True, slots=True)
class Check:
    """A condition for an action, and what its failure means.

    Attributes:
        condition: must hold in the state in which the action is tried.
        fault: the kind of error if it does not.
        reason: what is wrong then, in words; ``{x}`` stands for the name of the argument of parameter ``x``.
        sought: what the history rule looks for in earlier states to tell a wrong order from a missing step:
            each of these formulas must have held at some time. None means the condition itself.
        id: what records call the check; by default the words of its reason without the objects. A check that
            is worded anew keeps its id by giving it here.
        witness: tells what the reason speaks of without a name; explanations name what it is true of.

    Raises:
        DomainError: it gives no reason, or names a kind of error that no check can find.
    """

    condition: Formula
    fault: FaultKind
    reason: str
    sought: tuple[Formula, ...] | None = None
    id: str = ""
    witness: Exists | None = None

    def __post_init__(self) -> None:
        if not self.reason:
            raise DomainError(f"a check of {self.fault.value} gives no reason")
        if self.fault not in (*_PAPER_ORDER, FaultKind.UNCATEGORISED):
            raise DomainError(f"check {self.reason!r} names {self.fault.value}, which no check can find")
        if not self.id:
            words = _WORD.findall(_PARAMETER.sub("", self.reason))
            object.__setattr__(self, "id", "_".join(words).lower())

    @property
    def mentioned_parameters(self) -> tuple[str, ...]:
        """The parameters whose objects the reason speaks of, in the order of its words."""
        return _concerned(self.reason)


@lru_cache(maxsize=1024)
def _concerned(reason: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(_PARAMETER.findall(reason)))


def affordance(condition: Formula, reason: str) -> Check:
    """A check that the objects are of the right kind for the action."""
    return Check(condition, FaultKind.AFFORDANCE, reason)


def additional(condition: Formula, reason: str) -> Check:
    """A check that the action is still needed."""
    return Check(condition, FaultKind.ADDITIONAL_STEP, reason)


def missing(
    condition: Formula,
    reason: str,
    sought: tuple[Formula, ...] | None = None,
    witness: Exists | None = None,
) -> Check:
    """A check that an earlier step has prepared the action."""
    return Check(condition, FaultKind.MISSING_STEP, reason, sought, witness=witness)


@dataclass(frozen=True, slots=True)
class Try:
    """One of several things that an action tries.

    Attributes:
        condition: the try is made if this holds in the state in which the action is tried.
        checks: in order; the first one that fails is what is wrong with the try.
        effects: read in the state before, made in order, if no check fails.
    """

    condition: Formula
    checks: tuple[Check, ...]
    effects: tuple[Effect, ...]

    @property
    def conditions(self) -> tuple[Formula, ...]:
        """All that must hold where something is tried."""
        return (self.condition, *(check.condition for check in self.checks))


class Role(str, Enum):
    """The purpose of an operator, as far as carrying out a subgoal is concerned.

    Movement changes only where the agent is, what it faces and its posture. What takes an object into a hand
    or releases it changes the agent's hands. Everything else is a change of the world.
    """

    MOVEMENT = "movement"
    TAKES = "takes"
    RELEASES = "releases"
    CHANGE = "change"


@dataclass(frozen=True, slots=True)
class Operator:
    """An action of a domain.

    Attributes:
        name: as it is written in plans.
        parameters: its arguments, in order. The agent is not among them.
        checks: in order; the first one that fails is the verdict.
        effects: read in the state before, made in order.
        description: what it does, for prompts.
        tries: where there are any, the action succeeds if one of those made succeeds, or if none is made; it
            has the effects of all that do. If all fail, what is wrong with each is reported together.
        role: what it is for; by default inferred from its effects (`eai.planning.role`).

    Raises:
        DomainError: two parameters have one name, a reason speaks of no parameter, or a part is no tuple.
    """

    name: str
    parameters: tuple[Variable, ...]
    checks: tuple[Check, ...]
    effects: tuple[Effect, ...]
    description: str = ""
    tries: tuple[Try, ...] = ()
    role: Role | None = None

    def __post_init__(self) -> None:
        place = f"operator {self.name}"
        parts = ((self.checks, self.effects), *((each.checks, each.effects) for each in self.tries))
        require_tuple(f"{place}, parameters", self.parameters, Variable)
        for checks, effects in parts:
            require_tuple(f"{place}, checks", checks, Check)
            require_tuple(f"{place}, effects", effects, Effect)
        names = [parameter.name for parameter in self.parameters]
        for name in names:
            if names.count(name) > 1:
                raise DomainError(f"{place}: two parameters are called {name}")
        for name in (name for checks, _ in parts for each in checks for name in each.mentioned_parameters):
            if name not in names:
                raise DomainError(
                    f"{place}: a reason speaks of {name}, no parameter{did_you_mean(name, names)}"
                )

    @property
    def arity(self) -> int:
        """The number of arguments."""
        return len(self.parameters)

    def scope(self, arguments: Sequence[int]) -> dict[str, int]:
        """The objects of an action, by the names of the parameters that they stand for."""
        return {p.name: index for p, index in zip(self.parameters, arguments, strict=True)}


def conditions_of(operator: Operator) -> Iterator[Formula]:
    """All conditions of an operator."""
    yield from (check.condition for check in operator.checks)
    yield from _conditions(operator.effects)
    for each in operator.tries:
        yield from each.conditions
        yield from _conditions(each.effects)


def _conditions(effects: Iterable[Effect]) -> Iterator[Formula]:
    for effect in effects:
        if isinstance(effect, When | ForEach | Let):
            yield effect.condition
            yield from _conditions(effect.effects)
        if isinstance(effect, When):
            yield from _conditions(effect.otherwise)


def sort_checks(operator: Operator) -> Operator:
    """The operator with its checks in the order of the paper: affordance, additional step, missing step.

    Checks of one kind keep their order.
    """
    tries = tuple(replace(each, checks=_sorted(each.checks)) for each in operator.tries)
    return replace(operator, checks=_sorted(operator.checks), tries=tries)


def _sorted(checks: tuple[Check, ...]) -> tuple[Check, ...]:
    return tuple(sorted(checks, key=lambda check: _PAPER_ORDER.index(check.fault)))
