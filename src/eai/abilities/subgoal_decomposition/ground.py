"""Actions that a search for a subgoal may take."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.repertoire import Known
from eai.world.executable import CompiledOperator
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.frame import Binding
from eai.world.operator import Role
from eai.world.state import State


class Ground(NamedTuple):
    """An action that may be taken.

    Attributes:
        action: the action.
        known: its operator.
        binding: the operator's variables for its objects; for one search alone.
        possible: what `is_possible_now` has found, by state.
        results: what `after` has found, by state.
        parts: the mask of the parts of the goal that it is for; 0 if it helps another one.
        touched: the mask of the parts that it can change.
    """

    action: Action
    known: Known
    binding: Binding
    possible: dict[State, bool]
    results: dict[State, State]
    parts: int = 0
    touched: int = 0

    @classmethod
    def of(cls, action: Action, known: Known, state: State) -> Ground:
        """An action of an operator, for a new search."""
        return cls(action, known, known.operator.bind(state, action.arguments), {}, {})

    def for_parts(self, parts: int, touched: int) -> Ground:
        """The action as one for some parts, that can change others."""
        return Ground(self.action, self.known, self.binding, self.possible, self.results, parts, touched)

    @property
    def is_achiever(self) -> bool:
        """Whether it changes the world, so that it is taken for a part of the goal and for nothing else."""
        return self.known.role is Role.CHANGE

    def is_possible(self, state: State) -> bool:
        """Whether no check forbids it."""
        return self.known.operator.is_possible(state, self.binding)

    def is_ever_possible(self, state: State) -> bool:
        """Whether what no action changes is as it asks, in any state of the episode."""
        return self.known.fixed(state, self.binding)

    def is_possible_now(self, state: State) -> bool:
        """Whether nothing else forbids it where what is fixed and what is common to all objects do not."""
        found = self.possible.get(state)
        if found is None:
            found = self.possible[state] = self.known.rest(state, self.binding)
        return found

    def may_be_mended(self, state: State) -> bool:
        """Whether all that forbids it, beyond what is fixed and common, is what movement may mend."""
        if not self.known.unmoved(state, self.binding):
            return False
        return not self.known.operator.tries or all(self.known.mended[i] for i in self.failing(state))

    def after(self, state: State) -> State:
        """The state after it, whatever its checks say."""
        found = self.results.get(state)
        if found is None:
            found = self.results[state] = self.known.operator.apply(state, self.binding)
        return found

    def failing(self, state: State) -> list[int]:
        """The numbers of the checks that fail; after the last of them is that of what is tried and fails."""
        checks = self.known.operator.checks
        found = [i for i, check in enumerate(checks) if not check.holds(state, self.binding)]
        return found if found or self.is_possible(state) else [len(checks)]

    def lacking(self, state: State, enough: int) -> int:
        """How many checks fail that movement cannot change, counted up to a number that is enough."""
        found = 0
        for check, moved in zip(self.known.operator.checks, self.known.moved, strict=False):
            if not moved and not check.holds(state, self.binding):
                found += 1
                if found == enough:
                    break
        return found

    def is_hopeless(self, failing: Sequence[int]) -> bool:
        """Whether a check that fails asks for objects of another kind."""
        checks = self.known.operator.checks
        return any(checks[i].check.fault is FaultKind.AFFORDANCE for i in failing if i < len(checks))


def is_needless(operator: CompiledOperator, action: Action, state: State) -> bool:
    """Whether an action says of itself that it is an additional step."""
    failures = operator.failures(state, operator.bind(state, action.arguments))
    return any(failure.check.check.fault is FaultKind.ADDITIONAL_STEP for failure in failures)


def told_apart(plan: Sequence[Action], operators: Collection[str]) -> tuple[Action, ...]:
    """The actions of a plan of which it matters that they are taken."""
    return tuple([action for action in plan if action.operator in operators])
