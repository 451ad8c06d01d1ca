"""Differences: what a demonstration changes in its world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from eai.abilities.task import Task
from eai.errors import InputError
from eai.studies.annotation.pattern import Entry, Kind, Pattern
from eai.world.domain import Domain
from eai.world.execution import execute
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary


@dataclass(frozen=True, slots=True)
class Difference:
    """What is otherwise where a demonstration ends, and what was done on the way.

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
        wanted = {pattern.name for pattern in entry}
        for fact in self.facts:
            if fact.predicate in wanted and any(self._is(fact, pattern) for pattern in entry):
                yield fact

    def _is(self, fact: Fact, pattern: Pattern) -> bool:
        if fact.predicate != pattern.name or len(fact.arguments) != len(pattern.kinds):
            return False
        pairs = zip(fact.arguments, pattern.kinds, strict=True)
        return all(
            self.class_of(thing) == kind if kind.name else self.properties_of(thing) == kind
            for thing, kind in pairs
        )

    def class_of(self, thing: int) -> Kind:
        """The class of an object."""
        return Kind(self.scene.objects[thing].category)

    def properties_of(self, thing: int) -> Kind:
        """What an object is good for: the visible static predicates that hold of it."""
        initial = self.task.initial
        names = properties(self.scene.vocabulary)
        return Kind(properties=tuple(name for name in names if initial.has(name, thing)))


def difference(task: Task, domain: Domain) -> Difference:
    """What the demonstration of a task changes: its plan, to the state that the data set says it ends in.

    Where the data set does not say, the plan is carried out.

    Raises:
        InputError: it is no demonstration: there is no plan, or it cannot be carried out.
    """
    if not task.script:
        raise InputError(f"{task.id}: no demonstration; expected a plan")
    final = _final(task, domain)
    changed = _changed(task.initial, final)
    facts = (
        fact
        for fact in final.facts()
        if _counts(task.scene.vocabulary, fact.predicate, len(fact.arguments))
        and (changed >> fact.arguments[0] & 1 if len(fact.arguments) == 1 else not _held(task.initial, fact))
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


def _held(state: State, fact: Fact) -> bool:
    return state.has(fact.predicate, *fact.arguments)


def _changed(before: State, after: State) -> int:
    """The mask of objects of which something alone is otherwise."""
    found = 0
    for name in _names(before.scene.vocabulary, 1, static=False):
        found |= before.those(name) ^ after.those(name)
    return found


def _counts(vocabulary: Vocabulary, name: str, arguments: int) -> bool:
    return arguments > 0 and name in _names(vocabulary, arguments, static=False)


def properties(vocabulary: Vocabulary) -> tuple[str, ...]:
    """The predicates that say what an object is good for, in order."""
    return _names(vocabulary, 1, static=True)


def _names(vocabulary: Vocabulary, arity: int, *, static: bool) -> tuple[str, ...]:
    return _chosen(vocabulary.predicates, arity, static)


@cache
def _chosen(predicates: tuple[Predicate, ...], arity: int, static: bool) -> tuple[str, ...]:
    return tuple(p.name for p in predicates if p.arity == arity and p.static is static and p.visible)
