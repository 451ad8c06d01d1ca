"""The view of a task's world: the facts that an agent sees, and how its actions change them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple, TypeAlias

from eai.abilities.task import Task
from eai.envs.rules import Observe
from eai.prompts.wording import Wording, subjects
from eai.world.state import Fact, State

Sight: TypeAlias = tuple[int, ...]
"""The objects that are seen, in the order in which they are told."""


class _Shown(NamedTuple):
    """The facts that are told with one predicate, and the lines that tell them."""

    facts: Sequence[Fact]
    text: str


class Look(NamedTuple):
    """The visible part of a state: objects, and the facts about them by predicate."""

    state: State
    sight: Sight
    told: Sequence[_Shown]

    @property
    def text(self) -> str:
        """All the facts, one a line."""
        return "\n".join([told.text for told in self.told if told.text])


class View:
    """The view of one task's world, which all its episodes share.

    A full view shows the objects that the task is about, and the agent. A partial one shows those of them
    that are visible, and landmarks.

    Args:
        task: the task.
        wording: what facts and objects are called.
        observe: how much is seen.

    Attributes:
        subjects: what can ever be seen, by index, in the order in which it is told. In a partial view it is
            that of the scene, which does not tell landmarks that matter from others.
        landmarks: those of them that are known from the start.
        first: what is seen of the initial state.
    """

    def __init__(self, task: Task, wording: Wording, observe: Observe) -> None:
        self._task = task
        self._wording = wording
        self._is_full = observe is Observe.FULL
        self._lines: dict[Fact, str] = {}
        about = subjects(task)
        self.landmarks = () if self._is_full else _landmarks(task, wording)
        self.subjects = tuple(about if self._is_full else sorted({*about, *self.landmarks}))
        self._objects = {index: wording.object(task, index) for index in self.subjects}
        sight = self._sight(task.initial)
        told = [self._tell(each.facts(task.initial, sight)) for each in wording.listings]
        self.first = Look(task.initial, sight, told)

    def objects(self, chosen: Collection[int]) -> str:
        """Objects with their kinds and properties, one a line."""
        return "\n".join([text for index, text in self._objects.items() if index in chosen])

    def next(self, look: Look, state: State) -> Look:
        """What is seen of a state of the same episode; most actions leave most that is told as it was."""
        sight = self._sight(state)
        changed = _changed(look.state, state)
        told = [
            before
            if sight == look.sight and changed.isdisjoint(listing.sources)
            else self._tell(listing.facts(state, sight))
            for listing, before in zip(self._wording.listings, look.told, strict=True)
        ]
        return Look(state, sight, told)

    def changes(self, before: Look, after: Look) -> str:
        """Return visible facts that became true, as ``+`` lines, and those that became false, as ``-``."""
        added: list[Fact] = []
        removed: list[Fact] = []
        changed = _changed(before.state, after.state)
        for listing, old, new in zip(self._wording.listings, before.told, after.told, strict=True):
            if changed.isdisjoint(listing.sources):
                continue
            if before.sight == after.sight:
                was, remains = old.facts, new.facts
            else:
                was = listing.facts(before.state, after.sight)
                remains = listing.facts(after.state, before.sight)
            added += _without(new.facts, was)
            removed += _without(old.facts, remains)
        lines = [*["+ " + self._line(fact) for fact in added], *["- " + self._line(fact) for fact in removed]]
        return "\n".join(lines)

    def _sight(self, state: State) -> Sight:
        """The objects that are seen in a state."""
        if self._is_full:
            return self.subjects
        sees = self._wording.domain.sees
        return tuple([index for index in self.subjects if sees(state, index)])

    def _tell(self, facts: Sequence[Fact]) -> _Shown:
        return _Shown(facts, "\n".join(map(self._line, facts)))

    def _line(self, fact: Fact) -> str:
        line = self._lines.get(fact)
        if line is None:
            line = self._lines[fact] = self._wording.fact(self._task, fact)
        return line


def _landmarks(task: Task, wording: Wording) -> tuple[int, ...]:
    is_landmark = wording.domain.is_landmark
    return tuple([i for i in range(len(task.scene.objects)) if is_landmark(task.initial, i)])


def _without(facts: Iterable[Fact], others: Sequence[Fact]) -> list[Fact]:
    """The facts that are not among others."""
    known = frozenset(others)
    return [fact for fact in facts if fact not in known]


def _changed(before: State, after: State) -> set[str]:
    """The stored predicates in which two states of an episode differ; an untouched relation is one object."""
    vocabulary = before.scene.vocabulary
    changed = {name for name, i in vocabulary.unary_slots.items() if before.unary[i] != after.unary[i]}
    for name, i in vocabulary.binary_slots.items():
        if before.binary[i] is not after.binary[i]:
            changed.add(name)
    return changed
