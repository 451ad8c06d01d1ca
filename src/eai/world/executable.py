"""Operators ready to run: their checks and effects as functions of a state and a binding.

For which objects no check of an operator fails, `applicability` says.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from eai.logic.formula import And, Formula
from eai.logic.traversal import free_variables
from eai.world.condition import ConditionCompiler
from eai.world.effect import Apply, EffectCompiler
from eai.world.frame import UNBOUND, Frame, FrameBinding, Truth
from eai.world.operator import Check, Operator
from eai.world.relation import mask_of
from eai.world.state import Draft, State
from eai.world.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True, eq=False)
class _CompiledCheck:
    """A check with its condition, and each formula of what it seeks in the past, as functions.

    It is equal to itself alone, and belongs to one list of checks.
    """

    check: Check
    holds: Truth
    sought: tuple[Truth, ...]


class _CompiledTry(NamedTuple):
    """A try of an operator as functions of a state and a binding."""

    is_made: Truth
    checks: tuple[_CompiledCheck, ...]
    apply: Apply


class Failure(NamedTuple):
    """A check that fails of some objects, in the list of checks of the operator or of one of its tries."""

    check: _CompiledCheck
    checks: tuple[_CompiledCheck, ...]
    arguments: tuple[int, ...]


class _Undone(NamedTuple):
    """A try of an action that fails: the condition that stays as it is, and the check that fails."""

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
        conditions = ConditionCompiler(vocabulary, self._frame)
        effects = EffectCompiler(vocabulary, self._frame)
        self.checks = _compiled(operator.checks, conditions)
        passes = conditions.truth(And(tuple(check.condition for check in operator.checks)))
        self.is_possible: Truth = passes
        if operator.tries:
            self.is_possible = lambda state, binding: (
                passes(state, binding) and not self._failed_tries(state, binding)
            )
        self.tries = tuple(
            _CompiledTry(
                conditions.truth(each.condition),
                _compiled(each.checks, conditions),
                effects.sequence(each.effects),
            )
            for each in operator.tries
        )
        self._apply: Apply | None = effects.sequence(operator.effects) if operator.effects else None

    def bind(self, state: State, arguments: Sequence[int]) -> FrameBinding:
        """The binding of the operator's variables for these arguments."""
        return self._frame.bind(state.scene, arguments)

    def failures(self, state: State, binding: FrameBinding) -> tuple[Failure, ...]:
        """All that is wrong: the first check that fails, or that of every try; empty if it is possible."""
        failed = find_failing_check(self.checks, state, binding)
        if failed is not None:
            return (Failure(failed, self.checks, self._arguments(binding)),)
        return self._failed_tries(state, binding)

    def apply(self, state: State, binding: FrameBinding) -> State:
        """The state after the action, whatever the operator's own checks say."""
        if self._apply is None and not self.tries:
            return state
        draft = Draft(state)
        for each in self.tries:
            if each.is_made(state, binding) and find_failing_check(each.checks, state, binding) is None:
                each.apply(state, draft, binding)
        if self._apply is not None:
            self._apply(state, draft, binding)
        return State(state.scene, tuple(draft.unary), tuple(draft.binary), draft.tuples)

    def find_failed_tries(self, before: State, after: State, binding: FrameBinding) -> tuple[_Undone, ...]:
        """The tries that fail: each try that was made before, and would be made again after."""
        undone = []
        for each, compiled in zip(self.operator.tries, self.tries, strict=True):
            if compiled.is_made(before, binding) and compiled.is_made(after, binding):
                failed = find_failing_check(compiled.checks, before, binding)
                if failed is not None:
                    undone.append(_Undone(each.condition, failed.check))
        return tuple(undone)

    def _failed_tries(self, state: State, binding: FrameBinding) -> tuple[Failure, ...]:
        """The failure of each try that is made; empty if one succeeds or none is made."""
        failures = []
        for each in self.tries:
            if each.is_made(state, binding):
                failed = find_failing_check(each.checks, state, binding)
                if failed is None:
                    return ()
                failures.append(Failure(failed, each.checks, self._arguments(binding)))
        return tuple(failures)

    def _arguments(self, binding: FrameBinding) -> tuple[int, ...]:
        """The arguments that a binding was made for."""
        return tuple(binding[1 : 1 + self.operator.arity])


def find_failing_check(
    checks: Sequence[_CompiledCheck], state: State, binding: FrameBinding
) -> _CompiledCheck | None:
    """The first of the checks that fails in the state, or None."""
    for check in checks:
        if not check.holds(state, binding):
            return check
    return None


def _compiled(checks: Sequence[Check], conditions: ConditionCompiler) -> tuple[_CompiledCheck, ...]:
    found = []
    for check in checks:
        sought = (check.condition,) if check.sought is None else check.sought
        compiled = conditions.truth(check.condition), tuple(map(conditions.truth, sought))
        found.append(_CompiledCheck(check, *compiled))
    return tuple(found)


Spend: TypeAlias = Callable[[], bool]
"""Counts one binding of a variable, and returns whether there were too many."""

FindArguments: TypeAlias = Callable[[State, Sequence[int], Spend], Iterator[tuple[int, ...]]]
"""The arguments among some objects with which no check fails, in the order of `itertools.product`.

They end early when too many values of parameters were looked at.
"""


def applicability(operator: Operator, vocabulary: Vocabulary) -> FindArguments:
    """Return a function that finds the arguments with which no check of an operator fails.

    A check of one parameter is read once for all objects. A check of several parameters is read as soon as
    the last of them has its turn, for all values of that one at once. What the operator tries is not read.
    """
    names = [parameter.name for parameter in operator.parameters]
    alone: list[list[Formula]] = [[] for _ in names]
    together: list[list[Formula]] = [[] for _ in names]
    closed: list[Formula] = []
    for check in operator.checks:
        about = free_variables(check.condition)
        places = [place for place, name in enumerate(names) if name in about]
        asked = (alone if len(places) == 1 else together)[places[-1]] if places else closed
        asked.append(check.condition)
    frame = Frame(operator.parameters)
    conditions = ConditionCompiler(vocabulary, frame)
    first = conditions.truth(And(tuple(closed)))
    own, joint = [
        [conditions.extension(And(tuple(asked)), slot, frame.scope) for slot, asked in enumerate(parts, 1)]
        for parts in (alone, together)
    ]

    def complete(
        state: State,
        binding: FrameBinding,
        slot: int,
        objects: Sequence[int],
        among: Sequence[int],
        spend: Spend,
    ) -> Iterator[tuple[int, ...]]:
        """Yield the arguments that begin with those of a binding before a slot."""
        if slot > len(names):
            yield tuple(binding[1:slot])
            return
        matching = joint[slot - 1](state, binding, among[slot - 1])
        for index in objects:
            if matching >> index & 1:
                if spend():
                    return
                binding[slot] = index
                yield from complete(state, binding, slot + 1, objects, among, spend)
        binding[slot] = UNBOUND

    def arguments(state: State, objects: Sequence[int], spend: Spend) -> Iterator[tuple[int, ...]]:
        binding = frame.bind(state.scene, [UNBOUND] * len(names))
        if not first(state, binding):
            return
        among: list[int] = []
        for matching in own:
            among.append(matching(state, binding, mask_of(objects)))
            if not among[-1]:
                return
        yield from complete(state, binding, 1, objects, among, spend)

    return arguments
