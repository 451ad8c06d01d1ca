"""Plans whose steps BEHAVIOR subgoals can stand for: for the built-in planner.

A subgoal is translated into the action that brings it about and, before it, what that action needs of the
hands; the planner chooses actions and carries out those translations.
"""

from __future__ import annotations

from collections.abc import Iterable

from eai.abilities.subgoal_decomposition.behavior_translation import held
from eai.abilities.subgoal_decomposition.behavior_writer import HANDS
from eai.abilities.task import Task
from eai.benchmarks.behavior import domain as behavior
from eai.planning.planner import Planner
from eai.world.execution import Action
from eai.world.state import State

_UNWRITTEN = (
    "NAVIGATE_TO",
    "DRY",
    *(
        f"{hand}_{verb}"
        for hand in HANDS
        for verb in ("TRANSFER_CONTENTS_INSIDE", "TRANSFER_CONTENTS_ONTOP", "PLACE_NEXTTO_ONTOP")
    ),
)
"""Actions for which no single subgoal stands."""


def subgoal_planner() -> Planner:
    """A planner under protocol `strict` whose steps can each be written as a subgoal."""
    return Planner(behavior.as_meant().with_operators(without=_UNWRITTEN), _carry_out)


def carried_out(task: Task, plan: Iterable[Action]) -> tuple[Action, ...]:
    """All that is done when a plan of `subgoal_planner` is carried out."""
    compiled = behavior.as_meant().compiled
    state = task.initial
    steps: list[Action] = []
    for action in plan:
        for step in _carry_out(action, state):
            steps.append(step)
            operator = compiled[step.operator]
            state = operator.apply(state, operator.bind(state, step.arguments))
    return tuple(steps)


def _carry_out(action: Action, state: State) -> tuple[Action, ...]:
    """The action; if it wants a free hand and there is none, the right one first lets go of what it holds."""
    hand, _, _ = action.operator.partition("_")
    hands = held(state)
    if hand in HANDS or hands.left is None or hands.right is None:
        return (action,)
    return Action("RIGHT_RELEASE", (hands.right,)), action
