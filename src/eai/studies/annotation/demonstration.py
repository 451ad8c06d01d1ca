"""Demonstrations: what they change, the patterns that they share, and the goals that follow from them.

An abstract goal asks for objects by their class or by all that they are good for. The text of its patterns is
what files of decisions have: ``ON(washing_machine)`` for a state, ``ONTOP({GRABBABLE, MOVABLE},
washing_machine)`` for a relation, ``do TOUCH`` for an action.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from eai.abilities.task import Goal, GoalKind, Task
from eai.errors import InputError
from eai.logic.formula import Atom, Constant, Occurs, Or
from eai.world.domain import Domain
from eai.world.execution import execute
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary

_DO = "do "
_NAME = r"[^\s(){},]+"
_KIND = rf"\s*({_NAME}|\{{[^{{}}]*\}})\s*"
_ATOM = re.compile(rf"({_NAME})\({_KIND}(?:,{_KIND})?,?\)")


@dataclass(frozen=True, slots=True)
class _Kind:
    """Objects of a class, or those that have exactly some properties.

    Attributes:
        name: the class; empty if it is properties that count.
        properties: what the objects are good for, in the order in which they are written; two kinds with the
            same ones are one.
    """

    name: str = ""
    properties: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Kind) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[str, frozenset[str]]:
        return self.name, frozenset(self.properties)

    def __str__(self) -> str:
        return self.name or "{" + ", ".join(self.properties) + "}"


@dataclass(frozen=True, slots=True)
class Pattern:
    """A state of one kind of object, a relation of two, or an action.

    Attributes:
        name: of the predicate or action.
        kinds: of what it is said; of an action nothing.
    """

    name: str
    kinds: tuple[_Kind, ...] = ()

    @property
    def is_action(self) -> bool:
        """Whether something is to be done."""
        return not self.kinds

    def __str__(self) -> str:
        return _DO + self.name if self.is_action else f"{self.name}({', '.join(map(str, self.kinds))})"


Entry: TypeAlias = tuple[Pattern, ...]
"""A part of an abstract goal: one of these patterns must be met."""


def read_pattern(text: str) -> Pattern:
    """The pattern that a text is.

    Raises:
        InputError: it is none.
    """
    if text.startswith(_DO) and text.removeprefix(_DO).strip():
        return Pattern(text.removeprefix(_DO).strip())
    atom = _ATOM.fullmatch(text.strip())
    if atom is None:
        raise InputError(
            f"{text!r}: expected a pattern such as ON(lamp), ONTOP({{GRABBABLE, MOVABLE}}, table) or do TOUCH"
        )
    name, *kinds = filter(None, atom.groups())
    return Pattern(name, tuple(map(_kind, kinds)))


def _kind(text: str) -> _Kind:
    words = [word.strip() for word in text.strip("{}").split(",")]
    return _Kind(properties=tuple(filter(None, words))) if text.startswith("{") else _Kind(text)


@dataclass(frozen=True, slots=True)
class Difference:
    """The changes that a demonstration makes, and its actions.

    Attributes:
        task: what was demonstrated.
        facts: all that can be said of each object of which something changed, as a fact about it alone, and
            the relations that are new; in the order of the vocabulary, then of the scene.
        actions: the operators of the plan, in order.
    """

    task: Task
    facts: tuple[Fact, ...]
    actions: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The objects."""
        return self.task.scene

    def meeting(self, entry: Entry) -> Iterator[Fact]:
        """The facts that an entry about the world asks for, in order."""
        return (fact for fact in self.facts if any(self._is(fact, pattern) for pattern in entry))

    def _is(self, fact: Fact, pattern: Pattern) -> bool:
        if fact.predicate != pattern.name or len(fact.arguments) != len(pattern.kinds):
            return False
        pairs = zip(fact.arguments, pattern.kinds, strict=True)
        return all(
            self.class_of(thing) == kind if kind.name else self.properties_of(thing) == kind
            for thing, kind in pairs
        )

    def class_of(self, thing: int) -> _Kind:
        """The class of an object."""
        return _Kind(self.scene.objects[thing].category)

    def properties_of(self, thing: int) -> _Kind:
        """The properties of an object: the visible static predicates that hold of it."""
        initial = self.task.initial
        names = properties(self.scene.vocabulary)
        return _Kind(properties=tuple(name for name in names if initial.has(name, thing)))


def difference(task: Task, domain: Domain) -> Difference:
    """The changes of a task's demonstration: of its plan, to the state that the data set says it ends in.

    Where the data set does not say, the plan is carried out.

    Raises:
        InputError: it is no demonstration: there is no plan, or it cannot be carried out.
    """
    if not task.script:
        raise InputError(f"{task.id}: no demonstration; expected a plan")
    final = _final(task, domain)
    changed = _changed(task.initial, final)
    predicates = task.scene.vocabulary.predicates
    facts = (
        fact
        for fact in final.facts()
        if fact.arguments and fact.predicate in _names(predicates, len(fact.arguments), static=False)
        if (
            changed >> fact.arguments[0] & 1
            if len(fact.arguments) == 1
            else not task.initial.has(fact.predicate, *fact.arguments)
        )
    )
    return Difference(task, tuple(facts), tuple(action.operator for action in task.script))


def _final(task: Task, domain: Domain) -> State:
    if task.annotated_final is not None:
        return task.annotated_final
    done = execute(domain, task.initial, task.script)
    if done.failure is not None:
        step = len(done.executed) + 1
        raise InputError(f"{task.id}: no demonstration; step {step} of its plan cannot be carried out")
    return done.final


def _changed(before: State, after: State) -> int:
    """The mask of objects of which something alone is otherwise."""
    found = 0
    for name in _names(before.scene.vocabulary.predicates, 1, static=False):
        found |= before.those(name) ^ after.those(name)
    return found


def properties(vocabulary: Vocabulary) -> tuple[str, ...]:
    """The predicates that say what an object is good for, in order."""
    return _names(vocabulary.predicates, 1, static=True)


@cache
def _names(predicates: tuple[Predicate, ...], arity: int, *, static: bool) -> tuple[str, ...]:
    return tuple(p.name for p in predicates if p.arity == arity and p.static is static and p.visible)


def frequencies(differences: Iterable[Difference], without: Iterable[str]) -> Counter[Pattern]:
    """How often each pattern occurs in all differences together.

    States and relations by class come first, then relations with one of both ends by its properties; the
    agent stays itself.

    Args:
        differences: those of one title.
        without: predicates that are not counted, because they hold of too much.
    """
    left_out = frozenset(without)
    exact: Counter[Pattern] = Counter()
    wild: Counter[Pattern] = Counter()
    for each in differences:
        for fact in each.facts:
            if fact.predicate not in left_out:
                classes = tuple(map(each.class_of, fact.arguments))
                exact[Pattern(fact.predicate, classes)] += 1
                wild.update(_generalised(each, fact.predicate, fact.arguments))
    return exact + wild


def _generalised(each: Difference, name: str, things: tuple[int, ...]) -> Iterator[Pattern]:
    if len(things) < 2:
        return
    for end, thing in enumerate(things):
        if thing != each.scene.agent:
            kinds = [each.class_of(other) for other in things]
            kinds[end] = each.properties_of(thing)
            yield Pattern(name, tuple(kinds))


Candidate: TypeAlias = tuple[Entry, ...]
"""One meaning of a title: all that it asks for; actions in the order in which they are to be taken."""


def first_met(candidates: Sequence[Candidate], found: Difference) -> int | None:
    """The number of the first candidate that a demonstration meets, from 0; None if it meets none."""
    return next((number for number, each in enumerate(candidates) if is_met(each, found)), None)


def is_met(candidate: Candidate, found: Difference) -> bool:
    """Whether a demonstration does all that is asked for, actions in the order of the entries."""
    rest = iter(found.actions)
    return all(
        any(action in {pattern.name for pattern in entry} for action in rest)
        for entry in candidate
        if entry[0].is_action
    ) and all(any(found.meeting(entry)) for entry in candidate if not entry[0].is_action)


def concrete_goals(found: Difference, candidate: Candidate) -> tuple[Goal, ...]:
    """The part of a candidate's goals that a demonstration of it reached, as goals of its own task.

    States come first, then relations, then actions.
    """
    conditions = [entry for entry in candidate if not entry[0].is_action]
    facts = dict.fromkeys(fact for entry in conditions for fact in found.meeting(entry))
    states = [_goal(fact, found.scene) for fact in facts if len(fact.arguments) == 1]
    relations = [_goal(fact, found.scene) for fact in facts if len(fact.arguments) == 2]
    actions = [
        Goal(GoalKind.ACTION, Or(tuple(Occurs(pattern.name) for pattern in entry)))
        for entry in candidate
        if entry[0].is_action
    ]
    return (*states, *relations, *actions)


def _goal(fact: Fact, scene: Scene) -> Goal:
    things = tuple(Constant(scene.objects[i].name) for i in fact.arguments)
    return Goal(GoalKind.STATE if len(things) == 1 else GoalKind.RELATION, Atom(fact.predicate, things))
