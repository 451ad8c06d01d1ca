"""Matching the goals that an answer predicts with those of a VirtualHome task, under each protocol."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable
from typing import Protocol, TypeVar

from eai.abilities.goal_interpretation.counting import (
    confusion,
    count_alternatives,
    count_up_to_renaming,
    match_alternatives,
)
from eai.abilities.goal_interpretation.virtualhome_gold import RELATION_OF_PREDICATE, by_class, gold_goals
from eai.abilities.goal_interpretation.written import RelationGoal, StateGoal, WrittenGoals
from eai.abilities.task import GoalKind, Task
from eai.abilities.verdict import Confusion
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.places import object_id
from eai.benchmarks.virtualhome.predicates import VOCABULARY

STATES = frozenset(p.name for p in VOCABULARY.predicates if p.arity == 1 and p.visible and not p.static)
"""The states of objects that an answer may speak of."""

RELATIONS = frozenset(RELATION_OF_PREDICATE.values())
"""The relations of objects that an answer may speak of."""

T = TypeVar("T", StateGoal, RelationGoal)


class Matching(Protocol):
    """What decides whether predicted goals are goals of the task."""

    def count(self, goals: WrittenGoals) -> dict[GoalKind, Confusion]:
        """True positives, false positives and false negatives by kind of goal."""
        ...

    def met(self, goals: WrittenGoals) -> list[bool]:
        """For each goal of the task, by kind and then in order, whether it is predicted."""
        ...

    def wrong(self, goals: WrittenGoals) -> list[str]:
        """The predictions that are no goals of the task, each once, as text."""
        ...

    def hallucinated(self, goals: WrittenGoals) -> list[str]:
        """For each predicted goal that names what does not exist, the first such name."""
        ...

    def unread(self) -> dict[GoalKind, Confusion]:
        """The counts of an answer in which no goals can be read."""
        ...


class UpToRenaming:
    """The matching of protocol `strict`: a name stands for any object of its class."""

    def __init__(self, task: Task) -> None:
        self._objects = Counter([task.scene.objects[i].category for i in task.relevant])
        self._gold = by_class(gold_goals(task))
        self._states = Counter(self._gold.states)
        self._relations = Counter(self._gold.relations)
        self._known_actions = virtualhome.as_meant().compiled.keys()

    def count(self, goals: WrittenGoals) -> dict[GoalKind, Confusion]:
        """The counts; entries that are ill-formed or hallucinated are false positives."""
        states, relations = Counter(goals.states), Counter(goals.relations)
        objects = self._objects
        counts = (
            count_up_to_renaming(states, self._states, {g: objects[g.name] for g in states}),
            count_up_to_renaming(
                relations, self._relations, {g: objects[g.from_name] * objects[g.to_name] for g in relations}
            ),
            count_alternatives(tuple(dict.fromkeys(goals.actions)), self._gold.actions),
        )
        return {
            kind: Confusion(c.true_positives, c.false_positives + goals.ill_formed[kind], c.false_negatives)
            for kind, c in zip(GoalKind, counts, strict=True)
        }

    def met(self, goals: WrittenGoals) -> list[bool]:
        """Each gold goal uses up one prediction."""
        states, relations = Counter(goals.states), Counter(goals.relations)
        matched = match_alternatives(tuple(dict.fromkeys(goals.actions)), self._gold.actions)
        return [
            *[_use(goal, states) for goal in self._gold.states],
            *[_use(goal, relations) for goal in self._gold.relations],
            *[i in matched for i in range(len(self._gold.actions))],
        ]

    def wrong(self, goals: WrittenGoals) -> list[str]:
        """The predictions that are written like no goal of the task."""
        actions = frozenset([action for goal in self._gold.actions for action in goal])
        return [
            *_texts(goal for goal in goals.states if goal not in self._states),
            *_texts(goal for goal in goals.relations if goal not in self._relations),
            *dict.fromkeys(action for action in goals.actions if action not in actions),
        ]

    def hallucinated(self, goals: WrittenGoals) -> list[str]:
        """Objects that are not among the relevant ones, and states, relations and actions there are not."""
        found = [
            *[_first_unknown((g.name, self._objects), (g.state, STATES)) for g in goals.states],
            *[
                _first_unknown(
                    (g.from_name, self._objects), (g.to_name, self._objects), (g.relation, RELATIONS)
                )
                for g in goals.relations
            ],
            *[_first_unknown((action, self._known_actions)) for action in goals.actions],
        ]
        return [name for name in found if name is not None]

    def unread(self) -> dict[GoalKind, Confusion]:
        """All goals are missed."""
        return {kind: confusion(0, 0, len(gold)) for kind, gold in zip(GoalKind, self._gold, strict=True)}


class ByLargestId:
    """The matching of protocol `eai-1.0.5` (reference: ``goal_interpretation/scripts/evaluate_results.py``).

    Its quirks: a name means the relevant object of its class with the largest id (in the reference the last
    one of a set in hash order, which for all published counts is this one); predictions with an unknown name,
    and entries that are ill-formed, count nothing; an action goal can be met many times, which may make false
    negatives negative; an answer that cannot be read misses nothing.
    """

    def __init__(self, task: Task) -> None:
        self._gold = gold_goals(task)
        by_id = sorted(task.relevant, key=lambda i: object_id(task.initial, i))
        self._objects = {task.scene.objects[i].category: task.scene.objects[i].name for i in by_id}
        self._states = frozenset(self._gold.states)
        self._relations = frozenset(self._gold.relations)
        self._actions = frozenset([action for goal in self._gold.actions for action in goal])

    def count(self, goals: WrittenGoals) -> dict[GoalKind, Confusion]:
        """The counts of the predictions whose names are known."""
        states, relations = self._named(goals)
        return {
            GoalKind.STATE: confusion(
                sum([goal in self._states for goal in states]), len(states), len(self._states)
            ),
            GoalKind.RELATION: confusion(
                sum([goal in self._relations for goal in relations]), len(relations), len(self._relations)
            ),
            GoalKind.ACTION: confusion(
                sum([action in self._actions for action in goals.actions]),
                len(goals.actions),
                len(self._gold.actions),
            ),
        }

    def met(self, goals: WrittenGoals) -> list[bool]:
        """Each gold goal is met by any prediction that is equal to it."""
        states, relations = self._named(goals)
        return [
            *[goal in states for goal in self._gold.states],
            *[goal in relations for goal in self._gold.relations],
            *[any(action in goals.actions for action in goal) for goal in self._gold.actions],
        ]

    def wrong(self, goals: WrittenGoals) -> list[str]:
        """The predictions whose names are known and that are equal to no goal."""
        states, relations = self._named(goals)
        return [
            *_texts(goal for goal in states if goal not in self._states),
            *_texts(goal for goal in relations if goal not in self._relations),
            *dict.fromkeys(action for action in goals.actions if action not in self._actions),
        ]

    def hallucinated(self, goals: WrittenGoals) -> list[str]:
        """Objects that are not among the relevant ones."""
        known = self._objects
        found = [
            *[_first_unknown((g.name, known)) for g in goals.states],
            *[_first_unknown((g.from_name, known), (g.to_name, known)) for g in goals.relations],
        ]
        return [name for name in found if name is not None]

    def unread(self) -> dict[GoalKind, Confusion]:
        """Nothing is counted."""
        return {kind: confusion(0, 0, 0) for kind in GoalKind}

    def _named(self, goals: WrittenGoals) -> tuple[list[StateGoal], list[RelationGoal]]:
        """The predictions whose names are known, said of the objects that the names mean."""
        names = self._objects
        states = [StateGoal(names[name], state) for name, state in goals.states if name in names]
        relations = [
            RelationGoal(names[thing], relation, names[other])
            for thing, relation, other in goals.relations
            if thing in names and other in names
        ]
        return states, relations


def _texts(goals: Iterable[StateGoal | RelationGoal]) -> list[str]:
    """Goals as text, each once."""
    return list(dict.fromkeys(map(_text, goals)))


def _text(goal: StateGoal | RelationGoal) -> str:
    if isinstance(goal, StateGoal):
        return f"{goal.state}({goal.name})"
    return f"{goal.relation}({goal.from_name}, {goal.to_name})"


def _use(goal: T, predicted: Counter[T]) -> bool:
    """Take one prediction of a goal away; whether there was one."""
    if not predicted[goal]:
        return False
    predicted[goal] -= 1
    return True


def _first_unknown(*names: tuple[str, Container[str]]) -> str | None:
    """The first name that is not in the vocabulary beside it."""
    return next((name for name, known in names if name not in known), None)
