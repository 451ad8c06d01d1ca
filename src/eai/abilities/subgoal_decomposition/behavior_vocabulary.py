"""The names that BEHAVIOR subgoals may use, and what objects are called in them."""

from __future__ import annotations

import re
from collections.abc import Mapping

from eai.abilities.protocol import Protocol
from eai.logic.signature import Signature
from eai.world.state import Scene

_ONE_OBJECT = (
    "frozen",
    "dusty",
    "soaked",
    "toggledon",
    "sliced",
    "burnt",
    "cooked",
    "stained",
    "open",
    "holds_rh",
    "holds_lh",
)
_TWO_OBJECTS = ("inside", "nextto", "touching", "under", "ontop", "onfloor")
_ABOUT_THE_ROBOT = ("inFOVOfRobot", "inHandOfRobot", "inReachOfRobot", "inSameRoomAsRobot")
_ROOMS = (
    "Undefined",
    "BedRoom",
    "EmptyRoom",
    "DiningRoom",
    "PantryRoom",
    "Garage",
    "Bathroom",
    "PlayRoom",
    "HomeOffice",
    "Library",
    "Staircase",
    "Kitchen",
    "LivingRoom",
    "ExerciseRoom",
    "Corridor",
    "Auditorium",
    "TelevisionRoom",
    "Lobby",
    "Balcony",
    "StorageRoom",
    "ChildsRoom",
    "Closet",
    "UtilityRoom",
)

STATES: Mapping[str, int] = {
    **dict.fromkeys((*_ONE_OBJECT, *_ABOUT_THE_ROBOT), 1),
    **{f"isIn{room}": 1 for room in _ROOMS},
    **dict.fromkeys(_TWO_OBJECTS, 2),
}
"""Every predicate with its number of objects (``base_vocabulary.json``)."""

UNOBSERVED = frozenset(STATES) - {*_ONE_OBJECT, *_TWO_OBJECTS, "inHandOfRobot"}
"""Predicates about rooms, sight and reach, of which the symbolic scene knows nothing."""

ACTIONS: Mapping[str, int | None] = {
    **dict.fromkeys(("navigate_to", "open", "close", "cook", "clean", "freeze", "unfreeze"), 1),
    **dict.fromkeys(("slice", "soak", "dry", "toggle_on", "toggle_off"), 1),
    **{
        f"{hand}_{action}": 2 if action == "place_nextto_ontop" else 1
        for hand in ("left", "right")
        for action in (
            "grasp",
            "release",
            "place_ontop",
            "place_inside",
            "place_nextto",
            "place_under",
            "place_nextto_ontop",
            "transfer_contents_inside",
            "transfer_contents_ontop",
        )
    },
    **dict.fromkeys(("burn", "stain", "unclean")),
}
"""Every action with its number of objects; of three the file does not say it."""

_NUMBERED = re.compile(r"(.+)_(\d+)")


def signature(scene: Scene, protocol: Protocol) -> Signature:
    """The names to check formulas against.

    Under `eai-1.0.5` numbers of objects and names of objects are left unchecked: the reference checks them in
    an order of its own.
    """
    categories = {each.category.replace(".", "_"): 1 for each in scene.objects if "." in each.category}
    if protocol is Protocol.EAI_1_0_5:
        return Signature(dict.fromkeys((*categories, *STATES)), dict.fromkeys(ACTIONS), None)
    known = {name: arity for name, arity in ACTIONS.items() if arity is not None}
    return Signature({**categories, **STATES}, known, object_names(scene))


def object_names(scene: Scene) -> dict[str, int]:
    """What an object may be called under `strict` -> the object: ``jar.0``, also ``jar_0``.

    Names of formulas have no hyphens; where an object's name does, an underscore stands for it.
    """
    names = {thing.name.replace("-", "_"): i for i, thing in enumerate(scene.objects)}
    return {**names, **{_dotted(name): i for name, i in names.items()}}


def published_names(scene: Scene) -> dict[str, int]:
    """What the reference calls the objects of a task -> the object; parts of objects have no name."""
    return {_dotted(thing.name): i for i, thing in enumerate(scene.objects) if "." in thing.category}


def _dotted(name: str) -> str:
    match = _NUMBERED.fullmatch(name)
    return name if match is None else f"{match[1]}.{match[2]}"
