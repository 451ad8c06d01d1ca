"""Goal interpretation of VirtualHome as in eai-eval 1.0.5 (``scripts/evaluate_results.py``)."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from typing import Any

from eai.abilities.explanation import GoalReport, find_names
from eai.abilities.goal_interpretation.scorer import GoalInterpretation, ill_formed_texts
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goals import SECTIONS, IllFormed, WrittenGoal, WrittenGoals
from eai.abilities.verdict import ALL, Confusion, Unreadable
from eai.benchmarks.virtualhome.notation import FIELDS, VirtualHomeGoals, goal_of
from eai.benchmarks.virtualhome.predicates import object_id
from eai.logic.choice import choice_options
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain

_FENCE = "```json"
_NO_OBJECT = Unreadable("the answer is not a JSON object")
_OF_ANOTHER_TYPE = Unreadable("a section or an entry of it is not of the expected type")
"""Answers at which the whole run of the reference ends."""

_NAME_FIELDS = frozenset({"name", "from_name", "to_name"})


class _Notation(VirtualHomeGoals):
    """The notation of goals as the reference reads it.

    Its quirks: JSON is not looked for in prose, and only a fence at the very start is removed; every
    apostrophe becomes a quotation mark; entries are duplicates only if all their fields agree, so that an
    action with two descriptions is predicted twice; much that is not of the expected type aborts the whole
    run, see `_NO_OBJECT`.
    """

    def read(self, text: str) -> WrittenGoals | Unreadable:
        """The goals that the reference finds in an answer."""
        text = text.replace("<|eot_id|>", "")
        if text.startswith(_FENCE):
            text = text.removeprefix(_FENCE).strip("`")
        try:
            value = json.loads(text.strip().replace("\n", "").replace("'", '"'))
        except (ValueError, RecursionError) as error:
            return Unreadable(f"the answer is not JSON: {error}")
        if not isinstance(value, dict):
            return _NO_OBJECT
        try:
            read = [each for kind in GoalKind for each in _entries(kind, value.get(SECTIONS[kind], []))]
        except (TypeError, AttributeError, RecursionError):
            return _OF_ANOTHER_TYPE
        return WrittenGoals.from_entries(read)


class ByLargestId(GoalInterpretation):
    """The scorer of goals as the reference compares them with those of a task.

    Its quirks: a name means the relevant object of its class with the largest id (in the reference the last
    one of a set in hash order, which for all published counts is this one); predictions with an unknown name,
    and entries that are ill-formed, count nothing; an action goal can be met many times, which may make false
    negatives negative; an answer that cannot be read misses nothing.
    """

    def __init__(self, task: Task, domain: Domain) -> None:
        notation = _Notation()
        super().__init__(task, domain, notation)
        by_id = sorted(task.relevant, key=lambda i: object_id(task.initial, i))
        self._objects = {task.scene.objects[i].category: task.scene.objects[i].name for i in by_id}
        self._options: list[tuple[str, frozenset[WrittenGoal]]] = []
        for goal in notation.alternatives(task):
            literals = chain.from_iterable(choice_options(goal.options))
            options = dict.fromkeys(map(self.lexicon.to_ground_goal, literals))
            self._options.append((" or ".join(map(str, options)), frozenset(options)))
        self._needed = frozenset().union(*[options for _, options in self._options])
        self._totals = tuple((kind, len(task.goals_of(kind))) for kind in GoalKind)

    def judge_unreadable(self, goals: Unreadable) -> GoalVerdict:
        """Nothing is counted."""
        verdict = super().judge_unreadable(goals)
        return replace(
            verdict,
            counts=dict.fromkeys(verdict.counts or (), Confusion(0, 0, 0)),
            missing=(),
            aborts=goals in (_NO_OBJECT, _OF_ANOTHER_TYPE),
        )

    def score_missing_answer(self) -> GoalVerdict:
        """All goals are missed: the reference passes over answers that it cannot read, not over tasks."""
        return self.judge(WrittenGoals(()))

    def judge(self, goals: WrittenGoals) -> GoalVerdict:
        """The counts of the predictions whose names are known."""
        named = self._named(goals)
        known = [goal for goal in named if isinstance(goal, WrittenGoal)]
        matched = [goal for goal in known if goal in self._needed]
        wrong = [goal for goal in known if goal not in self._needed]
        right_kinds, wrong_kinds = [*map(_kind, matched)], [*map(_kind, wrong)]
        counts = {}
        for kind, total in self._totals:
            right = right_kinds.count(kind)
            counts[kind.value] = Confusion(right, wrong_kinds.count(kind), total - right)
        counts[ALL] = Confusion(*map(sum, zip(*counts.values(), strict=True)))
        return GoalVerdict(
            counts=counts,
            predicted=len(goals.goals) + len(goals.ill_formed),
            ill_formed=len(goals.ill_formed),
            hallucinated=tuple([name for name in named if isinstance(name, str)]),
            matched=tuple(map(str, matched)),
            wrong=tuple(map(str, wrong)),
            missing=tuple([text for text, options in self._options if options.isdisjoint(matched)]),
        )

    def list_compared(self, goals: WrittenGoals) -> Iterable[WrittenGoal]:
        """The predictions whose names are known, and what is needed."""
        named = [goal for goal in self._named(goals) if isinstance(goal, WrittenGoal)]
        return (*named, *self._needed)

    def describe_left_out(self, goals: WrittenGoals) -> Iterable[str]:
        """Entries that lack a field, and goals with an unknown name."""
        yield from ill_formed_texts(goals.ill_formed)
        for name in dict.fromkeys(name for name in self._named(goals) if isinstance(name, str)):
            yield f"left out as hallucination: there is no {name}"

    def report_goals(self, goals: WrittenGoals) -> tuple[GoalReport, ...]:
        """Each goal is met by any prediction that is equal to it."""
        named = frozenset(self._named(goals))
        found = []
        for goal, (_, options) in zip(self.gold.goals, self._options, strict=True):
            text, met = goal.text or "", not named.isdisjoint(options)
            found.append(GoalReport(goal.kind, text, met, predicates=find_names(text)))
        return tuple(found)

    def _named(self, goals: WrittenGoals) -> list[WrittenGoal | str]:
        """The predictions about the objects that the names mean; or the first name that means none."""
        named: list[WrittenGoal | str] = []
        for goal in goals.goals:
            unknown = [name for name in goal.names if name not in self._objects]
            meant = tuple([self._objects.get(name, name) for name in goal.names])
            named.append(unknown[0] if unknown else goal._replace(names=meant))
        return named


def _kind(goal: WrittenGoal) -> GoalKind:
    """The section that a goal stands in."""
    if goal.is_action:
        return GoalKind.ACTION
    return GoalKind.STATE if len(goal.names) == 1 else GoalKind.RELATION


def _entries(kind: GoalKind, values: Any) -> list[WrittenGoal | IllFormed]:
    """The goals of a section; duplicates and empty entries are left out.

    Raises:
        TypeError: the reference aborts, for a value that it cannot iterate, index, measure or look up.
    """
    unique = {_hashable(value): value for value in values}
    names = FIELDS[kind]
    return [_goal(names, entry) or (kind, str(entry)) for entry in unique.values() if len(entry)]


def _goal(names: tuple[str, ...], entry: Any) -> WrittenGoal | None:
    """Return the statement of an entry; None if it lacks a field."""
    if any(name not in entry for name in names):
        return None
    return goal_of([_text(name, entry[name]) for name in names])


def _hashable(value: Any) -> object:
    if isinstance(value, dict):
        return frozenset([(key, _hashable(part)) for key, part in value.items()])
    return tuple([_hashable(part) for part in value]) if isinstance(value, list) else value


def _text(field: str, value: Any) -> str:
    """A field as text; what is no string becomes something that no name or state is equal to.

    Raises:
        TypeError: the reference aborts, for an action that is no string or a name that cannot be looked up.
    """
    if isinstance(value, str):
        return value
    if field == "action":
        raise TypeError("an action must be a string")
    if field in _NAME_FIELDS:
        hash(value)
    return json.dumps(value)
