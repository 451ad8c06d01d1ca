"""Which goals of a BEHAVIOR task hold in a state, and how the paper counts them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from eai.abilities.protocol import Protocol
from eai.abilities.verdict import GoalTallies, Tally
from eai.data.behavior_tasks import RELATIONS
from eai.data.task import Goal, Task
from eai.domains.behavior import predicates as p
from eai.logic.formula import Atom, Formula, Not
from eai.logic.options import Option
from eai.logic.traversal import walk
from eai.logic.truncated_options import truncated_options
from eai.world.condition import Conditions
from eai.world.frame import Binding, Frame, Truth
from eai.world.state import Scene, State

_NO_ACTIONS = Tally(0, 0)
"""BEHAVIOR has no action goals."""

_Test: TypeAlias = Callable[[State], bool]


@dataclass(frozen=True, slots=True)
class Share:
    """How a goal counts: as a state goal, a relation goal, or half of each."""

    state: float
    relation: float


class BehaviorGoals:
    """The goals of a task, ready to be checked in any state.

    Under `strict` a goal holds if its formula does. Under `eai-1.0.5` it holds if one of the ground options
    does that bddl keeps (`truncated_options`), where a thing is inside its direct container only
    (``evolving_graph.py`` get_state_dict).
    """

    def __init__(self, task: Task, protocol: Protocol) -> None:
        compiler = _Compiler(task.scene)
        as_in_reference = protocol is Protocol.EAI_1_0_5
        make = compiler.any_option if as_in_reference else compiler.truth
        self._tests: tuple[_Test, ...] = tuple(make(goal.formula) for goal in task.goals)
        self._shares = tuple(_share(goal) for goal in task.goals)
        self._total = Share(
            sum(share.state for share in self._shares), sum(share.relation for share in self._shares)
        )

    def satisfied(self, state: State) -> tuple[bool, ...]:
        """Which goals hold in the state, in order."""
        return tuple([holds(state) for holds in self._tests])

    def tallies(self, satisfied: Sequence[bool]) -> GoalTallies:
        """The goals by kind; one that speaks of states and relations counts half as each."""
        state = relation = 0.0
        for share, holds in zip(self._shares, satisfied, strict=True):
            if holds:
                state += share.state
                relation += share.relation
        return GoalTallies(
            Tally(state, self._total.state), Tally(relation, self._total.relation), _NO_ACTIONS
        )


def _share(goal: Goal) -> Share:
    predicates = {part.predicate for part in walk(goal.formula) if isinstance(part, Atom)}
    relations = bool(predicates & RELATIONS)
    states = bool(predicates - RELATIONS)
    return Share(states / (states + relations), relations / (states + relations))


@dataclass(frozen=True, slots=True)
class SceneObjects:
    """The objects of a scene by category, for quantifiers."""

    scene: Scene

    def objects(self, category: str | None) -> Sequence[str]:
        """The names of the objects of a category, in the scene's order."""
        return self.scene.names(self.scene.category(category))


class _Compiler:
    """Turns the goals of one task into tests; equal conditions share one test."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._compiled: dict[Atom, tuple[Truth, Binding]] = {}

    def truth(self, formula: Formula) -> _Test:
        """Whether the formula holds."""
        truth, binding = self._compile(formula)
        return lambda state: truth(state, binding)

    def any_option(self, formula: Formula) -> _Test:
        """Whether all conditions of one of the formula's truncated options hold."""
        found = [self._option(option) for option in truncated_options(formula, SceneObjects(self._scene))]
        if len(found) == 1:
            return found[0]

        def test(state: State) -> bool:
            return any(holds(state) for holds in found)

        return test

    def _option(self, option: Option) -> _Test:
        literals = [self._literal(literal) for literal in option]

        def test(state: State) -> bool:
            for truth, binding, wanted in literals:  # noqa: SIM110 - a loop is faster than all()
                if truth(state, binding) is not wanted:
                    return False
            return True

        return test

    def _literal(self, literal: Formula) -> tuple[Truth, Binding, bool]:
        wanted = True
        while isinstance(literal, Not):
            literal, wanted = literal.operand, not wanted
        if not isinstance(literal, Atom):
            raise TypeError(f"{literal} is no condition of BDDL")
        if literal not in self._compiled:
            self._compiled[literal] = self._compile(_as_the_reference_sees(literal))
        return (*self._compiled[literal], wanted)

    def _compile(self, formula: Formula) -> tuple[Truth, Binding]:
        frame = Frame()
        truth = Conditions(self._scene.vocabulary, frame).truth(formula)
        return truth, frame.bind(self._scene, ())


_IN_REFERENCE: Mapping[str, str] = {"inside": p.directly_inside.name}


def _as_the_reference_sees(atom: Atom) -> Atom:
    return replace(atom, predicate=_IN_REFERENCE.get(atom.predicate, atom.predicate))
