"""Scenes and states: who is there, and what is true of them.

Objects are numbered; sets of objects are bit masks (bit i = object i). A state is an immutable value: a mask
for each unary predicate, a `Relation` for each binary one. A `Draft` is the one mutable thing; it lives
inside the execution of one action.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from eai.world.relation import Matrix, Relation, bits
from eai.world.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True)
class WorldObject:
    """An object of a scene: a name that is unique in it, and its category (class, synset)."""

    name: str
    category: str


class Fact(NamedTuple):
    """A ground atom that holds, by object index."""

    predicate: str
    arguments: tuple[int, ...]


class Scene:
    """The objects of a task. Their number, order and categories never change during an episode.

    Args:
        vocabulary: the predicates that states over this scene keep.
        objects: all objects; the index of an object is its position here.
        agent: the index of the acting object, or None if the domain has no object for it.
    """

    __slots__ = ("_categories", "agent", "everything", "index", "objects", "vocabulary")

    def __init__(
        self, vocabulary: Vocabulary, objects: Iterable[WorldObject], agent: int | None = None
    ) -> None:
        self.vocabulary = vocabulary
        self.objects = tuple(objects)
        self.agent = agent
        self.index = {thing.name: i for i, thing in enumerate(self.objects)}
        self.everything = (1 << len(self.objects)) - 1
        self._categories: dict[str, int] | None = None

    def category(self, name: str | None) -> int:
        """The mask of all objects of a category; None means every object."""
        if name is None:
            return self.everything
        if self._categories is None:
            self._categories = _by_category(self.objects)
        return self._categories.get(name, 0)

    def names(self, mask: int) -> tuple[str, ...]:
        """The names of the objects in a mask, by index."""
        return tuple(self.objects[i].name for i in bits(mask))

    def named(self, category: str | None) -> tuple[str, ...]:
        """The names of the objects of a category, in the scene's order; of all if it is None."""
        return self.names(self.category(category))

    def state(self, facts: Iterable[Fact | tuple[str, tuple[int, ...]]]) -> State:
        """The state in which exactly these facts about stored predicates hold."""
        slots = self.vocabulary.unary_slots
        unary = [0] * len(slots)
        pairs: dict[str, list[tuple[int, int]]] = {name: [] for name in self.vocabulary.binary_slots}
        for predicate, arguments in facts:
            if predicate in slots:
                unary[slots[predicate]] |= 1 << arguments[0] if arguments else 1
            else:
                pairs[predicate].append((arguments[0], arguments[1]))
        size = len(self.objects)
        return State(self, tuple(unary), tuple(Relation(Matrix.of_pairs(size, p)) for p in pairs.values()))


def _by_category(objects: Iterable[WorldObject]) -> dict[str, int]:
    """The masks of the objects of each category; few scenes are asked for one."""
    found: dict[str, int] = {}
    for i, thing in enumerate(objects):
        found[thing.category] = found.get(thing.category, 0) | 1 << i
    return found


class State:
    """All that is true at one moment: immutable, sharing structure with the states around it.

    ``unary[i]`` is the mask of objects with the i-th unary predicate (for arity 0: 1 or 0), ``binary[i]`` the
    i-th relation, numbered by the scene's vocabulary. Two states of one episode (that is, reached from one
    initial state) are equal if the same facts hold; states of different episodes never are.
    """

    __slots__ = ("_hash", "binary", "scene", "unary")

    def __init__(self, scene: Scene, unary: tuple[int, ...], binary: tuple[Relation, ...]) -> None:
        self.scene = scene
        self.unary = unary
        self.binary = binary
        self._hash: int | None = None

    def has(self, predicate: str, *arguments: int) -> bool:
        """Whether a stored predicate holds of these objects."""
        slot = self.scene.vocabulary.binary_slots.get(predicate)
        if slot is not None:
            return self.binary[slot].has(*arguments)
        mask = self.unary[self.scene.vocabulary.unary_slots[predicate]]
        return bool(mask >> (arguments[0] if arguments else 0) & 1)

    def those(self, predicate: str) -> int:
        """The mask of all objects with a unary predicate."""
        return self.unary[self.scene.vocabulary.unary_slots[predicate]]

    def relation(self, predicate: str) -> Relation:
        """The relation kept for a binary predicate."""
        return self.binary[self.scene.vocabulary.binary_slots[predicate]]

    def facts(self) -> Iterator[Fact]:
        """All facts, by predicate in the order of the vocabulary, then by object index."""
        vocabulary = self.scene.vocabulary
        for name, slot in vocabulary.unary_slots.items():
            arity = vocabulary.arity(name)
            for i in bits(self.unary[slot]):
                yield Fact(name, (i,) if arity else ())
        for name, slot in vocabulary.binary_slots.items():
            for pair in self.binary[slot].pairs():
                yield Fact(name, pair)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, State):
            return NotImplemented
        return self.scene is other.scene and self.unary == other.unary and self.binary == other.binary

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash((self.unary, self.binary))
        return self._hash


class Change(NamedTuple):
    """The facts that one state has and another lacks, and the other way round."""

    added: tuple[Fact, ...]
    removed: tuple[Fact, ...]


def change(before: State, after: State) -> Change:
    """The facts that became true and those that became false, in the order of `State.facts`.

    Both states must be of one episode.
    """
    added: list[Fact] = []
    removed: list[Fact] = []
    vocabulary = before.scene.vocabulary
    for name, slot in vocabulary.unary_slots.items():
        old, new = before.unary[slot], after.unary[slot]
        if old != new:
            arity = vocabulary.arity(name)
            added += [Fact(name, (i,) if arity else ()) for i in bits(new & ~old)]
            removed += [Fact(name, (i,) if arity else ()) for i in bits(old & ~new)]
    for name, slot in vocabulary.binary_slots.items():
        earlier, later = before.binary[slot], after.binary[slot]
        for x in () if earlier is later else earlier.changed_sources(later):
            old, new = earlier.row(x), later.row(x)
            added += [Fact(name, (x, y)) for y in bits(new & ~old)]
            removed += [Fact(name, (x, y)) for y in bits(old & ~new)]
    return Change(tuple(added), tuple(removed))


class Draft:
    """The state after an action, while it is being changed.

    Attributes:
        unary: the masks of unary predicates by slot, to be changed in place.
        binary: the relations by slot, changed by the methods.
    """

    __slots__ = ("_copied", "binary", "unary")

    def __init__(self, before: State) -> None:
        self.unary = list(before.unary)
        self.binary = list(before.binary)
        self._copied = 0

    def link(self, slot: int, source: int, target: int) -> None:
        """Relate two objects."""
        if not self.binary[slot].has(source, target):
            self._own(slot).add(source, target)

    def unlink(self, slot: int, source: int, target: int) -> None:
        """Remove a pair."""
        if self.binary[slot].has(source, target):
            self._own(slot).discard(source, target)

    def clear_row(self, slot: int, source: int) -> None:
        """Remove all pairs of ``source``."""
        if self.binary[slot].row(source):
            self._own(slot).set_row(source, 0)

    def clear_column(self, slot: int, target: int) -> None:
        """Remove all pairs with ``target``."""
        if self.binary[slot].column(target):
            self._own(slot).set_column(target, 0)

    def _own(self, slot: int) -> Relation:
        """The relation in a slot, copied from the state before at its first change."""
        if not self._copied >> slot & 1:
            self._copied |= 1 << slot
            self.binary[slot] = self.binary[slot].copy()
        return self.binary[slot]
