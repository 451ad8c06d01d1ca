"""A small hand-made flat, with the objects that the VirtualHome actions need."""

from __future__ import annotations

from collections.abc import Iterable

from eai.benchmarks.virtualhome.predicates import VOCABULARY
from eai.world.action import Action
from eai.world.state import Fact, Scene, State, WorldObject

PROPERTIES = {
    "kitchen.1": ["ROOM"],
    "bedroom.2": ["ROOM"],
    "character.65": [],
    "face.70": ["BODY_PART"],
    "fridge.10": ["CAN_OPEN", "CONTAINERS", "HAS_SWITCH", "HAS_PLUG"],
    "milk.11": ["GRABBABLE", "DRINKABLE", "POURABLE"],
    "table.12": ["SURFACES", "MOVABLE"],
    "cup.13": ["GRABBABLE", "RECIPIENT"],
    "bread.14": ["GRABBABLE", "EATABLE", "CUTTABLE"],
    "knife.15": ["GRABBABLE"],
    "book.16": ["GRABBABLE", "READABLE"],
    "shirt.17": ["GRABBABLE", "CLOTHES"],
    "bed.20": ["LIEABLE", "SITTABLE"],
    "chair.21": ["SITTABLE", "MOVABLE"],
    "television.22": ["LOOKABLE", "HAS_SWITCH", "HAS_PLUG"],
    "keyboard.23": [],
    "guest.24": ["PERSON"],
    "cloud.30": ["GRABBABLE"],
}
OBJECTS_BY_ROOM = {
    "kitchen.1": ["fridge.10", "table.12", "cup.13", "bread.14", "knife.15", "milk.11", "chair.21"],
    "bedroom.2": ["character.65", "face.70", "book.16", "shirt.17", "bed.20", "television.22", "keyboard.23"],
}
INITIAL_FACTS = (
    "INSIDE milk.11 fridge.10",
    "CLOSED fridge.10",
    "OFF fridge.10",
    "PLUGGED_IN fridge.10",
    "ONTOP cup.13 table.12",
    "ONTOP bread.14 table.12",
    "ONTOP knife.15 table.12",
    "ONTOP book.16 bed.20",
    "OFF television.22",
    "PLUGGED_OUT television.22",
    "DIRTY table.12",
)


def make_scene() -> Scene:
    objects = [WorldObject(name, name.rpartition(".")[0]) for name in PROPERTIES]
    return Scene(VOCABULARY, objects, agent=list(PROPERTIES).index("character.65"))


def make_state(*changes: str, over: Scene | None = None) -> State:
    """Return the initial state with facts added (``HELD cup.13``) or, after a minus sign, removed."""
    over = over or make_scene()
    facts = {f"{p} {name}" for name, properties in PROPERTIES.items() for p in properties}
    facts |= {f"INSIDE {name} {room}" for room, names in OBJECTS_BY_ROOM.items() for name in names}
    facts |= set(INITIAL_FACTS)
    for change in changes:
        if change.startswith("-"):
            facts.remove(change[1:])
        else:
            facts.add(change)
    return over.state(parse_facts(facts, over))


def parse_facts(facts: Iterable[str], over: Scene) -> Iterable[Fact]:
    for text in facts:
        predicate, *names = text.split()
        yield Fact(predicate, tuple(over.index[name] for name in names))


def parse_action(text: str, over: Scene) -> Action:
    """Return an action from ``GRAB cup.13``."""
    operator, *names = text.split()
    return Action(operator, tuple(over.index[name] for name in names))


def format_facts(facts: Iterable[Fact], over: Scene) -> set[str]:
    return {" ".join([f.predicate, *(over.objects[i].name for i in f.arguments)]) for f in facts}
