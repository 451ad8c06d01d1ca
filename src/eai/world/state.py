"""Scenes and states: the objects of a task, and the facts that hold.

Objects are numbered, and sets of objects are bit masks (bit i = object i). A state is an immutable value. It
has a mask for each unary predicate, a `Relation` for each binary predicate, and a `TupleSet` for each
predicate of higher arity. A `StateDraft` is the only mutable value; it exists while one action is executed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import starmap
from typing import NamedTuple, TypeAlias

from eai.base.errors import InputError, did_you_mean, prefix_errors_with_location
from eai.logic.formula import Atom
from eai.logic.ltl import map_formula_safe_names_to_original_names, parse
from eai.world.relation import (
    ALL_OBJECTS,
    InitialRelation,
    ObjectMask,
    Relation,
    TupleSet,
    iterate_bits,
    make_mask,
)
from eai.world.vocabulary import Vocabulary, require_tuple


@dataclass(frozen=True, slots=True)
class WorldObject:
    """An object of a scene: its unique name, and its category (class, synset)."""

    name: str
    category: str


class Fact(NamedTuple):
    """A true ground atom: a predicate with the indices of its objects."""

    predicate: str
    arguments: tuple[int, ...]


StatedFact: TypeAlias = "str | tuple[str, Sequence[int | str]]"
"""Fact as callers may write it: a text, ``at(robot, dock)``, or a predicate with objects by index or name."""


class Scene:
    """The objects of a task. Their number, order and categories never change during an episode.

    Args:
        vocabulary: the predicates of the states over this scene.
        objects: all objects, or a mapping from their names to categories. The position of an object here is
            its index.
        agent: the name or index of the acting object; None if the domain has no object for the agent.

    Raises:
        InputError: two objects have the same name, or the agent is not an object of the scene.
    """

    __slots__ = ("_categories", "agent", "everything", "index", "objects", "vocabulary")

    def __init__(
        self,
        vocabulary: Vocabulary,
        objects: Iterable[WorldObject] | Mapping[str, str],
        agent: int | str | None = None,
    ) -> None:
        self.vocabulary = vocabulary
        objects = starmap(WorldObject, objects.items()) if isinstance(objects, Mapping) else objects
        self.objects = tuple(objects)
        require_tuple("objects", self.objects, WorldObject)
        for item in self.objects:
            if not (isinstance(item.name, str) and isinstance(item.category, str)):
                found = f"{item.name!r} and {item.category!r}"
                raise InputError(f"an object's name and kind must be texts, found {found}")
        self.index = {item.name: i for i, item in enumerate(self.objects)}
        if len(self.index) < len(self.objects):
            name = next(item.name for i, item in enumerate(self.objects) if self.index[item.name] != i)
            raise InputError(f"two objects are called {name}: give each object a name of its own")
        self.agent = None if agent is None else self.find_object_index(agent)
        self.everything = (1 << len(self.objects)) - 1
        self._categories: dict[str, int] | None = None

    def get_category_mask(self, name: str | None) -> int:
        """Return the bit mask of all objects of a category; None means every object.

        An object belongs to its own category, and to all kinds that contain it (`Vocabulary.parents`).
        """
        return self.everything if name is None else self.object_mask_by_kind.get(name, 0)

    @property
    def object_mask_by_kind(self) -> Mapping[str, ObjectMask]:
        """Mapping from each kind of objects in the scene to the bit mask of the objects of this kind."""
        if self._categories is None:
            masks: dict[str, int] = {}
            for i, item in enumerate(self.objects):
                for kind in self.vocabulary.list_kind_with_ancestors(item.category):
                    masks[kind] = masks.get(kind, 0) | 1 << i
            self._categories = masks
        return self._categories

    def names(self, mask: int) -> tuple[str, ...]:
        """Return the names of the objects in a bit mask, in the order of their indices."""
        return tuple(self.objects[i].name for i in iterate_bits(mask))

    def names_of_category(self, category: str | None) -> tuple[str, ...]:
        """Return the names of the objects of a category, in the scene's order; None means all objects."""
        return self.names(self.get_category_mask(category))

    def find_object_index(self, name: int | str) -> int:
        """Return the index of an object, given its index, its name, or its name as spelt in formulas.

        Raises:
            InputError: no object has this name or index.
        """
        index = self.index.get(name) if isinstance(name, str) else name
        if isinstance(name, str) and index is None:
            index = self.index.get(map_formula_safe_names_to_original_names(self.index).get(name, ""))
        if index is None or not 0 <= index < len(self.objects):
            hint = did_you_mean(name, self.index) if isinstance(name, str) else ""
            raise InputError(f"there is no object {name}{hint}")
        return index

    def read_fact(self, stated: StatedFact) -> Fact:
        """Read a fact about a stored predicate.

        Raises:
            InputError: the value is not a fact about a stored predicate; the message gives the expected form.
        """
        parts = _parse_fact(stated) if isinstance(stated, str) else stated
        if not isinstance(parts, tuple) or len(parts) != 2 or not isinstance(parts[0], str):
            raise InputError(f"{stated!r}: expected a fact, as in 'at(robot, dock)'")
        name, arguments = parts
        if isinstance(arguments, str) or not isinstance(arguments, Sequence):
            raise InputError(
                f"{name}: expected a tuple of objects; write a tuple of one object with a comma, (x,)"
            )
        self.vocabulary.require_arity(name, len(arguments))
        if self.vocabulary.find_stored_predicate(name) is None:
            raise InputError(f"{name} is derived from other facts: state those facts instead")
        return Fact(name, tuple([self.find_object_index(argument) for argument in arguments]))

    def state(self, facts: Iterable[StatedFact]) -> State:
        """Return the state in which exactly these facts about stored predicates hold.

        Raises:
            InputError: a value is not a fact about a stored predicate; the message gives the expected form.
        """
        slots, objects = self.vocabulary.unary_slots, range(len(self.objects))
        arities = {predicate.name: predicate.arity for predicate in self.vocabulary.predicates}
        unary = [0] * len(slots)
        pairs: dict[str, list[tuple[int, int]]] = {name: [] for name in self.vocabulary.binary_slots}
        tuples: dict[str, list[tuple[int, ...]]] = {name: [] for name in self.vocabulary.tuple_slots}
        for stated in facts:
            predicate, arguments = stated if isinstance(stated, Fact) else self.read_fact(stated)
            if arities.get(predicate) != len(arguments) or not all(map(objects.__contains__, arguments)):
                predicate, arguments = self.read_fact(stated)
            if predicate in slots:
                unary[slots[predicate]] |= 1 << arguments[0] if arguments else 1
            elif predicate in tuples:
                tuples[predicate].append(arguments)
            else:
                pairs[predicate].append((arguments[0], arguments[1]))
        size = len(self.objects)
        binary = tuple(Relation(InitialRelation.from_pairs(size, p)) for p in pairs.values())
        return State(self, tuple(unary), binary, tuple(map(TupleSet, tuples.values())))


def _parse_fact(stated: str) -> tuple[str, Sequence[str]] | None:
    """Return the predicate and the objects of a fact's text; None if the text is another kind of formula."""
    with prefix_errors_with_location(repr(stated)):
        formula = parse(stated)
    match formula:
        case Atom(predicate, arguments):
            return predicate, [term.name for term in arguments]
        case _:
            return None


class State:
    """All facts at one moment. States are immutable and share structure with earlier and later states.

    The scene's vocabulary numbers the predicates. ``unary[i]`` is the mask of the objects that have the i-th
    unary predicate (for arity 0: 1 if it is true, else 0). ``binary[i]`` is the i-th relation, and
    ``tuples[i]`` the i-th set of tuples. Two states of one episode (that is, reached from one initial state)
    are equal if the same facts hold. States of different episodes are never equal.
    """

    __slots__ = ("_hash", "binary", "scene", "tuples", "unary")

    def __init__(
        self,
        scene: Scene,
        unary: tuple[int, ...],
        binary: tuple[Relation, ...],
        tuples: tuple[TupleSet, ...] = (),
    ) -> None:
        self.scene = scene
        self.unary = unary
        self.binary = binary
        self.tuples = tuples
        self._hash: int | None = None

    def has(self, predicate: str, *arguments: int) -> bool:
        """Whether a stored predicate holds for the objects with these indices."""
        slot = self.scene.vocabulary.binary_slots.get(predicate)
        if slot is not None:
            return self.binary[slot].has(*arguments)
        slot = self.scene.vocabulary.unary_slots.get(predicate)
        if slot is None:
            return arguments in self.get_tuple_set(predicate).members
        return bool(self.unary[slot] >> (arguments[0] if arguments else 0) & 1)

    def mask(self, predicate: str) -> int:
        """Return the bit mask of all objects for which a unary predicate holds."""
        return self.unary[self.scene.vocabulary.unary_slots[predicate]]

    def relation(self, predicate: str) -> Relation:
        """Return the pairs of objects for which a binary predicate holds in this state."""
        return self.binary[self.scene.vocabulary.binary_slots[predicate]]

    def get_tuple_set(self, predicate: str) -> TupleSet:
        """Return the tuples of a predicate of three or more arguments."""
        return self.tuples[self.scene.vocabulary.tuple_slots[predicate]]

    def facts(self, among: ObjectMask = ALL_OBJECTS) -> Iterator[Fact]:
        """Yield the facts about objects in a mask.

        They are sorted by predicate in the order of the vocabulary, then by object index.
        """
        vocabulary = self.scene.vocabulary
        for name, slot in vocabulary.unary_slots.items():
            arity = vocabulary.find_arity(name)
            for i in iterate_bits(self.unary[slot] & (among if arity else ALL_OBJECTS)):
                yield Fact(name, (i,) if arity else ())
        for name, slot in vocabulary.binary_slots.items():
            for pair in self.binary[slot].pairs(among):
                yield Fact(name, pair)
        for name, slot in vocabulary.tuple_slots.items():
            tuples = sorted(self.tuples[slot].members)
            yield from [Fact(name, each) for each in tuples if not make_mask(each) & ~among]

    def replace_all_facts(self, facts: Iterable[StatedFact]) -> State:
        """Return a state of the same episode in which, of the stored facts, exactly these facts hold.

        Raises:
            InputError: a value is not a fact about a stored predicate; the message gives the expected form.
        """
        stated, draft = self.scene.state(facts), StateDraft(self)
        for slot, relation in enumerate(stated.binary):
            for source in range(len(self.scene.objects)):
                draft.set_targets_in_relation(slot, source, relation.row(source))
        return State(self.scene, stated.unary, tuple(draft.binary), stated.tuples)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, State):
            return NotImplemented
        return (
            self.scene is other.scene
            and self.unary == other.unary
            and self.binary == other.binary
            and self.tuples == other.tuples
        )

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash((self.unary, self.binary, self.tuples))
        return self._hash


class StateChange(NamedTuple):
    """The difference of two states: the facts that became true, and the facts that became false."""

    added: tuple[Fact, ...]
    removed: tuple[Fact, ...]

    @property
    def predicates(self) -> set[str]:
        """Names of the predicates whose facts became true or false."""
        return {fact.predicate for fact in self.added} | {fact.predicate for fact in self.removed}


def compare_states(before: State, after: State) -> StateChange:
    """Return the facts that became true and the facts that became false, each in the order of `State.facts`.

    Both states must be of one episode.
    """
    added: list[Fact] = []
    removed: list[Fact] = []
    vocabulary = before.scene.vocabulary
    for name, slot in vocabulary.unary_slots.items():
        old, new = before.unary[slot], after.unary[slot]
        if old != new:
            arity = vocabulary.find_arity(name)
            added += [Fact(name, (i,) if arity else ()) for i in iterate_bits(new & ~old)]
            removed += [Fact(name, (i,) if arity else ()) for i in iterate_bits(old & ~new)]
    for name, slot in vocabulary.binary_slots.items():
        earlier, later = before.binary[slot], after.binary[slot]
        for x in () if earlier is later else earlier.find_sources_with_changed_targets(later):
            old, new = earlier.row(x), later.row(x)
            added += [Fact(name, (x, y)) for y in iterate_bits(new & ~old)]
            removed += [Fact(name, (x, y)) for y in iterate_bits(old & ~new)]
    for name, slot in vocabulary.tuple_slots.items():
        had, has = before.tuples[slot].members, after.tuples[slot].members
        added += [Fact(name, arguments) for arguments in sorted(has - had)]
        removed += [Fact(name, arguments) for arguments in sorted(had - has)]
    return StateChange(tuple(added), tuple(removed))


class StateDraft:
    """The state after an action, while its effects are applied.

    A slot is the number of a predicate among the predicates of its arity.

    Attributes:
        unary: the mask of each unary predicate, by slot; changed in place.
        binary: the relation of each binary predicate, by slot; changed by the methods.
        tuples: the set of tuples of each other predicate, by slot; changed by the methods.
    """

    __slots__ = ("_copied", "binary", "tuples", "unary")

    def __init__(self, before: State) -> None:
        self.unary = list(before.unary)
        self.binary = list(before.binary)
        self.tuples = before.tuples
        self._copied = 0

    def set_unary_fact(self, predicate_slot: int, object_index: int, truth: bool) -> None:
        """Make a unary predicate true or false of an object."""
        bit, mask = 1 << object_index, self.unary[predicate_slot]
        self.unary[predicate_slot] = mask | bit if truth else mask & ~bit

    def set_objects_of_unary_predicate(self, predicate_slot: int, objects: ObjectMask) -> None:
        """Make a unary predicate true of exactly these objects (a bit mask)."""
        self.unary[predicate_slot] = objects

    def set_binary_fact(self, predicate_slot: int, source: int, target: int, truth: bool) -> None:
        """Add a pair to a relation, or remove the pair if ``truth`` is False."""
        if self.binary[predicate_slot].has(source, target) is not truth:
            self._copy_relation(predicate_slot).toggle_pair(source, target)

    def set_targets_in_relation(self, predicate_slot: int, source: int, targets: ObjectMask) -> None:
        """Relate ``source`` to exactly the targets in a bit mask."""
        if self.binary[predicate_slot].row(source) != targets:
            self._copy_relation(predicate_slot).set_row(source, targets)

    def remove_pairs_with_target(self, predicate_slot: int, target: int) -> None:
        """Remove all pairs with ``target`` as second element from a relation."""
        if self.binary[predicate_slot].column(target):
            self._copy_relation(predicate_slot).set_column(target, 0)

    def remove_all_pairs(self, predicate_slot: int) -> None:
        """Remove all pairs from a relation."""
        for source in iterate_bits(self.binary[predicate_slot].sources):
            self.set_targets_in_relation(predicate_slot, source, 0)

    def add_argument_tuple(self, predicate_slot: int, arguments: tuple[int, ...]) -> None:
        """Add a tuple to the set of a predicate of three or more arguments."""
        self._replace_tuples(predicate_slot, self.tuples[predicate_slot].members | {arguments})

    def remove_matching_tuples(self, predicate_slot: int, pattern: tuple[int | None, ...]) -> None:
        """Remove all tuples that match ``pattern`` from a set. None in ``pattern`` matches any object."""
        members = self.tuples[predicate_slot].members
        matching = [m for m in members if all(p is None or p == i for p, i in zip(pattern, m, strict=True))]
        self._replace_tuples(predicate_slot, members.difference(matching))

    def _replace_tuples(self, slot: int, members: frozenset[tuple[int, ...]]) -> None:
        if members != self.tuples[slot].members:
            self.tuples = (*self.tuples[:slot], TupleSet(members), *self.tuples[slot + 1 :])

    def _copy_relation(self, slot: int) -> Relation:
        """Return the relation with number ``slot``, copied before its first change to keep the old state."""
        if not self._copied >> slot & 1:
            self._copied |= 1 << slot
            self.binary[slot] = self.binary[slot].copy()
        return self.binary[slot]
