"""Translate published planning operators of BEHAVIOR to its household actions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from eai.benchmarks.behavior.notation import BehaviorGoalNotation
from eai.benchmarks.counterparts import Counterpart, translate_steps
from eai.pddl.execute import PlanStep
from eai.tasks.task import Task
from eai.world.action import Action

_CLEANING = (
    "clean_stained_brush",
    "clean_stained_cloth",
    "clean_stained_handowel",
    "clean_stained_towel",
    "clean_stained_dishtowel",
    "clean_stained_dishwasher",
    "clean_stained_rag",
    "clean_dusty_rag",
    "clean_dusty_towel",
    "clean_dusty_cloth",
    "clean_dusty_brush",
    "clean_dusty_vacuum",
)

COUNTERPARTS: Mapping[str, Counterpart] = {
    "navigate_to": ("NAVIGATE_TO", (0,)),
    "grasp": ("GRASP", (0,)),
    "release": ("RELEASE", (0,)),
    "place_ontop": ("PLACE_ONTOP", (1,)),
    "place_inside": ("PLACE_INSIDE", (1,)),
    "place_onfloor": ("PLACE_ONTOP", (1,)),
    "place_nextto": ("PLACE_NEXTTO", (1,)),
    "place_nextto_ontop": ("PLACE_NEXTTO_ONTOP", (1, 2)),
    "place_under": ("PLACE_UNDER", (1,)),
    "open": ("OPEN", (0,)),
    "close": ("CLOSE", (0,)),
    "slice": ("SLICE", (0,)),
    "slice-carvingknife": ("SLICE", (0,)),
    "slice_carvingknife": ("SLICE", (0,)),
    **dict.fromkeys(_CLEANING, ("CLEAN", (1,))),
    "soak": ("SOAK", (0,)),
    "soak_teapot": ("SOAK", (0,)),
    "toggle_on": ("TOGGLE_ON", (0,)),
    "freeze": ("FREEZE", (0,)),
    "cook": ("COOK", (0,)),
}
"""Published operator -> household action. Actions that exist for each hand are listed without the hand."""

_GRASP = "GRASP"
_ONE_HAND_ACTIONS = frozenset(
    (_GRASP, "RELEASE", "PLACE_ONTOP", "PLACE_INSIDE", "PLACE_NEXTTO", "PLACE_NEXTTO_ONTOP", "PLACE_UNDER")
)
_HANDS = ("RIGHT", "LEFT")


def translate_to_household_actions(task: Task, published_steps: Sequence[PlanStep]) -> tuple[Action, ...]:
    """Return the household actions of a plan of published operators, up to the first step without an action.

    Planning problems have no hands, so hands are added. The right hand grasps first. The left hand grasps if
    the right hand is full.
    """
    names = BehaviorGoalNotation().list_object_names(task)
    index = {name.replace(".", "_"): number for number, name in enumerate(names)}
    return tuple(
        _add_hand_names_to_one_hand_actions(
            translate_steps(published_steps, COUNTERPARTS, index.get), published_steps
        )
    )


def _add_hand_names_to_one_hand_actions(
    actions: Iterable[Action], steps: Sequence[PlanStep]
) -> Iterator[Action]:
    """Yield the actions with the name of a hand before the name of each operator that needs one hand.

    The action GRASP gets a free hand. Other actions of one hand get the hand that holds the object.
    """
    held: dict[str, str] = {}
    for action, step in zip(actions, steps, strict=False):
        if action.operator not in _ONE_HAND_ACTIONS:
            yield action
            continue
        target, is_grasp = step.arguments[0], action.operator == _GRASP
        wanted = None if is_grasp else target
        hand = next((hand for hand in _HANDS if held.get(hand) == wanted), _HANDS[0])
        if is_grasp:
            held[hand] = target
        else:
            held.pop(hand, None)
        yield Action(f"{hand}_{action.operator}", action.arguments)
