"""Score goal interpretation of VirtualHome as eai-eval 1.0.5 does (``scripts/evaluate_results.py``)."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from typing import Any

from eai.abilities.explanation import GoalReport, find_predicate_names
from eai.abilities.goal_interpretation.scorer import GoalInterpretationScorer, describe_ill_formed_entries
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goals import SECTIONS, IllFormed, WrittenGoal, WrittenGoals
from eai.abilities.verdict import ALL, ConfusionCounts, Unreadable
from eai.benchmarks.virtualhome.notation import (
    FIELDS,
    VirtualHomeGoalNotation,
    make_goal_from_json_field_values,
)
from eai.benchmarks.virtualhome.predicates import get_object_id
from eai.logic.choice import generate_dnf_terms_of_tree
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain

_FENCE = "```json"
_NO_OBJECT = Unreadable("the answer is not a JSON object")
_UNEXPECTED_TYPE = Unreadable("a section or an entry of it is not of the expected type")
"""Reason why an answer cannot be read: a value of an unexpected type crashes the whole run of eai-eval.

The package eai-eval is the paper's own program.
"""

_NAME_FIELDS = frozenset({"name", "from_name", "to_name"})


class _VirtualHomeGoalNotation(VirtualHomeGoalNotation):
    """The notation of goals, read as eai-eval (the paper's package) reads it.

    Defects of eai-eval:

    * it does not search prose for JSON, and removes only a code fence at the very start;
    * every apostrophe becomes a quotation mark;
    * entries are duplicates only if all fields are equal, so an action with two descriptions counts twice;
    * many values of an unexpected type crash the whole run, see `_NO_OBJECT` and `_UNEXPECTED_TYPE`.
    """

    def read(self, text: str) -> WrittenGoals | Unreadable:
        """Return the goals that eai-eval (the paper's package) finds in an answer."""
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
            read = [
                entry for kind in GoalKind for entry in _read_entries(kind, value.get(SECTIONS[kind], []))
            ]
        except (TypeError, AttributeError, RecursionError):
            return _UNEXPECTED_TYPE
        return WrittenGoals.from_entries(read)


class VirtualHomeGoalInterpretationScorer(GoalInterpretationScorer):
    """Scores goals as eai-eval does: it compares an answer's goals (predictions) with a task's goals.

    Defects of eai-eval:

    * a name means one relevant object of its class: in eai-eval, the last object of a set in hash order. Here
      it is the object with the largest id, which gives the same published counts;
    * predictions with an unknown name and ill-formed entries are not counted;
    * several predictions can meet one action goal, which may make the number of false negatives negative;
    * in an unreadable answer, no goal counts as missing.
    """

    def __init__(self, task: Task, domain: Domain) -> None:
        notation = _VirtualHomeGoalNotation()
        super().__init__(task, domain, notation)
        by_id = sorted(task.relevant, key=lambda i: get_object_id(task.initial, i))
        self._objects = {task.scene.objects[i].category: task.scene.objects[i].name for i in by_id}
        self._options: list[tuple[str, frozenset[WrittenGoal]]] = []
        for goal in notation.list_alternatives_of_goals(task):
            literals = chain.from_iterable(generate_dnf_terms_of_tree(goal.options))
            options = dict.fromkeys(map(self.lexicon.to_goal_with_scene_names, literals))
            self._options.append((" or ".join(map(str, options)), frozenset(options)))
        self._needed = frozenset().union(*[options for _, options in self._options])
        self._totals = tuple((kind, len(task.get_goals_of_kind(kind))) for kind in GoalKind)

    def judge_unreadable(self, goals: Unreadable) -> GoalVerdict:
        """Return a verdict that counts neither predictions nor missing goals."""
        verdict = super().judge_unreadable(goals)
        return replace(
            verdict,
            counts=dict.fromkeys(verdict.counts or (), ConfusionCounts(0, 0, 0)),
            missing=(),
            aborts=goals in (_NO_OBJECT, _UNEXPECTED_TYPE),
        )

    def score_missing_answer(self) -> GoalVerdict:
        """Return a verdict in which all goals of the task count as missing.

        In eai-eval, goals are missing if there is no answer, but not if an answer is unreadable.
        """
        return self.judge(WrittenGoals(()))

    def judge(self, goals: WrittenGoals) -> GoalVerdict:
        """Return the verdict on an answer to goal interpretation.

        Goals with an unknown name count neither as right nor as wrong. Other goals are compared with the
        task's.
        """
        named = self._resolve_names_or_find_unknown_name(goals)
        resolved_goals = [goal for goal in named if isinstance(goal, WrittenGoal)]
        matched = [goal for goal in resolved_goals if goal in self._needed]
        wrong = [goal for goal in resolved_goals if goal not in self._needed]
        right_kinds, wrong_kinds = [*map(_find_kind_of_goal, matched)], [*map(_find_kind_of_goal, wrong)]
        counts = {}
        for kind, total in self._totals:
            right = right_kinds.count(kind)
            counts[kind.value] = ConfusionCounts(right, wrong_kinds.count(kind), total - right)
        counts[ALL] = ConfusionCounts(*map(sum, zip(*counts.values(), strict=True)))
        return GoalVerdict(
            counts=counts,
            predicted=len(goals.goals) + len(goals.ill_formed),
            ill_formed=len(goals.ill_formed),
            hallucinated=tuple([name for name in named if isinstance(name, str)]),
            matched=tuple(map(str, matched)),
            wrong=tuple(map(str, wrong)),
            missing=tuple([text for text, options in self._options if options.isdisjoint(matched)]),
        )

    def list_goals_with_known_names(self, goals: WrittenGoals) -> Iterable[WrittenGoal]:
        """Return the predictions (goals in an answer) whose names are known, and the goals of the task."""
        named = [
            goal for goal in self._resolve_names_or_find_unknown_name(goals) if isinstance(goal, WrittenGoal)
        ]
        return (*named, *self._needed)

    def describe_goals_left_out_of_score(self, goals: WrittenGoals) -> Iterable[str]:
        """Yield a note for each goal in an answer that lacks a field, and for each unknown name."""
        yield from describe_ill_formed_entries(goals.ill_formed)
        for name in dict.fromkeys(
            name for name in self._resolve_names_or_find_unknown_name(goals) if isinstance(name, str)
        ):
            yield f"left out as hallucination: there is no {name}"

    def report_goals(self, goals: WrittenGoals) -> tuple[GoalReport, ...]:
        """Return a report for each goal of the task: whether a prediction equals it."""
        named = frozenset(self._resolve_names_or_find_unknown_name(goals))
        reports = []
        for goal, (_, options) in zip(self.gold.goals, self._options, strict=True):
            text, met = goal.text or "", not named.isdisjoint(options)
            reports.append(GoalReport(goal.kind, text, met, predicates=find_predicate_names(text)))
        return tuple(reports)

    def _resolve_names_or_find_unknown_name(self, goals: WrittenGoals) -> list[WrittenGoal | str]:
        """Return each prediction with the objects that its names denote, or with its first unknown name."""
        named: list[WrittenGoal | str] = []
        for goal in goals.goals:
            unknown = [name for name in goal.names if name not in self._objects]
            meant = tuple([self._objects.get(name, name) for name in goal.names])
            named.append(unknown[0] if unknown else goal._replace(names=meant))
        return named


def _find_kind_of_goal(goal: WrittenGoal) -> GoalKind:
    if goal.is_action:
        return GoalKind.ACTION
    return GoalKind.STATE if len(goal.names) == 1 else GoalKind.RELATION


def _read_entries(kind: GoalKind, values: Any) -> list[WrittenGoal | IllFormed]:
    """Return the goals in a section of an answer, without duplicates and empty entries.

    Raises:
        TypeError: a value cannot be iterated, indexed, measured or looked up. On such a value, eai-eval
            crashes, too.
    """
    unique = {_make_hashable(value): value for value in values}
    names = FIELDS[kind]
    return [_read_goal(names, entry) or (kind, str(entry)) for entry in unique.values() if len(entry)]


def _read_goal(names: tuple[str, ...], entry: Any) -> WrittenGoal | None:
    if any(name not in entry for name in names):
        return None
    return make_goal_from_json_field_values(
        [_convert_goal_field_to_text(name, entry[name]) for name in names]
    )


def _make_hashable(value: Any) -> object:
    if isinstance(value, dict):
        return frozenset([(key, _make_hashable(part)) for key, part in value.items()])
    return tuple([_make_hashable(part) for part in value]) if isinstance(value, list) else value


def _convert_goal_field_to_text(field: str, value: Any) -> str:
    """Return a field of a goal as text. A value that is no string becomes JSON text, which matches no goal.

    Raises:
        TypeError: the value of the field ``action`` is no string, or the value of a field for names cannot be
            hashed. On these values, eai-eval crashes, too.
    """
    if isinstance(value, str):
        return value
    if field == "action":
        raise TypeError(f"action: expected a string, found {type(value).__name__}")
    if field in _NAME_FIELDS:
        hash(value)
    return json.dumps(value)
