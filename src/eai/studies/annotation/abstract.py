"""Abstract goals: what all tasks of a title ask for, and the concrete goals that follow from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from eai.abilities.task import Goal, GoalKind
from eai.logic.formula import Atom, Constant, Occurs, Or
from eai.studies.annotation.difference import Difference
from eai.studies.annotation.pattern import Entry
from eai.world.state import Fact, Scene


@dataclass(frozen=True, slots=True)
class Candidate:
    """One meaning of a title.

    Attributes:
        entries: all that it asks for; actions in the order in which they are to be taken.
    """

    entries: tuple[Entry, ...]

    @property
    def actions(self) -> tuple[Entry, ...]:
        """What is to be done, in order."""
        return tuple(entry for entry in self.entries if entry[0].is_action)

    @property
    def world(self) -> tuple[Entry, ...]:
        """What is to be the case in the end."""
        return tuple(entry for entry in self.entries if not entry[0].is_action)

    def is_met(self, found: Difference) -> bool:
        """Whether a demonstration does all that is asked for."""
        return self._is_done(found.actions) and all(any(found.meeting(entry)) for entry in self.world)

    def _is_done(self, actions: Sequence[str]) -> bool:
        """Whether one action of each entry is among these, in the order of the entries."""
        rest = iter(actions)
        return all(
            any(action in {pattern.name for pattern in entry} for action in rest) for entry in self.actions
        )


@dataclass(frozen=True, slots=True)
class Title:
    """What the tasks of one title ask for: one of several candidates.

    Attributes:
        name: the title.
        candidates: in the order in which they are tried.
    """

    name: str
    candidates: tuple[Candidate, ...] = ()

    def assign(self, found: Difference) -> int | None:
        """The number of the first candidate that a demonstration meets, from 0; None if it meets none."""
        met = (number for number, candidate in enumerate(self.candidates) if candidate.is_met(found))
        return next(met, None)


def concrete_goals(found: Difference, candidate: Candidate) -> tuple[Goal, ...]:
    """What a demonstration of a candidate did of all that it asks for, as goals of its own task.

    States come first, then relations, then actions.
    """
    facts = dict.fromkeys(fact for entry in candidate.world for fact in found.meeting(entry))
    states = [_goal(fact, found.scene) for fact in facts if len(fact.arguments) == 1]
    relations = [_goal(fact, found.scene) for fact in facts if len(fact.arguments) == 2]
    actions = [
        Goal(GoalKind.ACTION, Or(tuple(Occurs(pattern.name) for pattern in entry)))
        for entry in candidate.actions
    ]
    return (*states, *relations, *actions)


def _goal(fact: Fact, scene: Scene) -> Goal:
    things = tuple(Constant(scene.objects[i].name) for i in fact.arguments)
    return Goal(GoalKind.STATE if len(things) == 1 else GoalKind.RELATION, Atom(fact.predicate, things))
