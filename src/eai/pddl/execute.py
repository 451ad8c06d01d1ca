"""Executing operators on explicit states: the plain semantics of PDDL, against which every plan is checked.

A state is the set of the atoms that are true and not derived. Nothing here is shared with the search
(`grounding`, `search`), so that a mistake there cannot hide itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.signature import takes
from eai.pddl.evaluation import DerivedPredicates, Evaluation, PddlState, Valuation, object_of
from eai.planning.search import Effort


@dataclass(frozen=True, slots=True)
class PlanStep:
    """One step of a plan: an operator and its objects."""

    action: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return " ".join((self.action, *self.arguments))


@dataclass(frozen=True, slots=True)
class PlanFlaw:
    """Why a plan is none.

    ``step`` counts from 0, and is the length of the plan if only the goal is missed.
    """

    step: int
    reason: str


class Executor:
    """Executes plans of one domain and problem.

    Args:
        domain: the operators.
        problem: the objects, the initial state and the goal.
        looks: how many objects quantifiers may look at; any number by default.
    """

    def __init__(self, domain: m.PddlDomain, problem: m.PddlProblem, looks: Effort | None = None) -> None:
        self._looks = looks
        self._actions = {action.name: action for action in domain.actions}
        self._objects = m.objects_by_type(domain, problem)
        self._problem = problem
        self._derived = DerivedPredicates(domain.axioms)
        self._last: tuple[PddlState, Evaluation] | None = None

    @property
    def initial(self) -> PddlState:
        """The state at the start."""
        return frozenset(self._problem.initial)

    def flaw(self, plan: Sequence[PlanStep]) -> PlanFlaw | None:
        """The flaw of a plan, or None if it can be executed and ends in a state with the goal."""
        state = self.initial
        for index, step in enumerate(plan):
            result = self.successor(state, step)
            if isinstance(result, str):
                return PlanFlaw(index, result)
            state = result
        return None if self.holds(self._problem.goal, state, {}) else PlanFlaw(len(plan), "goal not reached")

    def successor(self, state: PddlState, step: PlanStep) -> PddlState | str:
        """The state after a step, or in words why it cannot be taken."""
        action = self._actions.get(step.action)
        if action is None:
            return f"no operator {step.action}"
        if len(step.arguments) != len(action.parameters):
            return takes(step.action, len(action.parameters), "object")
        for parameter, name in zip(action.parameters, step.arguments, strict=True):
            if name not in self._members(parameter):
                return f"{name} is no {m.type_of(parameter)}"
        return self._apply(action, state, step)

    def holds(self, formula: f.Formula, state: PddlState, binding: Valuation) -> bool:
        """Whether a condition holds in a state.

        Raises:
            ValueError: a part of the formula has no meaning in a single state, or a variable is unbound.
        """
        return self._evaluation(state).holds(formula, binding)

    def _evaluation(self, state: PddlState) -> Evaluation:
        """The state, ready to be asked; the last one is kept."""
        if self._last is None or self._last[0] is not state:
            self._last = state, Evaluation(state, self._derived, self._objects, self._looks)
        return self._last[1]

    def _apply(self, action: m.PddlAction, state: PddlState, step: PlanStep) -> PddlState | str:
        names = [parameter.name for parameter in action.parameters]
        binding = dict(zip(names, step.arguments, strict=True))
        now = self._evaluation(state)
        if not now.holds(action.precondition, binding):
            return f"the precondition of ({step}) does not hold"
        changes = list(_changes(action.effect, now, binding))
        deleted = {change.atom for change in changes if isinstance(change, m.DeleteEffect)}
        added = {change.atom for change in changes if isinstance(change, m.AddEffect)}
        return (state - deleted) | added

    def _members(self, variable: f.Variable) -> tuple[str, ...]:
        return self._objects.get(m.type_of(variable), ())


def _changes(
    effect: m.PddlEffect, now: Evaluation, binding: Valuation
) -> Iterator[m.AddEffect | m.DeleteEffect]:
    """The ground additions and deletions of an effect; all conditions are read in the state before."""
    match effect:
        case m.AddEffect(atom):
            yield m.AddEffect(_ground(atom, binding))
        case m.DeleteEffect(atom):
            yield m.DeleteEffect(_ground(atom, binding))
        case m.Both(parts):
            for part in parts:
                yield from _changes(part, now, binding)
        case m.Each(variable, part):
            for inner in now.extensions(variable, _guard(part, {variable.name}), binding):
                yield from _changes(part, now, inner)
        case m.WhenEffect(condition, part):
            if now.holds(condition, binding):
                yield from _changes(part, now, binding)


def _guard(effect: m.PddlEffect, bound: set[str]) -> f.Formula:
    """The condition that holds wherever an effect changes anything, as far as that is easy to say."""
    match effect:
        case m.WhenEffect(condition, part):
            return f.And((condition, _guard(part, bound)))
        case m.Each(variable, part) if variable.name not in bound:
            return f.Exists(variable, _guard(part, bound | {variable.name}))
        case m.DeleteEffect(atom):
            return atom
        case _:
            return f.TRUE


def _ground(atom: f.Atom, binding: Valuation) -> f.Atom:
    return f.Atom(atom.predicate, tuple(f.Constant(object_of(term, binding)) for term in atom.arguments))
