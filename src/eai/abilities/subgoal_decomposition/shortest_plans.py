"""The default translation: what shall hold is brought about by the shortest sequence of a few actions.

A *deed* is an action that changes more than where the agent is, what it faces and its posture. For each
literal of a conjunction a few deeds may be done, in any order, with whatever movement that takes. So the
goal of a task is no subgoal, unless a few deeds reach it. All shortest sequences are found: which hand, which
of several ways, is left to the search that carries out the whole answer. Effort is bounded by a number of
states, never by time; operators and objects are tried in their order.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from eai.abilities.subgoal_decomposition.program import Plan
from eai.abilities.subgoal_decomposition.progress import StateTest
from eai.abilities.subgoal_decomposition.translation import Plans, Translation
from eai.abilities.task import Task
from eai.logic.formula import And, Atom, Constant, Formula, Not
from eai.logic.traversal import walk
from eai.planning.achievers import Achievers
from eai.planning.effect_schema import EffectSchema, effect_schemas
from eai.planning.subgoal import GroundAtom
from eai.planning.successor_generator import applicable_actions
from eai.world.derived import stored_sources
from eai.world.domain import Domain
from eai.world.effect import ANYTHING
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.frame import AGENT
from eai.world.operator import Operator
from eai.world.state import Scene, State


@dataclass(frozen=True, slots=True)
class Bounds:
    """How far a search for the plans of one subgoal goes.

    Attributes:
        deeds: deeds for each literal; two are enough to take a thing and to put it somewhere.
        states: states that may be expanded.
        plans: the most plans that are found.
    """

    deeds: int = 2
    states: int = 300
    plans: int = 16


class ShortestPlans(Translation):
    """Finds the plans for subgoals of one domain by breadth-first search on its declaration.

    Args:
        domain: the domain.
        movement: the operators that are no deeds; by default those that `is_movement` tells.
        bounds: how far to search.
    """

    whole = True

    def __init__(
        self, domain: Domain, movement: Collection[str] | None = None, bounds: Bounds | None = None
    ) -> None:
        self._domain = domain
        self._bounds = bounds or Bounds()
        self._achievers = Achievers(domain)
        self._movement = tuple(
            [o for o in domain.operators if (is_movement(o) if movement is None else o.name in movement)]
        )

    def brings_about(self, literal: GroundAtom, scene: Scene) -> bool:
        """Whether any action changes what the literal is about."""
        predicate, _, truth = literal
        if self._domain.vocabulary.stored(predicate) is not None:
            return bool(self._achievers.of(predicate, adding=truth))
        return bool(self._achievers.writers(stored_sources([predicate], self._domain.vocabulary)))

    def plans(self, literals: Sequence[GroundAtom], task: Task) -> Plans:
        """All shortest plans after which the literals hold; none where they hold, and where none is found."""
        named = [i for literal in literals for i in literal.arguments]
        holds = StateTest(And(tuple([_formula(literal, task.scene) for literal in literals])), task.scene)
        deeds = [o for o in self._relevant(literals) if o not in self._movement]
        moves = _Moves(self._domain, self._movement, deeds, _objects(task, named))
        most = self._bounds.deeds * len(literals)
        return lambda state: () if holds(state) else self._shortest(state, moves, most, holds)

    def plans_to_take(self, action: Action, task: Task) -> Plans:
        """The action after the shortest movement that makes it possible, or else the action alone."""
        moves = _Moves(self._domain, self._movement, (), _objects(task, action.arguments))
        operator = self._domain.compiled[action.operator]

        def possible(state: State) -> bool:
            return operator.is_possible(state, operator.bind(state, action.arguments))

        def plans(state: State) -> Sequence[Plan]:
            failures = operator.failures(state, operator.bind(state, action.arguments))
            kinds = {failure.check.check.fault for failure in failures}
            if not kinds or FaultKind.ADDITIONAL_STEP in kinds:
                return ((action,),)
            found = self._shortest(state, moves, 0, possible)
            return ((*found[0], action),) if found else ((action,),)

        return plans

    def _relevant(self, literals: Sequence[GroundAtom]) -> Iterable[Operator]:
        """The operators that can bring literals about, and those that change what these ask for."""
        vocabulary = self._domain.vocabulary
        predicates = stored_sources([literal.predicate for literal in literals], vocabulary)
        for _ in range(self._bounds.deeds - 1):
            operators = self._achievers.writers(predicates)
            asked = {name for operator in operators for name in _asked(operator)}
            predicates = list(dict.fromkeys([*predicates, *stored_sources(sorted(asked), vocabulary)]))
        names = {operator.name for operator in self._achievers.writers(predicates)}
        return [operator for operator in self._domain.operators if operator.name in names]

    def _shortest(self, start: State, moves: _Moves, deeds: int, holds: _Test) -> Sequence[Plan]:
        """The shortest plans to a state in which something holds that does not at the start."""
        found: list[Plan] = []
        fewest = {start: 0}  # deeds
        queue = deque([_Node(start, 0, ())])
        for _ in range(self._bounds.states):
            if not queue or (found and len(queue[0].plan) >= len(found[0])):
                break
            node = queue.popleft()
            for action, is_deed in moves.of(node.state, with_deeds=node.deeds < deeds):
                after = _Node(moves.after(node.state, action), node.deeds + is_deed, (*node.plan, action))
                if holds(after.state):
                    found.append(after.plan)
                    if len(found) == self._bounds.plans:
                        return found
                elif after.deeds < fewest.get(after.state, deeds + 1):
                    fewest[after.state] = after.deeds
                    queue.append(after)
        return found


_Test: TypeAlias = Callable[[State], bool]


class _Node(NamedTuple):
    """A state that was reached, the number of deeds that it took, and the way."""

    state: State
    deeds: int
    plan: tuple[Action, ...]


class _Moves:
    """The movements and deeds by some operators on some objects."""

    def __init__(
        self, domain: Domain, movement: Sequence[Operator], deeds: Sequence[Operator], objects: Sequence[int]
    ) -> None:
        self._domain = domain
        self._movement = movement
        self._deeds = deeds
        self._objects = objects

    def of(self, state: State, *, with_deeds: bool) -> Iterator[tuple[Action, bool]]:
        """Everything that can be done in a state, and whether it is a deed; deeds first."""
        for operators, is_deed in ((self._deeds if with_deeds else (), True), (self._movement, False)):
            for operator in operators:
                for action in applicable_actions(self._domain, operator, state, self._objects):
                    yield action, is_deed

    def after(self, state: State, action: Action) -> State:
        """The state after an action that is possible."""
        operator = self._domain.compiled[action.operator]
        return operator.apply(state, operator.bind(state, action.arguments))


def is_movement(operator: Operator) -> bool:
    """Whether an operator changes nothing but where the agent is, what it faces and its posture.

    That is told from its effects: they change what is true of the agent alone, and relations in which the
    agent stands to something else afterwards instead of what it was (``at(agent, *)`` is deleted and
    ``at(agent, x)`` added). What the agent takes along changes in the same relations.
    """
    changes = list(effect_schemas(operator))
    own = {change.atom.predicate for change in changes if change.atom.arguments == (AGENT,)}
    left = {change.atom.predicate for change in changes if _is_left(change)}
    related = [change for change in changes if len(change.atom.arguments) == 2]
    taken = {change.atom.predicate for change in related if change.adds and AGENT in change.atom.arguments}
    return bool(changes) and all(change.atom.predicate in own | (left & taken) for change in changes)


def _is_left(change: EffectSchema) -> bool:
    """Whether a change ends the agent's relation to whatever it is, and not to an argument only."""
    if change.adds or AGENT not in change.atom.arguments or len(change.atom.arguments) != 2:
        return False
    (other,) = [term for term in change.atom.arguments if term != AGENT] or [AGENT]
    return other == ANYTHING or other not in change.operator.parameters


def _objects(task: Task, named: Iterable[int]) -> tuple[int, ...]:
    """What actions may be about: the objects of the task and those that are named, each once."""
    return tuple(dict.fromkeys([*task.relevant, *named]))


def _formula(literal: GroundAtom, scene: Scene) -> Formula:
    terms = tuple([Constant(scene.objects[i].name) for i in literal.arguments])
    atom = Atom(literal.predicate, terms)
    return atom if literal.truth else Not(atom)


def _asked(operator: Operator) -> Iterator[str]:
    """The predicates that the checks and conditional effects of an operator ask for."""
    for change in effect_schemas(operator):
        for formula in (*change.checks, *change.given):
            yield from (part.predicate for part in walk(formula) if isinstance(part, Atom))
