"""Executing operators on explicit states: the plain semantics of PDDL, against which every plan is checked.

A state is the set of the atoms that are true. Nothing here is shared with the search (`grounding`,
`search`), so that a mistake there cannot hide itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from eai.logic.formula import (
    And,
    Atom,
    Constant,
    Equals,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
    Or,
    Term,
    Variable,
)
from eai.pddl.model import (
    AddEffect,
    Both,
    DeleteEffect,
    Each,
    PddlAction,
    PddlDomain,
    PddlEffect,
    PddlProblem,
    WhenEffect,
    objects_by_type,
    type_of,
)

PddlState = frozenset[Atom]
Valuation = Mapping[str, Constant]


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
    """Executes plans of one domain and problem."""

    def __init__(self, domain: PddlDomain, problem: PddlProblem) -> None:
        self._actions = {action.name: action for action in domain.actions}
        self._objects = objects_by_type(domain, problem)
        self._problem = problem

    @property
    def initial(self) -> PddlState:
        """The state at the start."""
        return frozenset(self._problem.initial)

    def flaw(self, plan: Sequence[PlanStep]) -> PlanFlaw | None:
        """What is wrong with a plan, or None if it can be executed and ends in a state with the goal."""
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
            return f"{step.action} takes {len(action.parameters)} objects"
        for parameter, name in zip(action.parameters, step.arguments, strict=True):
            if name not in self._members(parameter):
                return f"{name} is no {type_of(parameter)}"
        return self._apply(action, state, step)

    def holds(self, formula: Formula, state: PddlState, binding: Valuation) -> bool:
        """Whether a condition holds in a state.

        Raises:
            ValueError: a part of the formula has no meaning in a single state, or a variable is unbound.
        """
        match formula:
            case Atom():
                return _ground(formula, binding) in state
            case Equals(left, right):
                return _object(left, binding) == _object(right, binding)
            case Not(operand):
                return not self.holds(operand, state, binding)
            case And(operands):
                return all(self.holds(operand, state, binding) for operand in operands)
            case Or(operands):
                return any(self.holds(operand, state, binding) for operand in operands)
            case Implies(premise, conclusion):
                return not self.holds(premise, state, binding) or self.holds(conclusion, state, binding)
            case ForAll(variable, body):
                return all(self.holds(body, state, inner) for inner in self._extensions(variable, binding))
            case Exists(variable, body):
                return any(self.holds(body, state, inner) for inner in self._extensions(variable, binding))
            case _:
                raise ValueError(f"{type(formula).__name__} has no meaning in a single state")

    def _apply(self, action: PddlAction, state: PddlState, step: PlanStep) -> PddlState | str:
        objects = map(Constant, step.arguments)
        binding = {parameter.name: item for parameter, item in zip(action.parameters, objects, strict=True)}
        if not self.holds(action.precondition, state, binding):
            return f"the precondition of ({step}) does not hold"
        changes = list(self._changes(action.effect, state, binding))
        deleted = {change.atom for change in changes if isinstance(change, DeleteEffect)}
        added = {change.atom for change in changes if isinstance(change, AddEffect)}
        return (state - deleted) | added

    def _changes(
        self, effect: PddlEffect, state: PddlState, binding: Valuation
    ) -> Iterator[AddEffect | DeleteEffect]:
        """The ground additions and deletions of an effect; all conditions are read in the state before."""
        match effect:
            case AddEffect(atom):
                yield AddEffect(_ground(atom, binding))
            case DeleteEffect(atom):
                yield DeleteEffect(_ground(atom, binding))
            case Both(parts):
                for part in parts:
                    yield from self._changes(part, state, binding)
            case Each(variable, part):
                for inner in self._extensions(variable, binding):
                    yield from self._changes(part, state, inner)
            case WhenEffect(condition, part):
                if self.holds(condition, state, binding):
                    yield from self._changes(part, state, binding)

    def _members(self, variable: Variable) -> tuple[str, ...]:
        return self._objects.get(type_of(variable), ())

    def _extensions(self, variable: Variable, binding: Valuation) -> Iterator[Valuation]:
        return ({**binding, variable.name: Constant(name)} for name in self._members(variable))


def _ground(atom: Atom, binding: Valuation) -> Atom:
    return Atom(atom.predicate, tuple(_object(term, binding) for term in atom.arguments))


def _object(term: Term, binding: Valuation) -> Constant:
    if isinstance(term, Constant):
        return term
    bound = binding.get(term.name)
    if bound is None:
        raise ValueError(f"unbound variable ?{term.name}")
    return bound
