"""How far a trajectory has come with a goal, kept up to date step by step.

The goal is a sequence of state formulas, ``f1 then f2 then ...`` (as all goals of the data set are): the
first part is met at the earliest position at which it holds, each further part at the earliest one after
that. An action belongs to the position of the state in which it is taken; the last position has none. So the
number of parts met so far is all that a search has to know of the past. This is `eai.logic.semantics` for
such sequences, step by step (held equal by a test).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import eai.logic.formula as f
from eai.errors import InputError
from eai.logic.rewriting import Leaf, rewrite
from eai.logic.traversal import is_state_formula, walk
from eai.world.condition import Conditions
from eai.world.execution import Action, Step, Trajectory
from eai.world.frame import UNBOUND, Frame, Truth
from eai.world.state import Scene, State

_ARGUMENTS = (f.Variable("argument 1"), f.Variable("argument 2"))
"""Stand for the objects of the action; their blanks keep them apart from the variables of any formula."""


class StateTest:
    """A closed formula on one state, compiled for a scene, where objects go by their names.

    Raises:
        DomainError: the formula uses a predicate or an object that there is not, or is no state formula.
    """

    __slots__ = ("_binding", "_truth")

    def __init__(self, formula: f.Formula, scene: Scene) -> None:
        frame = Frame(_ARGUMENTS)
        self._truth: Truth = Conditions(scene.vocabulary, frame).truth(formula)
        self._binding = tuple(frame.bind(scene, (UNBOUND, UNBOUND)))

    def __call__(self, state: State, arguments: tuple[int, ...] = ()) -> bool:
        """Whether it holds in the state; ``arguments`` are those of the action taken there."""
        binding = [*self._binding]  # quantifiers write into it, in any number of threads
        if arguments:
            binding[1 : 1 + len(arguments)] = arguments
        return self._truth(state, binding)


class _Part:
    """One part of a goal: a formula on a state and the action taken there."""

    __slots__ = ("_actions", "_formula", "_scene", "_tests")

    def __init__(self, formula: f.Formula, scene: Scene) -> None:
        self._formula = formula
        self._scene = scene
        self._actions = frozenset([part.action for part in walk(formula) if isinstance(part, f.Occurs)])
        self._tests: dict[str | None, StateTest] = {}

    def holds(self, state: State, action: Action | None) -> bool:
        """Whether the part holds at a position."""
        if action is None or action.operator not in self._actions:
            return (self._tests.get(None) or self._test(None))(state)
        return self._test(action.operator)(state, action.arguments)

    def _test(self, name: str | None) -> StateTest:
        """The part where an action of this name, or none that it mentions, is taken."""
        test = self._tests.get(name)
        if test is None:
            formula = self._formula
            at_action = (
                rewrite(formula, lambda leaf, _: _with_action(leaf, name)) if self._actions else formula
            )
            test = self._tests[name] = StateTest(at_action, self._scene)
        return test


def _with_action(leaf: Leaf, name: str | None) -> f.Formula:
    """A leaf where the action of this name is taken: its occurrence becomes equality of the objects."""
    if not isinstance(leaf, f.Occurs):
        return leaf
    if leaf.action != name:
        return f.FALSE
    pairs = zip(leaf.arguments, _ARGUMENTS, strict=False)
    return f.And(tuple(f.Equals(term, argument) for term, argument in pairs))


class GoalProgress:
    """The parts of a goal over a scene.

    Args:
        goal: the parts, to be met one after the other.
        scene: the scene.
        at_end: whether the last state is as it must be besides; None asks for nothing.

    Attributes:
        actions: the operators that it asks for.

    Raises:
        InputError: the goal is not a sequence of state formulas.
        DomainError: it uses a predicate or an object that there is not.
    """

    def __init__(self, goal: f.Formula, scene: Scene, at_end: Callable[[State], bool] | None = None) -> None:
        parts = goal.parts if isinstance(goal, f.Then) else (goal,)
        for part in parts:
            if not is_state_formula(part):
                raise InputError("a goal must be a sequence of state formulas, 'f then g then ...'")
        self._parts = tuple(_Part(part, scene) for part in parts)
        self._at_end = at_end
        self.actions = frozenset([e.action for part in parts for e in walk(part) if isinstance(e, f.Occurs)])

    def advance(self, met: int, state: State, action: Action) -> int:
        """How many parts are met after a position, of which ``met`` were before it."""
        if met < len(self._parts) and self._parts[met].holds(state, action):
            return met + 1
        return met

    def reached(self, met: int, final: State) -> bool:
        """Whether the goal is reached where a trajectory ends; its last state may meet the last part."""
        missing = len(self._parts) - met
        met_by_now = missing == 0 or (missing == 1 and self._parts[-1].holds(final, None))
        return met_by_now and (self._at_end is None or self._at_end(final))


class Watched:
    """Progress with a goal on the whole course besides: of its past nothing may be forgotten.

    Pasts are numbered, equal ones alike, so that no two branches meet that have come different ways. For one
    search.

    Args:
        progress: the progress with the parts to be met.
        holds: whether what is asked of a whole course holds on it.
    """

    def __init__(self, progress: GoalProgress, holds: Callable[[Trajectory], bool]) -> None:
        self._progress = progress
        self._holds = holds
        self._pasts: list[_Past] = [_Past(0)]
        self._numbers: dict[tuple[int, State, Action], int] = {}

    def advance(self, met: int, state: State, action: Action) -> int:
        """The number of the past that is another one with one step more."""
        key = (met, state, action)
        if key not in self._numbers:
            self._numbers[key] = len(self._pasts)
            progress = self._progress.advance(self._pasts[met].met, state, action)
            self._pasts.append(_Past(progress, met, state, action))
        return self._numbers[key]

    def reached(self, met: int, final: State) -> bool:
        """Whether a course with this past that ends here is as it must be."""
        if not self._progress.reached(self._pasts[met].met, final):
            return False
        states, steps = [final], []
        past = self._pasts[met]
        while past.action is not None and past.state is not None:
            states.append(past.state)
            steps.append(Step(past.action, None))
            past = self._pasts[past.before]
        return self._holds(Trajectory(tuple(states[::-1]), tuple(steps[::-1])))


class _Past(NamedTuple):
    """How far a course has come, the number of the past before its last step, and that step."""

    met: int
    before: int = 0
    state: State | None = None
    action: Action | None = None
