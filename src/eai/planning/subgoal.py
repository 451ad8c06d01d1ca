"""Subgoals: conditions that must be true, or must be false. Conditions are split into their parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.choice import AndNode, BipartiteMatchingNode, ExactCountNode, OrNode
from eai.world.condition import Scope
from eai.world.frame import AGENT, UNBOUND
from eai.world.relation import iterate_bits
from eai.world.state import Scene


class Subgoal(NamedTuple):
    """A condition that must be true, or must be false if ``truth`` is False.

    ``scope`` maps the free variables of the formula to objects.
    """

    formula: f.Formula
    scope: Scope
    truth: bool

    @property
    def negated(self) -> Subgoal:
        """The negated subgoal, with the opposite truth."""
        return self._replace(truth=not self.truth)


class GroundAtom(NamedTuple):
    """A ground atom, and whether it must be true or false."""

    predicate: str
    arguments: tuple[int, ...]
    truth: bool


SubgoalParts: TypeAlias = (
    AndNode[Subgoal] | OrNode[Subgoal] | ExactCountNode[Subgoal] | BipartiteMatchingNode[Subgoal]
)
"""Parts of a condition, and which parts must hold: all, at least one, a number, or cells of a table.

In a table (`BipartiteMatchingNode`), a number of parts must hold, no two of them in one row or column.
"""


def find_object_indices_of_arguments(atom: f.Atom, scope: Scope, scene: Scene) -> tuple[int, ...]:
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
