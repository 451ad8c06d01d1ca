"""Plans of BEHAVIOR written as subgoals: what each action brings about.

A subgoal is translated into the action that brings it about and, before it, what that action needs of the
hands; so the planner chooses actions and carries out those translations.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from eai.abilities.task import Task
from eai.households.behavior import domain as behavior
from eai.households.behavior.subgoal_vocabulary import object_names
from eai.planning.planner import Planner
from eai.reference.behavior_translation import held
from eai.world.execution import Action, attempt
from eai.world.past import Past
from eai.world.state import State, change

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

POURING = ("TRANSFER_CONTENTS_INSIDE", "TRANSFER_CONTENTS_ONTOP")
"""What moves all that is in or on what the hand holds."""

LYING = {"lies_in": "inside", "lies_on": "ontop", "stands_on": "onfloor"}
"""What the simulator and what subgoals call it that an object rests somewhere."""

_UNWRITTEN = (
    "NAVIGATE_TO",
    "DRY",
    *(f"{hand}_{verb}" for hand in HANDS for verb in (*POURING, "PLACE_NEXTTO_ONTOP")),
)
"""Actions for which no single literal stands."""


def write_subgoals(task: Task, plan: Iterable[Action]) -> tuple[str, ...]:
    """The subgoals that stand for a plan, in order.

    Left out are actions for which no subgoal stands (drying), and what is no action at all: one step of the
    data set's plans is misspelt.
    """
    domain = behavior.as_meant()
    writer = _Writer(task)
    subgoals: list[str] = []
    state = task.initial
    for action in plan:
        if action.operator not in domain.compiled:
            continue
        outcome = attempt(domain, Past(state), action)
        after = outcome if isinstance(outcome, State) else state
        subgoals += writer.subgoals(action, state, after)
        state = after
    return tuple(subgoals)


def subgoal_planner() -> Planner:
    """A planner whose steps can each be written as a subgoal."""
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


class _Writer:
    """Writes one action at a time, with the names of a task's objects."""

    def __init__(self, task: Task) -> None:
        self._names = {index: name for name, index in object_names(task.scene).items()}

    def subgoals(self, action: Action, state: State, after: State) -> Iterator[str]:
        """What stands for an action that leads from a state to another."""
        names = [self._names[i] for i in action.arguments]
        if action.operator in STATES:
            yield STATES[action.operator].format(*names)
        elif action.operator == "CLEAN":
            (thing,) = action.arguments
            stain_goes = state.has("is_stained", thing) and not after.has("is_stained", thing)
            yield f"not {'stained' if stain_goes else 'dusty'}({names[0]})"
        else:
            hand, _, verb = action.operator.partition("_")
            if verb in POURING:
                yield from self._poured(state, after)
            elif hand in HANDS:
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

    def _poured(self, state: State, after: State) -> Iterator[str]:
        """Where everything that is poured comes to lie, as one subgoal; nothing where nothing is."""
        lying = [
            f"{LYING[predicate]}({', '.join([self._names[i] for i in arguments])})"
            for predicate, arguments in change(state, after).added
            if predicate in LYING
        ]
        if lying:
            yield " and ".join(lying)
