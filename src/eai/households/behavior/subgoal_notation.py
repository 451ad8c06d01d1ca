"""How BEHAVIOR subgoals are read and written, and the names that they may use.

An answer is an object with the key ``output``, anywhere in the text: a list of formulas. A subgoal about the
robot or with a quantifier, which the prompt rules out, is left out; ``toggled.on`` and the hyphen of t-shirts
are spelt as formulas can have them. All of these are repairs.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from eai.abilities.subgoal_decomposition.notation import (
    SubgoalLexicon,
    SubgoalNotation,
    WrittenSubgoals,
    read_output,
)
from eai.abilities.verdict import Unreadable
from eai.households.behavior import domain as behavior
from eai.households.behavior import predicates as p
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

IN_DOMAIN: Mapping[str, str] = {
    "toggledon": "toggled_on",
    "touching": "nextto",
    "inHandOfRobot": p.held.name,
    "holds_rh": p.in_right_hand.name,
    "holds_lh": p.in_left_hand.name,
}
"""What the domain calls the states that it has under another name."""

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


def lexicon(scene: Scene) -> SubgoalLexicon:
    """Return the lexicon of subgoals about a scene."""
    known = {name: arity for name, arity in ACTIONS.items() if arity is not None}
    objects = object_names(scene)
    categories = category_predicates(scene)
    predicates = {**dict.fromkeys(categories, 1), **STATES}
    return meant(scene, Signature(predicates, known, objects), objects)


def meant(scene: Scene, signature: Signature, objects: Mapping[str, int]) -> SubgoalLexicon:
    """The meanings of these names in the domain."""
    categories = {n: c for n, c in category_predicates(scene).items() if scene.vocabulary.arity(n) is None}
    actions = {name: name.upper() for name in ACTIONS}
    return SubgoalLexicon(scene, signature, objects, IN_DOMAIN, actions, categories, UNOBSERVED)


def category_predicates(scene: Scene) -> dict[str, str]:
    """The predicates that say that an object is of a category -> the category."""
    categories = dict.fromkeys(thing.category for thing in scene.objects)
    return {category.replace(".", "_"): category for category in categories if "." in category}


def object_names(scene: Scene) -> dict[str, int]:
    """What an object may be called -> the object: ``jar.0``, also ``jar_0``.

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


_QUANTIFIER = re.compile(r"\b(?:forall|exists|forn|forpairs|fornpairs)\b")
_ROBOT = re.compile(r"\bagent(?:_n_01)?\b")
_SPELLINGS = (("toggled.on", "toggledon"), ("toggled_on", "toggledon"), ("t-shirt", "t_shirt"))


class BehaviorSubgoals(SubgoalNotation):
    """The words of BEHAVIOR's prompts."""

    def __init__(self) -> None:
        super().__init__(behavior.as_meant())

    def lexicon(self, scene: Scene) -> SubgoalLexicon:
        """The prompts' names of states, actions and objects."""
        return lexicon(scene)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """The subgoals in an answer, or why there are none."""
        written = read_output(text, frozenset())
        if isinstance(written, Unreadable):
            return written
        repairs = dict.fromkeys(written.repairs)
        kept: list[str] = []
        left_out = [*written.left_out]
        for subgoal in written.subgoals:
            if _QUANTIFIER.search(subgoal):
                repairs["quantifier"] = None
                left_out.append(subgoal)
            elif _ROBOT.search(subgoal):
                repairs["robot"] = None
                left_out.append(subgoal)
            else:
                spelt = _spelt(subgoal)
                repairs |= {} if spelt == subgoal else {"spelling": None}
                kept.append(spelt)
        return WrittenSubgoals(tuple(kept), tuple(repairs), tuple(left_out))


def _spelt(subgoal: str) -> str:
    for written, meant in _SPELLINGS:
        subgoal = subgoal.replace(written, meant)
    return subgoal
