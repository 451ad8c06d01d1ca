"""Plans of BEHAVIOR written as subgoals: what each action brings about."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from eai.abilities.subgoal_decomposition.behavior_vocabulary import object_names
from eai.abilities.task import Task
from eai.benchmarks.behavior import domain as behavior
from eai.world.execution import Action, attempt
from eai.world.state import State

STATES = {
    "OPEN": "open({})",
    "CLOSE": "not open({})",
    "TOGGLE_ON": "toggledon({})",
    "TOGGLE_OFF": "not toggledon({})",
    "SLICE": "sliced({})",
    "COOK": "cooked({})",
    "SOAK": "soaked({})",
    "FREEZE": "frozen({})",
    "UNFREEZE": "not frozen({})",
}
"""The state of its object that stands for an action."""

HANDS = {"LEFT": ("in_left_hand", "holds_lh"), "RIGHT": ("in_right_hand", "holds_rh")}
"""What the simulator and what subgoals call it that a hand holds an object."""

PLACES = {"PLACE_INSIDE": "inside", "PLACE_NEXTTO": "nextto", "PLACE_UNDER": "under"}
"""The relation that stands for putting an object somewhere, but for putting it on something."""


def write_subgoals(task: Task, plan: Iterable[Action]) -> tuple[str, ...]:
    """The subgoals that stand for a plan, in order.

    Left out are actions for which no subgoal stands (drying, pouring), and what is no action at all: one
    step of the data set's plans is misspelt.
    """
    domain = behavior.as_meant()
    writer = _Writer(task)
    subgoals: list[str] = []
    state = task.initial
    for action in plan:
        if action.operator not in domain.compiled:
            continue
        subgoals += writer.subgoals(action, state)
        outcome = attempt(domain, [state], action)
        state = outcome if isinstance(outcome, State) else state
    return tuple(subgoals)


def join_subgoals(subgoals: Iterable[str]) -> str:
    """The subgoals as one answer."""
    return json.dumps({"output": list(subgoals)})


class _Writer:
    """Writes one action at a time, with the names of a task's objects."""

    def __init__(self, task: Task) -> None:
        self._names = {index: name for name, index in object_names(task.scene).items()}

    def subgoals(self, action: Action, state: State) -> Iterator[str]:
        """What stands for an action in a state."""
        names = [self._names[i] for i in action.arguments]
        if action.operator in STATES:
            yield STATES[action.operator].format(*names)
        elif action.operator == "CLEAN":
            dirt = "stained" if state.has("is_stained", *action.arguments) else "dusty"
            yield f"not {dirt}({names[0]})"
        else:
            hand, _, verb = action.operator.partition("_")
            if hand in HANDS:
                yield from self._by_hand(hand, verb, action, state)

    def _by_hand(self, hand: str, verb: str, action: Action, state: State) -> Iterator[str]:
        holds, holding = HANDS[hand]
        names = [self._names[i] for i in action.arguments]
        if verb == "GRASP":
            yield f"{holding}({names[0]})"
        elif verb == "RELEASE":
            yield f"not {holding}({names[0]})"
        held = state.those(holds)
        if not held:
            return
        thing = self._names[held.bit_length() - 1]
        if verb in PLACES:
            yield f"{PLACES[verb]}({thing}, {names[0]})"
        elif verb == "PLACE_NEXTTO_ONTOP":
            yield f"nextto({thing}, {names[0]})"
        if verb in ("PLACE_ONTOP", "PLACE_NEXTTO_ONTOP"):
            on = "onfloor" if state.has("floor", action.arguments[-1]) else "ontop"
            yield f"{on}({thing}, {names[-1]})"
