"""Which goals of a BEHAVIOR task hold in a state, and how the paper counts them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import mul
from typing import NamedTuple

from eai.abilities.protocol import Protocol
from eai.abilities.task import Goal, Task
from eai.abilities.verdict import GoalTallies, Tally
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.tasks import RELATIONS
from eai.benchmarks.reference.truncated_options import truncated_options
from eai.logic.formula import And, Atom, Formula, Not, Or
from eai.logic.traversal import walk
from eai.world.condition import Conditions
from eai.world.frame import Binding, Frame, Truth
from eai.world.scene_objects import SceneObjects
from eai.world.state import Scene, State

_NO_ACTIONS = Tally(0, 0)
"""BEHAVIOR has no action goals."""


@dataclass(frozen=True, slots=True)
class Share:
    """How a goal counts: as a state goal, a relation goal, or half of each."""

    state: float
    relation: float


class _Weights(NamedTuple):
    """What each goal counts as one kind of goal, and what all do together."""

    each: tuple[float, ...]
    total: float

    @classmethod
    def of(cls, shares: Iterable[float]) -> _Weights:
        each = tuple(shares)
        return cls(each, sum(each))

    def tally(self, satisfied: Sequence[bool]) -> Tally:
        return Tally(sum(map(mul, satisfied, self.each)), self.total)


class BehaviorGoals:
    """The goals of a task, ready to be checked in any state.

    Under `strict` a goal holds if its formula does. Under `eai-1.0.5` it holds if one of the ground options
    does that bddl keeps (`truncated_options`), where a thing is inside its direct container only
    (``evolving_graph.py`` get_state_dict).
    """

    def __init__(self, task: Task, protocol: Protocol) -> None:
        formulas = [goal.formula for goal in task.goals]
        if protocol is Protocol.EAI_1_0_5:
            formulas = [_as_in_reference(formula, task.scene) for formula in formulas]
        self._tests = tuple(_test(formula, task.scene) for formula in formulas)
        shares = [_share(goal) for goal in task.goals]
        self._of_state = _Weights.of(share.state for share in shares)
        self._of_relation = _Weights.of(share.relation for share in shares)

    def satisfied(self, state: State) -> tuple[bool, ...]:
        """Which goals hold in the state, in order."""
        return tuple([holds(state, binding) for holds, binding in self._tests])

    def tallies(self, satisfied: Sequence[bool]) -> GoalTallies:
        """The goals by kind; one that speaks of states and relations counts half as each."""
        return GoalTallies(self._of_state.tally(satisfied), self._of_relation.tally(satisfied), _NO_ACTIONS)


def _share(goal: Goal) -> Share:
    predicates = {part.predicate for part in walk(goal.formula) if isinstance(part, Atom)}
    relations = bool(predicates & RELATIONS)
    states = bool(predicates - RELATIONS)
    return Share(states / (states + relations), relations / (states + relations))


def _test(formula: Formula, scene: Scene) -> tuple[Truth, Binding]:
    frame = Frame()
    truth = Conditions(scene.vocabulary, frame).truth(formula)
    return truth, frame.bind(scene, ())


def _as_in_reference(formula: Formula, scene: Scene) -> Formula:
    """What the reference asks in a goal's place: that all literals of one of its truncated options hold."""
    options = truncated_options(formula, SceneObjects(scene))
    return Or(tuple(And(tuple(_literal(part) for part in option)) for option in options))


def _literal(literal: Formula) -> Formula:
    """A literal as the reference sees it."""
    if isinstance(literal, Not):
        return Not(_literal(literal.operand))
    if not isinstance(literal, Atom):
        raise TypeError(f"{literal} is no condition of BDDL")
    return replace(literal, predicate=_IN_REFERENCE.get(literal.predicate, literal.predicate))


_IN_REFERENCE: Mapping[str, str] = {"inside": p.directly_inside.name}
