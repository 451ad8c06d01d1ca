"""Domains: everything there is to know about a world, declared in one value."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple, TypeAlias

from eai.errors import DomainError
from eai.logic.formula import FALSE, TRUE, And, Formula, Variable
from eai.world.condition import Conditions
from eai.world.connective import all_of
from eai.world.effect import Apply, Effects
from eai.world.fault import FaultKind
from eai.world.frame import Binding, Frame, Truth
from eai.world.operator import Check, Operator
from eai.world.past import Past
from eai.world.state import Draft, State
from eai.world.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True, eq=False)
class CompiledCheck:
    """A check with its condition, and each formula of what it seeks in the past, as functions.

    It is equal to itself alone, and belongs to one list of checks.
    """

    check: Check
    holds: Truth
    sought: tuple[Truth, ...]


class CompiledTry(NamedTuple):
    """A try of an operator as functions of a state and a binding."""

    is_made: Truth
    checks: tuple[CompiledCheck, ...]
    apply: Apply


class Failure(NamedTuple):
    """A check that fails of some objects, in the list of checks of the operator or of one of its tries."""

    check: CompiledCheck
    checks: tuple[CompiledCheck, ...]
    arguments: tuple[int, ...]


class Undone(NamedTuple):
    """What an action tries in vain: the condition that stays as it is, and the check that fails."""

    condition: Formula
    check: Check


class CompiledOperator:
    """An operator whose checks and effects are functions of a state and a binding.

    Attributes:
        operator: the operator.
        checks: its checks, in order.
        tries: what it tries.
        is_possible: whether no check fails, and some try succeeds if any is made: all checks asked together.
    """

    __slots__ = ("_apply", "_frame", "checks", "is_possible", "operator", "tries")

    def __init__(self, operator: Operator, vocabulary: Vocabulary) -> None:
        self.operator = operator
        self._frame = Frame(operator.parameters)
        conditions = Conditions(vocabulary, self._frame)
        effects = Effects(vocabulary, self._frame)
        self.checks = _compiled(operator.checks, conditions)
        passes = conditions.truth(And(tuple(check.condition for check in operator.checks)))
        self.is_possible: Truth = passes
        if operator.tries:
            self.is_possible = lambda state, binding: (
                passes(state, binding) and not self._failed_tries(state, binding)
            )
        self.tries = tuple(
            CompiledTry(
                conditions.truth(each.condition),
                _compiled(each.checks, conditions),
                effects.sequence(each.effects),
            )
            for each in operator.tries
        )
        self._apply: Apply | None = effects.sequence(operator.effects) if operator.effects else None

    def bind(self, state: State, arguments: Sequence[int]) -> Binding:
        """The binding of the operator's variables for these arguments."""
        return self._frame.bind(state.scene, arguments)

    def failures(self, state: State, binding: Binding) -> tuple[Failure, ...]:
        """All that is wrong: the first check that fails, or that of every try; empty if it is possible."""
        failed = first_failing(self.checks, state, binding)
        if failed is not None:
            return (Failure(failed, self.checks, self._arguments(binding)),)
        return self._failed_tries(state, binding)

    def apply(self, state: State, binding: Binding) -> State:
        """The state after the action, whatever the operator's own checks say."""
        if self._apply is None and not self.tries:
            return state
        draft = Draft(state)
        for each in self.tries:
            if each.is_made(state, binding) and first_failing(each.checks, state, binding) is None:
                each.apply(state, draft, binding)
        if self._apply is not None:
            self._apply(state, draft, binding)
        return State(state.scene, tuple(draft.unary), tuple(draft.binary))

    def left_undone(self, before: State, after: State, binding: Binding) -> tuple[Undone, ...]:
        """What the action tries in vain: each try that was made before, and would be made again after."""
        undone = []
        for each, compiled in zip(self.operator.tries, self.tries, strict=True):
            if compiled.is_made(before, binding) and compiled.is_made(after, binding):
                failed = first_failing(compiled.checks, before, binding)
                if failed is not None:
                    undone.append(Undone(each.condition, failed.check))
        return tuple(undone)

    def _failed_tries(self, state: State, binding: Binding) -> tuple[Failure, ...]:
        """What is wrong with each try that is made; empty if one succeeds or none is made."""
        failures = []
        for each in self.tries:
            if each.is_made(state, binding):
                failed = first_failing(each.checks, state, binding)
                if failed is None:
                    return ()
                failures.append(Failure(failed, each.checks, self._arguments(binding)))
        return tuple(failures)

    def _arguments(self, binding: Binding) -> tuple[int, ...]:
        """What a binding was made for."""
        return tuple(binding[1 : 1 + self.operator.arity])


def first_failing(checks: Sequence[CompiledCheck], state: State, binding: Binding) -> CompiledCheck | None:
    """The first of the checks that fails in the state, or None."""
    for check in checks:
        if not check.holds(state, binding):
            return check
    return None


HistoryRule: TypeAlias = Callable[[Failure, Binding, Past], int | None]
"""Judges a failed check against the past: the number of the earlier state that makes it a wrong order.

Its last argument is the trajectory so far: the initial state, then the state after each executed step. None
means that the step which should have prepared the action was never taken.
"""


def each_held_before(failure: Failure, binding: Binding, past: Past) -> int | None:
    """A history rule: all that a missing step's check seeks held at some time, not necessarily at once.

    Returns the latest state by which all of it had been seen.
    """
    if failure.check.check.fault is not FaultKind.MISSING_STEP:
        return None
    latest = 0
    for number, sought in enumerate(failure.check.sought):
        question = (failure.check, number, failure.arguments)
        found = past.latest(question, partial(_in_state, sought, binding))
        if found is None:
            return None
        latest = max(latest, found)
    return latest


def _in_state(truth: Truth, binding: Binding, state: State) -> bool:
    return truth(state, binding)


def was_possible_before(failure: Failure, binding: Binding, past: Past) -> int | None:
    """A history rule: in a state before the last one no check failed, and all that this check seeks held.

    Returns the latest such state.
    """
    if past.before is None:
        return None
    had_it = all_of(failure.check.sought)

    def sufficed(state: State) -> bool:
        return had_it(state, binding) and first_failing(failure.checks, state, binding) is None

    return past.before.latest((failure.check, failure.arguments), sufficed)


PRECEDENCE = (
    FaultKind.UNCATEGORISED,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.AFFORDANCE,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
)
"""Which kind of fault counts where a step has several, first to last."""


@dataclass(frozen=True)
class Domain:
    """A declared world.

    Attributes:
        name: the domain's name, as the command line takes it.
        vocabulary: stored and derived predicates.
        operators: the actions.
        history_rule: tells a wrong order from a missing step.
        precedence: which kind of fault counts where a step has several, first to last.
        visible: what an agent sees that does not see everything: the objects that make this true as ``x``,
            its only free variable. None where whoever acts sees all there is.
        landmarks: what such an agent knows of from the start without seeing it: the objects that make this
            true as ``x``. None where there is nothing.

    Raises:
        DomainError: two operators have one name, or a formula or effect uses what is not declared.
    """

    name: str
    vocabulary: Vocabulary
    operators: tuple[Operator, ...]
    history_rule: HistoryRule = each_held_before
    precedence: tuple[FaultKind, ...] = PRECEDENCE
    visible: Formula | None = None
    landmarks: Formula | None = None

    def __post_init__(self) -> None:
        names = [operator.name for operator in self.operators]
        for name in names:
            if names.count(name) > 1:
                raise DomainError(f"operator {name} is declared twice")

    @cached_property
    def arities(self) -> Mapping[str, int]:
        """The number of arguments of every operator, by name."""
        return {operator.name: operator.arity for operator in self.operators}

    @cached_property
    def compiled(self) -> Mapping[str, CompiledOperator]:
        """The operators by name, ready to run."""
        compiled: dict[str, CompiledOperator] = {}
        for operator in self.operators:
            try:
                compiled[operator.name] = CompiledOperator(operator, self.vocabulary)
            except DomainError as error:
                raise DomainError(f"operator {operator.name}: {error}") from error
        return compiled

    def operator(self, name: str) -> Operator | None:
        """The operator of this name, or None."""
        compiled = self.compiled.get(name)
        return None if compiled is None else compiled.operator

    def with_operators(self, *changed: Operator, without: Sequence[str] = ()) -> Domain:
        """The domain in which these operators replace those of their name, and some are left out."""
        by_name = {operator.name: operator for operator in changed}
        kept = tuple(by_name.pop(o.name, o) for o in self.operators if o.name not in without)
        return replace(self, operators=(*kept, *by_name.values()))

    @cached_property
    def sees(self) -> Callable[[State, int], bool]:
        """Whether an object, by index, is visible in a state."""
        return self._about_one(self.visible)

    @cached_property
    def is_landmark(self) -> Callable[[State, int], bool]:
        """Whether an object, by index, is known of from the start of an episode that begins in a state."""
        return self._about_one(self.landmarks or FALSE)

    def _about_one(self, formula: Formula | None) -> Callable[[State, int], bool]:
        """A formula as a function of a state and the object that its variable ``x`` stands for."""
        frame = Frame((Variable("x"),))
        truth = Conditions(self.vocabulary, frame).truth(TRUE if formula is None else formula)
        return lambda state, index: truth(state, frame.bind(state.scene, (index,)))

    def holds(self, formula: Formula, state: State, arguments: Mapping[str, int] | None = None) -> bool:
        """Whether a state formula holds; ``arguments`` gives its free variables their objects."""
        arguments = arguments or {}
        frame = Frame(tuple(Variable(name) for name in arguments))
        truth = Conditions(self.vocabulary, frame).truth(formula)
        return truth(state, frame.bind(state.scene, tuple(arguments.values())))


def _compiled(checks: Sequence[Check], conditions: Conditions) -> tuple[CompiledCheck, ...]:
    return tuple(
        CompiledCheck(
            check,
            conditions.truth(check.condition),
            tuple(conditions.truth(formula) for formula in _sought(check)),
        )
        for check in checks
    )


def _sought(check: Check) -> tuple[Formula, ...]:
    return (check.condition,) if check.sought is None else check.sought
