"""Everything that a state tells of where things are and how they look, in worlds with these predicates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from eai.base.errors import InputError
from eai.extensions.scenes.body import Body, body_of, kind_of
from eai.world.relation import bits
from eai.world.state import State, WorldObject

INSIDE, ON, UNDER, BESIDE = "lies_in", "lies_on", "stands_under", "stands_by"
"""The stored relations that say where things are among each other."""

_AMONG = (INSIDE, ON, UNDER, BESIDE)

ON_FLOOR = ("stands_on", "by_floor")
"""Those that say on which floor, or on that of which room, of which a world has one."""

SUPPORTS = (INSIDE, ON)
"""Those by which one thing carries another."""

_FLOORS = "floor"
_WORDS = ("open", "dusty", "stained", "soaked", "frozen", "cooked", "burnt")
_STATES = {"is_toggled_on": "on", **{f"is_{word}": word for word in _WORDS}}
"""The states of one thing that can be seen, by stored predicate."""

_HANDS = ("in_left_hand", "in_right_hand")


@dataclass(frozen=True, slots=True)
class Told:
    """Where things are and how they look by a state.

    Attributes:
        bodies: the body of each thing that is there, by index.
        absent: the bodies of those that are not, such as halves of what is whole.
        floors: the floors of rooms.
        relations: the pairs of each relation among things, of those that are there.
        floor_of: the floor of what nothing carries, where it is known.
        states: what can be seen of each thing.
        hands: the things in the left and the right hand.
    """

    bodies: Mapping[int, Body]
    absent: Mapping[int, Body]
    floors: tuple[int, ...]
    relations: Mapping[str, tuple[tuple[int, int], ...]]
    floor_of: Mapping[int, int]
    states: Mapping[int, frozenset[str]]
    hands: Mapping[int, int] = field(default_factory=dict)

    def carrier(self, thing: int) -> tuple[str, int] | None:
        """The relation to the thing that carries one, and that thing."""
        for relation in SUPPORTS:
            for carried, carrier in self.relations[relation]:
                if carried == thing:
                    return relation, carrier
        return None

    def place(self, thing: int) -> tuple[object, ...]:
        """Everything that is said of where a thing is."""
        return (self.carrier(thing), self.floor_of.get(thing), *sorted(self._neighbours(thing)))

    def _neighbours(self, thing: int) -> Iterator[tuple[str, int]]:
        """The things under or beside which one stands."""
        for name in (UNDER, BESIDE):
            yield from ((name, second) for first, second in self.relations[name] if first == thing)

    def carriers(self, thing: int) -> Iterator[tuple[str, int]]:
        """The thing that carries one (`carrier`), that which carries this, and so on."""
        for _ in self.bodies:
            found = self.carrier(thing)
            if found is None:
                return
            yield found
            thing = found[1]

    def depth(self, thing: int) -> int:
        """How many things carry one, one on the other."""
        return len(list(self.carriers(thing)))

    def is_shut_in(self, thing: int) -> bool:
        """Whether a thing is in something that is closed."""
        return any(how == INSIDE and "closed" in self.states[i] for how, i in self.carriers(thing))

    @property
    def visible(self) -> list[int]:
        """The things that no hand holds and that are in nothing that is closed."""
        return [i for i in self.bodies if not self.is_held(i) and not self.is_shut_in(i)]

    def room_of(self, thing: int) -> int:
        """The floor of the room in which a thing is."""
        root = self.root(thing)
        near = [root, *(other for _, other in self._neighbours(root))]
        return next((self.floor_of[each] for each in near if each in self.floor_of), self.floors[0])

    @property
    def fullest(self) -> int:
        """The floor of the room in which most things are."""
        many = Counter(map(self.room_of, self.bodies))
        return max(self.floors, key=lambda floor: (many[floor], -floor))

    def is_held(self, thing: int) -> bool:
        """Whether a hand holds a thing, or what carries it: such contents are not shown."""
        return self.root(thing) in self.hands.values()

    def root(self, thing: int) -> int:
        """The thing at the bottom of a pile."""
        return [thing, *(carrier for _, carrier in self.carriers(thing))][-1]


def told_of(state: State) -> Told:
    """Return what a state tells.

    Raises:
        InputError: the world does not say what lies where, or a thing has no body.
    """
    vocabulary, scene = state.scene.vocabulary, state.scene
    if not {*SUPPORTS, _FLOORS} <= {each.name for each in vocabulary.predicates}:
        raise InputError(f"no bodies: the world does not say what {INSIDE} and {ON} what")
    floors = tuple(bits(state.mask(_FLOORS)))
    shapeless = {*floors, scene.agent, *_those(state, "substance"), *_those(state, "recipe")}
    things = {i: thing for i, thing in enumerate(scene.objects) if i not in shapeless}
    kinds = {i: body_of(kind_of(thing.name, thing.category)) for i, thing in things.items()}
    absent = {i: body for i, body in kinds.items() if body is not None and _is_absent(state, i)}
    bodies = {i: _body(thing) for i, thing in things.items() if not _is_absent(state, i)}
    stated = {name: _pairs(state, name, bodies) for name in (*_AMONG, *ON_FLOOR)}
    floor_of = dict(pair for name in (*ON_FLOOR, ON) for pair in stated[name] if pair[1] in floors)
    relations = {name: tuple([pair for pair in stated[name] if pair[1] in bodies]) for name in _AMONG}
    states = {index: _states(state, index, body) for index, body in bodies.items()}
    hands = {hand: i for hand, name in enumerate(_HANDS) for i in _those(state, name) if i in bodies}
    return Told(bodies, absent, floors, relations, floor_of, states, hands)


def _body(thing: WorldObject) -> Body:
    """The body of a thing.

    Raises:
        InputError: there is none for its kind.
    """
    kind = kind_of(thing.name, thing.category)
    body = body_of(kind)
    if body is None:
        raise InputError(f"{thing.name}: there is no body for things of the kind {kind}")
    return body


def _pairs(state: State, name: str, bodies: Mapping[int, Body]) -> tuple[tuple[int, int], ...]:
    """The pairs of a relation that the world may not have, about things that are there."""
    known = name in state.scene.vocabulary.binary_slots
    return tuple([pair for pair in state.relation(name).pairs() if pair[0] in bodies]) if known else ()


def _those(state: State, name: str) -> tuple[int, ...]:
    """The things with a predicate that the world may not have."""
    return tuple(bits(state.mask(name))) if name in state.scene.vocabulary.unary_slots else ()


def _is_absent(state: State, index: int) -> bool:
    """Whether a thing is not there: half of what is whole, cut in halves, or yet to be made."""
    if "present" in state.scene.vocabulary.unary_slots and index not in _those(state, "present"):
        held = index in _those(state, "held")
        return not held and not any(state.relation(name).row(index) for name in (INSIDE, ON))
    if "part_of" not in state.scene.vocabulary.binary_slots:
        return False
    parts, sliced = state.relation("part_of"), _those(state, "is_sliced")
    wholes = bits(parts.row(index))
    return any(whole not in sliced for whole in wholes) or (index in sliced and bool(parts.column(index)))


def _states(state: State, index: int, body: Body) -> frozenset[str]:
    """The visible states of a thing; what cannot be opened is closed only if it has a door."""
    found = {word for name, word in _STATES.items() if index in _those(state, name)}
    if "open" not in found and (index in _those(state, "openable") or not body.slack):
        found.add("closed")
    return frozenset(found)
