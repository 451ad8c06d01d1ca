"""Subgoals: conditions that must be true, or must be false. Conditions are split into their parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.choice import AllOf, AndOrTreePairing, AnyOf, ExactlyOf
from eai.world.condition import FormulaEvaluator, Scope
from eai.world.frame import AGENT, UNBOUND
from eai.world.relation import iterate_bits
from eai.world.state import Scene, State


class Subgoal(NamedTuple):
    """A condition that must be true, or (``truth`` False) false; ``scope`` maps free variables to objects."""

    formula: f.Formula
    scope: Scope
    truth: bool

    @property
    def negated(self) -> Subgoal:
        """The subgoal with the opposite truth."""
        return self._replace(truth=not self.truth)


class GroundAtom(NamedTuple):
    """A ground atom, and whether it must be true or false."""

    predicate: str
    arguments: tuple[int, ...]
    truth: bool


SubgoalParts: TypeAlias = AllOf[Subgoal] | AnyOf[Subgoal] | ExactlyOf[Subgoal] | AndOrTreePairing[Subgoal]
"""Parts of a condition, and which of them must hold: all, at least one, an exact number, or pairs.

For pairs, the parts form a table: a number of parts must hold, no two of them in one row or column.
"""


class SubgoalSplitter:
    """Splits conditions into their parts, given one state.

    Args:
        evaluator: evaluates the formulas of the domain.
        state: the state.
        objects: the objects that actions may use.
    """

    def __init__(self, evaluator: FormulaEvaluator, state: State, objects: Sequence[int]) -> None:
        self._evaluator = evaluator
        self._state = state
        self._objects = objects

    def holds(self, subgoal: Subgoal) -> bool:
        """Whether a subgoal is reached in the state."""
        formula, scope, truth = subgoal
        return self._evaluator.holds(formula, scope, self._state) == truth

    def ground_atom(self, atom: f.Atom, subgoal: Subgoal) -> GroundAtom:
        """Return a subgoal's atom with objects in place of its terms."""
        arguments = find_argument_indices(atom, subgoal.scope, self._state.scene)
        return GroundAtom(atom.predicate, arguments, subgoal.truth)

    def split_into_parts(self, subgoal: Subgoal) -> SubgoalParts | None:
        """Return the parts of a compound condition and how many must hold; None for other conditions."""
        formula, scope, truth = subgoal
        match formula:
            case f.Not(operand):
                return AllOf((Subgoal(operand, scope, not truth),))
            case f.And(operands) | f.Or(operands):
                parts = tuple([Subgoal(operand, scope, truth) for operand in operands])
                return AllOf(parts) if isinstance(formula, f.And) == truth else AnyOf(parts)
            case f.Implies(premise, conclusion):
                either = (Subgoal(premise, scope, not truth), Subgoal(conclusion, scope, truth))
                return AnyOf(either) if truth else AllOf(either)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                if isinstance(formula, f.Exists) == truth:
                    values = (
                        self._find_objects_meeting_a_conjunct(variable, body, scope)
                        if truth
                        else self._find_usable_objects(variable)
                    )
                    return AnyOf(self._make_instances(variable, body, scope, truth, values))
                violating = self._find_violating_values(variable, body, scope, truth)
                return AllOf(self._make_instances(variable, body, scope, truth, violating))
            case f.Exactly(count, variable, body) if truth:
                return ExactlyOf(
                    count, self._make_instances(variable, body, scope, truth, self._find_all_values(variable))
                )
            case f.ForPairs() if truth:
                return self._make_object_pairing(formula, scope)
            case _:
                return None

    def _make_instances(
        self, variable: f.Variable, body: f.Formula, scope: Scope, truth: bool, values: Sequence[int]
    ) -> tuple[Subgoal, ...]:
        return tuple([Subgoal(body, {**scope, variable.name: value}, truth) for value in values])

    def _find_all_values(self, variable: f.Variable) -> list[int]:
        return list(iterate_bits(self._state.scene.get_category_mask(variable.category)))

    def _find_usable_objects(self, variable: f.Variable) -> list[int]:
        allowed = self._state.scene.get_category_mask(variable.category)
        return [i for i in self._objects if allowed >> i & 1]

    def _find_objects_meeting_a_conjunct(
        self, variable: f.Variable, body: f.Formula, scope: Scope
    ) -> list[int]:
        """Return the values of a variable for which at least one conjunct of the body holds.

        Values are objects that actions may use. If no conjunct holds for any value, return all values.
        """
        usable = self._find_usable_objects(variable)
        parts = body.operands if isinstance(body, f.And) else ()
        promising = {
            i for part in parts for i in self._evaluator.find_witnesses(variable, part, scope, self._state)
        }
        return [i for i in usable if i in promising] or usable

    def _find_violating_values(
        self, variable: f.Variable, body: f.Formula, scope: Scope, truth: bool
    ) -> list[int]:
        holding = self._evaluator.find_witnesses(variable, body, scope, self._state)
        if not truth:
            return list(holding)
        held = set(holding)
        return [i for i in self._find_all_values(variable) if i not in held]

    def _make_object_pairing(self, formula: f.ForPairs, scope: Scope) -> AndOrTreePairing[Subgoal]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._find_all_values(first), self._find_all_values(second)
        count = min(len(rows), len(columns)) if formula.count is None else formula.count
        return AndOrTreePairing(
            count,
            tuple(
                tuple(
                    None if x == y else Subgoal(body, {**scope, first.name: x, second.name: y}, True)
                    for y in columns
                )
                for x in rows
            ),
        )


def find_argument_indices(atom: f.Atom, scope: Scope, scene: Scene) -> tuple[int, ...]:
    """Return the indices of the objects that the terms of an atom denote."""
    return tuple(
        [scope[t.name] if isinstance(t, f.Variable) else find_object(t, scene) for t in atom.arguments]
    )


def find_object(constant: f.Constant, scene: Scene) -> int:
    """Return the index of the object that a constant names; `UNBOUND` for an agent that the scene lacks."""
    if constant == AGENT:
        return UNBOUND if scene.agent is None else scene.agent
    return scene.index[constant.name]


def make_subgoals(conditions: Iterable[f.Formula], scene: Scene) -> tuple[Subgoal, ...]:
    """Return the conjuncts of closed conditions as subgoals, in order."""
    return tuple(
        [part for condition in conditions for part in split_conjuncts(Subgoal(condition, {}, True), scene)]
    )


def split_conjuncts(subgoal: Subgoal, scene: Scene) -> Iterator[Subgoal]:
    """Yield the parts of a subgoal that must all be reached, each as a subgoal."""
    formula, scope, truth = subgoal
    match formula:
        case f.Not(operand):
            yield from split_conjuncts(Subgoal(operand, scope, not truth), scene)
        case f.And(operands) | f.Or(operands) if isinstance(formula, f.And) == truth:
            for part in operands:
                yield from split_conjuncts(Subgoal(part, scope, truth), scene)
        case f.ForAll(variable, body) | f.Exists(variable, body) if isinstance(formula, f.ForAll) == truth:
            for value in iterate_bits(scene.get_category_mask(variable.category)):
                yield from split_conjuncts(Subgoal(body, {**scope, variable.name: value}, truth), scene)
        case _:
            yield subgoal
