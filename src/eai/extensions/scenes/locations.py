"""Read locations and visible states of objects from a state of a world.

The world has to declare the predicates that this module names.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from eai.base.errors import InputError
from eai.extensions.scenes.body import (
    ObjectBodyShape,
    find_body_shape_of_object_kind,
    find_object_kind_for_body_shape,
)
from eai.world.relation import iterate_bits
from eai.world.state import State, WorldObject

INSIDE, ON, UNDER, BESIDE = "lies_in", "lies_on", "stands_under", "stands_by"
"""Names of the predicates that relate the locations of two objects."""

_OBJECT_RELATIONS = (INSIDE, ON, UNDER, BESIDE)

ON_FLOOR = ("stands_on", "by_floor")
"""Names of predicates that relate an object to the floor of its room. Each world declares one of them."""

SUPPORTS = (INSIDE, ON)
"""Names of predicates that say that the second object carries (contains or supports) the first."""

_FLOORS = "floor"
_STATE_WORDS = ("open", "dusty", "stained", "soaked", "frozen", "cooked", "burnt")
_STATES = {"is_toggled_on": "on", **{f"is_{word}": word for word in _STATE_WORDS}}
"""Word for each visible state of an object, by the name of the state's predicate."""

_HANDS = ("in_left_hand", "in_right_hand")


@dataclass(frozen=True, slots=True)
class ObjectLocations:
    """Locations and visible states of objects in one state of the world.

    Attributes:
        bodies: the body of each present object, by index.
        absent: the body of each absent object, such as a half of an object that is not cut yet.
        floors: the index of the floor of each room. A floor stands for its room.
        relations: the pairs of present objects that are in each relation, by the name of the relation.
        floor_of: the floor of each object that no other object carries, if the state says it.
        states: the words for the visible states of each object.
        hands: the index of the object in the left hand (key 0) and in the right hand (key 1).
    """

    bodies: Mapping[int, ObjectBodyShape]
    absent: Mapping[int, ObjectBodyShape]
    floors: tuple[int, ...]
    relations: Mapping[str, tuple[tuple[int, int], ...]]
    floor_of: Mapping[int, int]
    states: Mapping[int, frozenset[str]]
    hands: Mapping[int, int] = field(default_factory=dict)

    def find_relation_and_carrier(self, object_index: int) -> tuple[str, int] | None:
        """Return an object's relation to its carrier, and the carrier; None if no object carries it.

        The carrier is the container or support that the object is in or on.
        """
        for relation in SUPPORTS:
            for carried, carrier in self.relations[relation]:
                if carried == object_index:
                    return relation, carrier
        return None

    def make_location_key(self, object_index: int) -> tuple[object, ...]:
        """Return the relations of an object to other objects, and its floor.

        If neither the object nor a related object moves, the value stays equal.
        """
        return (
            self.find_relation_and_carrier(object_index),
            self.floor_of.get(object_index),
            *sorted(self._list_relations_to_neighbours(object_index)),
        )

    def _list_relations_to_neighbours(self, object_index: int) -> Iterator[tuple[str, int]]:
        for name in (UNDER, BESIDE):
            yield from ((name, second) for first, second in self.relations[name] if first == object_index)

    def list_relations_and_carriers(self, object_index: int) -> Iterator[tuple[str, int]]:
        """Yield an object's carrier, the carrier of that carrier, and so on, as pairs (relation, carrier)."""
        for _ in self.bodies:
            carrier = self.find_relation_and_carrier(object_index)
            if carrier is None:
                return
            yield carrier
            object_index = carrier[1]

    def count_carriers(self, object_index: int) -> int:
        """Return the number of an object's carriers: its carrier, the carrier of this carrier, and so on."""
        return len(list(self.list_relations_and_carriers(object_index)))

    def is_shut_in(self, object_index: int) -> bool:
        """Whether an object is in a closed container, directly or inside or on another object."""
        return any(
            how == INSIDE and "closed" in self.states[i]
            for how, i in self.list_relations_and_carriers(object_index)
        )

    @property
    def visible_objects(self) -> list[int]:
        """The objects that no hand holds and no closed container contains."""
        return [i for i in self.bodies if not self.is_held(i) and not self.is_shut_in(i)]

    def find_room(self, object_index: int) -> int:
        """Return the floor object that stands for the room of an object."""
        root = self.find_bottom_of_pile(object_index)
        near = [root, *(other for _, other in self._list_relations_to_neighbours(root))]
        return next((self.floor_of[index] for index in near if index in self.floor_of), self.floors[0])

    @property
    def fullest_room(self) -> int:
        """The floor of the room with most objects."""
        many = Counter(map(self.find_room, self.bodies))
        return max(self.floors, key=lambda floor: (many[floor], -floor))

    def is_held(self, object_index: int) -> bool:
        """Whether a hand holds an object, directly or in or on another object.

        Pictures do not show the objects in or on a held object.
        """
        return self.find_bottom_of_pile(object_index) in self.hands.values()

    def find_bottom_of_pile(self, object_index: int) -> int:
        """Return the lowest object of an object's pile; the object itself if nothing carries it."""
        return [object_index, *(carrier for _, carrier in self.list_relations_and_carriers(object_index))][-1]


def read_object_locations(state: State) -> ObjectLocations:
    """Read locations and visible states of all objects from a state.

    Raises:
        InputError: the world has no predicates for locations, or an object has no body.
    """
    vocabulary, scene = state.scene.vocabulary, state.scene
    if not {*SUPPORTS, _FLOORS} <= {predicate.name for predicate in vocabulary.predicates}:
        raise InputError(f"cannot build a scene: this world needs the predicates {INSIDE}, {ON} and floor")
    floors = tuple(iterate_bits(state.mask(_FLOORS)))
    shapeless = {
        *floors,
        scene.agent,
        *_list_objects_with_property(state, "substance"),
        *_list_objects_with_property(state, "recipe"),
    }
    scene_objects = {i: scene_object for i, scene_object in enumerate(scene.objects) if i not in shapeless}
    kinds = {
        i: find_body_shape_of_object_kind(
            find_object_kind_for_body_shape(scene_object.name, scene_object.category)
        )
        for i, scene_object in scene_objects.items()
    }
    absent = {i: body for i, body in kinds.items() if body is not None and _is_object_absent(state, i)}
    bodies = {
        i: _require_body(scene_object)
        for i, scene_object in scene_objects.items()
        if not _is_object_absent(state, i)
    }
    stated = {name: _list_related_pairs(state, name, bodies) for name in (*_OBJECT_RELATIONS, *ON_FLOOR)}
    floor_of = dict(pair for name in (*ON_FLOOR, ON) for pair in stated[name] if pair[1] in floors)
    relations = {
        name: tuple([pair for pair in stated[name] if pair[1] in bodies]) for name in _OBJECT_RELATIONS
    }
    states = {
        index: _find_visible_state_words_of_object(state, index, body) for index, body in bodies.items()
    }
    hands = {
        hand: i
        for hand, name in enumerate(_HANDS)
        for i in _list_objects_with_property(state, name)
        if i in bodies
    }
    return ObjectLocations(bodies, absent, floors, relations, floor_of, states, hands)


def _require_body(scene_object: WorldObject) -> ObjectBodyShape:
    """Return the body of an object.

    Raises:
        InputError: the table of kinds has no body for the object.
    """
    kind = find_object_kind_for_body_shape(scene_object.name, scene_object.category)
    body = find_body_shape_of_object_kind(kind)
    if body is None:
        raise InputError(
            f"{scene_object.name}: objects of the kind {kind} have no three-dimensional shape; "
            "choose another task"
        )
    return body


def _list_related_pairs(
    state: State, name: str, bodies: Mapping[int, ObjectBodyShape]
) -> tuple[tuple[int, int], ...]:
    """Return a relation's pairs whose first object is in ``bodies``; none for an undeclared relation."""
    known = name in state.scene.vocabulary.binary_slots
    return tuple([pair for pair in state.relation(name).pairs() if pair[0] in bodies]) if known else ()


def _list_objects_with_property(state: State, name: str) -> tuple[int, ...]:
    """Return the objects that have a property; none if the world does not declare the property."""
    return tuple(iterate_bits(state.mask(name))) if name in state.scene.vocabulary.unary_slots else ()


def _is_object_absent(state: State, object_index: int) -> bool:
    """Whether an object is absent: a half of an uncut object, an object that was cut, or one not yet made."""
    if "present" in state.scene.vocabulary.unary_slots and object_index not in _list_objects_with_property(
        state, "present"
    ):
        held = object_index in _list_objects_with_property(state, "held")
        return not held and not any(state.relation(name).row(object_index) for name in (INSIDE, ON))
    if "part_of" not in state.scene.vocabulary.binary_slots:
        return False
    parts, sliced = state.relation("part_of"), _list_objects_with_property(state, "is_sliced")
    wholes = iterate_bits(parts.row(object_index))
    return any(whole not in sliced for whole in wholes) or (
        object_index in sliced and bool(parts.column(object_index))
    )


def _find_visible_state_words_of_object(
    state: State, object_index: int, body: ObjectBodyShape
) -> frozenset[str]:
    states = {
        word for name, word in _STATES.items() if object_index in _list_objects_with_property(state, name)
    }
    if "open" not in states and (
        object_index in _list_objects_with_property(state, "openable") or not body.slack
    ):
        states.add("closed")
    return frozenset(states)
