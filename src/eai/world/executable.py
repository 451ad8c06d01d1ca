"""Compiled operators: their checks and effects are functions of a state and a binding of variables.

`compile_argument_finder` returns a function that finds the arguments for which no check of an operator fails.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from eai.logic.formula import And, Formula
from eai.logic.traversal import find_free_variables
from eai.world.condition import ConditionCompiler, combine_tests_by_and
from eai.world.effect import Apply, EffectCompiler
from eai.world.frame import UNBOUND, ConditionTest, ObjectBySlot, SlotAllocator
from eai.world.operator import Check, Operator
from eai.world.relation import ObjectMask, make_mask
from eai.world.state import State, StateDraft
from eai.world.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True, eq=False)
class _CompiledCheck:
    """A compiled check of an action: its condition, and conditions on earlier states (`eai.world.history`).

    Two compiled checks are equal only if they are the same object. Each belongs to one operator, or to one
    alternative (way to act) of an operator.
    """

    check: Check
    holds: ConditionTest
    history_conditions: tuple[ConditionTest, ...]


class _CompiledOperatorAlternative(NamedTuple):
    """A compiled alternative of an operator: one of several ways in which the operator can act."""

    is_attempted: ConditionTest
    checks: tuple[_CompiledCheck, ...]
    apply: Apply


class CheckFailure(NamedTuple):
    """A failed check, the list of checks that contains it, and the indices of the action's objects.

    The checks belong to an operator, or to one of the operator's alternatives (ways to act).
    """

    check: _CompiledCheck
    checks: tuple[_CompiledCheck, ...]
    arguments: tuple[int, ...]


class _FailedOperatorAlternative(NamedTuple):
    """A failed alternative (way to act) of an operator: the condition to try it, and its failed check."""

    condition: Formula
    check: Check


class CompiledOperator:
    """An operator whose checks and effects are compiled to functions of a state and a binding.

    Attributes:
        operator: the operator.
        checks: the operator's checks, in order.
        alternatives: other ways in which the operator can act, in order. Each has its own checks, and a
            condition on which it is tried.
        is_possible: function that tests whether all checks pass and, if any alternatives are tried, one of
            them succeeds.
    """

    __slots__ = ("_apply", "_frame", "alternatives", "checks", "is_possible", "operator")

    def __init__(self, operator: Operator, vocabulary: Vocabulary) -> None:
        self.operator = operator
        self._frame = SlotAllocator(operator.parameters)
        conditions = ConditionCompiler(vocabulary, self._frame)
        effects = EffectCompiler(vocabulary, self._frame)
        self.checks = _compile_checks(operator.checks, conditions)
        passes = combine_tests_by_and([check.holds for check in self.checks])
        self.is_possible: ConditionTest = passes
        if operator.alternatives:
            self.is_possible = lambda state, binding: (
                passes(state, binding) and not self._find_failures_if_all_alternatives_fail(state, binding)
            )
        self.alternatives = tuple(
            _CompiledOperatorAlternative(
                conditions.compile_test(attempt.condition),
                _compile_checks(attempt.checks, conditions),
                effects.compile_sequence(attempt.effects),
            )
            for attempt in operator.alternatives
        )
        self._apply: Apply | None = effects.compile_sequence(operator.effects) if operator.effects else None

    @property
    def mentions_agent(self) -> bool:
        """Whether a check or an effect is about the agent."""
        return self._frame.mentions_agent

    def bind(self, state: State, arguments: Sequence[int]) -> ObjectBySlot:
        """Return a binding of the operator's variables to these arguments."""
        return self._frame.bind_arguments(state.scene, arguments)

    def find_failures(self, state: State, binding: ObjectBySlot) -> tuple[CheckFailure, ...]:
        """Return the failed checks of an action: () if the action is possible.

        If a check of the operator fails, the result is the operator's first failed check. Otherwise the
        result depends on the tried alternatives (ways to act). If all of them fail, it is the first failed
        check of each.
        """
        failed = find_failing_check(self.checks, state, binding)
        if failed is not None:
            return (CheckFailure(failed, self.checks, self._get_arguments(binding)),)
        return self._find_failures_if_all_alternatives_fail(state, binding)

    def apply(self, state: State, binding: ObjectBySlot) -> State:
        """Return the state after the action. The caller has made sure that the operator's checks hold.

        The checks of the operator's alternatives (other ways to act) need not hold.
        """
        if self._apply is None and not self.alternatives:
            return state
        draft = StateDraft(state)
        for attempt in self.alternatives:
            if (
                attempt.is_attempted(state, binding)
                and find_failing_check(attempt.checks, state, binding) is None
            ):
                attempt.apply(state, draft, binding)
        if self._apply is not None:
            self._apply(state, draft, binding)
        return State(state.scene, tuple(draft.unary), tuple(draft.binary), draft.tuples)

    def find_failed_operator_alternatives(
        self, before: State, after: State, binding: ObjectBySlot
    ) -> tuple[_FailedOperatorAlternative, ...]:
        """Return the alternatives (ways to act) whose checks failed in the state before an executed action.

        Only alternatives whose condition holds before the action and also after it are returned.
        """
        failed_tries = []
        for attempt, compiled in zip(self.operator.alternatives, self.alternatives, strict=True):
            if compiled.is_attempted(before, binding) and compiled.is_attempted(after, binding):
                failed = find_failing_check(compiled.checks, before, binding)
                if failed is not None:
                    failed_tries.append(_FailedOperatorAlternative(attempt.condition, failed.check))
        return tuple(failed_tries)

    def _find_failures_if_all_alternatives_fail(
        self, state: State, binding: ObjectBySlot
    ) -> tuple[CheckFailure, ...]:
        """Return the failed check of each alternative (one way for the operator to act) that is tried.

        An alternative is tried if its condition holds. Return () if one succeeds or none is tried.
        """
        failures = []
        for attempt in self.alternatives:
            if attempt.is_attempted(state, binding):
                failed = find_failing_check(attempt.checks, state, binding)
                if failed is None:
                    return ()
                failures.append(CheckFailure(failed, attempt.checks, self._get_arguments(binding)))
        return tuple(failures)

    def _get_arguments(self, binding: ObjectBySlot) -> tuple[int, ...]:
        return tuple(binding[1 : 1 + self.operator.arity])


def find_failing_check(
    checks: Sequence[_CompiledCheck], state: State, binding: ObjectBySlot
) -> _CompiledCheck | None:
    """Return the first check that fails in the state, or None if all checks pass."""
    for check in checks:
        if not check.holds(state, binding):
            return check
    return None


def _compile_checks(checks: Sequence[Check], conditions: ConditionCompiler) -> tuple[_CompiledCheck, ...]:
    compiled_checks = []
    for check in checks:
        condition = conditions.compile_test(check.condition)
        history_conditions: tuple[ConditionTest, ...] = (condition,)
        if check.history_conditions is not None:
            history_conditions = tuple(map(conditions.compile_test, check.history_conditions))
        compiled_checks.append(_CompiledCheck(check, condition, history_conditions))
    return tuple(compiled_checks)


CountTriedValue: TypeAlias = Callable[[], bool]
"""Function that counts one tried value of a parameter, and returns whether the limit is exceeded."""

ApplicableArgumentFinder: TypeAlias = Callable[
    [State, Sequence[int], CountTriedValue], Iterator[tuple[int, ...]]
]
"""Function that yields the arguments for which no check of an operator fails.

Their order is that of `itertools.product`. The function stops early when it has tried too many values of
parameters.
"""


def compile_argument_finder(operator: Operator, vocabulary: Vocabulary) -> ApplicableArgumentFinder:
    """Return a function that finds the arguments for which no check of an operator fails.

    A check of one parameter is evaluated once, for all objects. A check of several parameters waits until
    only its last parameter has no value; it is then evaluated for all values of this parameter at once. The
    operator's alternatives (other ways to act) are not evaluated.
    """
    names = [parameter.name for parameter in operator.parameters]
    single: list[list[Formula]] = [[] for _ in names]
    several: list[list[Formula]] = [[] for _ in names]
    closed: list[Formula] = []
    for check in operator.checks:
        variables = find_free_variables(check.condition)
        positions = [position for position, name in enumerate(names) if name in variables]
        group = (single if len(positions) == 1 else several)[positions[-1]] if positions else closed
        group.append(check.condition)
    frame = SlotAllocator(operator.parameters)
    conditions = ConditionCompiler(vocabulary, frame)
    first = conditions.compile_test(And(tuple(closed)))
    own_filters, joint_filters = [
        [
            conditions.compile_filter(And(tuple(group)), slot, frame.scope)
            for slot, group in enumerate(groups, 1)
        ]
        for groups in (single, several)
    ]

    def generate_arguments_from_parameter(
        state: State,
        binding: ObjectBySlot,
        next_parameter: int,
        objects_in_order: Sequence[int],
        allowed_objects: Sequence[ObjectMask],
        count_tried_value: CountTriedValue,
    ) -> Iterator[tuple[int, ...]]:
        """Yield tuples of arguments that pass the checks, given the arguments before ``next_parameter``.

        ``binding`` holds these first arguments. Parameters are numbered from 1. ``allowed_objects`` has for
        each parameter the mask of the objects that pass the checks of this parameter alone.
        """
        if next_parameter > len(names):
            yield tuple(binding[1:next_parameter])
            return
        matching = joint_filters[next_parameter - 1](state, binding, allowed_objects[next_parameter - 1])
        for index in objects_in_order:
            if matching >> index & 1:
                if count_tried_value():
                    return
                binding[next_parameter] = index
                yield from generate_arguments_from_parameter(
                    state, binding, next_parameter + 1, objects_in_order, allowed_objects, count_tried_value
                )
        binding[next_parameter] = UNBOUND

    def find_applicable_arguments(
        state: State, objects: Sequence[int], count_tried_value: CountTriedValue
    ) -> Iterator[tuple[int, ...]]:
        binding = frame.bind_arguments(state.scene, [UNBOUND] * len(names))
        if not first(state, binding):
            return
        allowed_objects: list[ObjectMask] = []
        for matching in own_filters:
            allowed_objects.append(matching(state, binding, make_mask(objects)))
            if not allowed_objects[-1]:
                return
        yield from generate_arguments_from_parameter(
            state, binding, 1, objects, allowed_objects, count_tried_value
        )

    return find_applicable_arguments
