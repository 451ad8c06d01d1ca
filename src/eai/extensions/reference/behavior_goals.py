"""Score goal interpretation of BEHAVIOR as eai-eval 1.0.5 does (``evaluate_results.py``)."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from eai.abilities.explanation import AtomOrAction, GoalReport, VerdictExplanation, find_predicate_names
from eai.abilities.goal_interpretation.scorer import describe_wrong_goals
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import ALL, ConfusionCounts, ErrorReport, Unreadable
from eai.benchmarks.behavior.notation import RELATIONS, STATES
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.tasks.task import GoalKind
from eai.world.fault import FaultKind

_OBJECT = re.compile(r"{[^{}]*}")

_SECTION_IS_NO_LIST = Unreadable("a section is not a list")
_CONDITION_IS_MALFORMED = Unreadable("a condition is empty, or not a list")
"""Why an answer cannot be read. On these answers, eai-eval (the paper's package) crashes and ends its run."""

Value: TypeAlias = object
"""Type of a condition in an answer: a JSON value with tuples instead of lists."""


_ALLOWED_PART_COUNTS = (2, 3)
"""Allowed numbers of elements of a condition: a predicate with one object or two objects."""


def split_condition_into_predicate_and_objects(condition: Value) -> tuple[Value, ...]:
    """Return a condition, without its ``not``, as a tuple: the predicate, then its objects.

    The tuple is empty if the value is not a condition. As in eai-eval, a string counts as a list of
    letters.
    """
    parts = _to_tuple(condition)
    if parts[:1] == ("not",):
        return _to_tuple(parts[1]) if len(parts) > 1 else ()
    return parts


def _find_goal_kind(predicate: Value) -> GoalKind | None:
    """Return whether a predicate is a state or a relation, as a kind of goal; None for unknown predicates."""
    if predicate in STATES:
        return GoalKind.STATE
    return GoalKind.RELATION if predicate in RELATIONS else None


def read_conditions(text: str) -> tuple[Value, ...] | Unreadable:
    """Return the conditions that eai-eval (the paper's package) finds in an answer.

    Defects of eai-eval: it changes the answer to lower case and apostrophes to quotation marks. It reads
    only the text between the first opening brace and the next closing brace, as a JSON object, and ignores
    the object's keys. Values of an unexpected type crash the whole run.
    """
    match = _OBJECT.search(text.lower().replace("'", '"').replace("toggledon", "toggled_on"))
    if match is None:
        return Unreadable("there is no object in braces")
    try:
        sections = json.loads(match[0])
    except (ValueError, RecursionError) as error:
        return Unreadable(f"the object in braces is not JSON: {error}")
    conditions: list[Value] = []
    for section in sections.values():
        if not isinstance(section, list | str):
            return _SECTION_IS_NO_LIST
        conditions += map(_replace_lists_by_tuples, section)
    if all(map(split_condition_into_predicate_and_objects, conditions)):
        return tuple(conditions)
    return _CONDITION_IS_MALFORMED


class BehaviorGoalInterpretationScorer(Scorer):
    """Scores goals as eai-eval does: it compares an answer's conditions with those of a task.

    Defects of eai-eval:

    * if several options (ways to meet a goal) share equally many conditions with the answer, the first
      option counts;
    * a condition in two goals counts twice, and so does a wrong condition that the answer repeats;
    * ``nextto`` has a direction;
    * a wrong condition whose predicate does not exist is neither a state nor a relation;
    * an unreadable answer counts as an answer without conditions.
    """

    def __init__(self, task: BehaviorTask) -> None:
        self._goals = task.record.goal_options
        self._objects = frozenset(thing.instance for thing in task.record.objects)

    def assess(self, text: str) -> Assessment:
        """Return the verdict on an answer, with an explanation that lists goals and wrong conditions."""
        conditions = read_conditions(text)
        if isinstance(conditions, Unreadable):
            verdict = replace(
                self._judge_conditions(()),
                error=ErrorReport(FaultKind.PARSING, None, conditions.reason),
                aborts=conditions in (_SECTION_IS_NO_LIST, _CONDITION_IS_MALFORMED),
            )
            notes = (f"parsing: {conditions.reason}",)
            return Assessment(verdict, partial(self._explain_conditions, notes, ()))
        verdict = self._judge_conditions(conditions)
        return Assessment(
            verdict, lambda: self._explain_conditions(describe_wrong_goals(verdict), conditions)
        )

    def _judge_conditions(self, conditions: Sequence[Value]) -> GoalVerdict:
        seen = [*map(split_condition_into_predicate_and_objects, conditions)]
        formed = [parts for parts in seen if len(parts) in _ALLOWED_PART_COUNTS]
        unknown = [[name for name in names if name not in self._objects] for _, *names in formed]
        groups = self._split_into_matched_additional_missing_clauses(conditions)
        kinds = [
            [_find_goal_kind(split_condition_into_predicate_and_objects(condition)[0]) for condition in group]
            for group in groups
        ]
        matched, wrong, missing = [tuple(map(_format_condition, group)) for group in groups]
        return GoalVerdict(
            counts={
                **{kind.value: ConfusionCounts(*[group.count(kind) for group in kinds]) for kind in GoalKind},
                ALL: ConfusionCounts(*map(len, groups)),
            },
            predicted=len(conditions),
            ill_formed=len(seen) - len(formed),
            hallucinated=tuple(str(names[0]) for names in unknown if names),
            unknown_predicates=tuple(str(parts[0]) for parts in seen if _find_goal_kind(parts[0]) is None),
            matched=matched,
            wrong=wrong,
            missing=missing,
        )

    def _split_into_matched_additional_missing_clauses(
        self, answer_conditions: Sequence[Value]
    ) -> tuple[list[Value], list[Value], list[Value]]:
        stated = frozenset(answer_conditions)
        wanted = [
            condition
            for option in self._choose_goal_options_closest_to_answer(stated)
            for condition in option
        ]
        needed = frozenset[Value](wanted)
        return (
            [condition for condition in wanted if condition in stated],
            [condition for condition in answer_conditions if condition not in needed],
            [condition for condition in wanted if condition not in stated],
        )

    def _choose_goal_options_closest_to_answer(
        self, answer_conditions: frozenset[Value]
    ) -> list[tuple[Value, ...]]:
        """Return one option (way to meet the goal) for each goal.

        It is the option that shares most conditions with the answer, the first one if several do.
        """
        return [
            max(options, key=lambda option: sum([condition in answer_conditions for condition in option]))
            for options in self._goals
        ]

    def _explain_conditions(
        self, notes: tuple[str, ...], answer_conditions: Sequence[Value]
    ) -> VerdictExplanation:
        stated = frozenset(answer_conditions)
        return VerdictExplanation(
            notes=notes,
            goals=tuple(
                GoalReport(
                    "condition", text, stated.issuperset(option), predicates=find_predicate_names(text)
                )
                for option in self._choose_goal_options_closest_to_answer(stated)
                for text in (" and ".join(map(_format_condition, option)),)
            ),
            atoms={
                _format_condition(condition): _make_statement_from_nested_tuple(condition)
                for group in self._split_into_matched_additional_missing_clauses(answer_conditions)
                for condition in group
            },
        )


def _to_tuple(value: Value) -> tuple[Value, ...]:
    return tuple(value) if isinstance(value, tuple | str) else ()


def _replace_lists_by_tuples(value: object) -> Value:
    return tuple(map(_replace_lists_by_tuples, value)) if isinstance(value, list) else value


def _format_condition(condition: Value) -> str:
    match condition:
        case ("not", inner):
            return f"not {_format_condition(inner)}"
        case (predicate, *arguments):
            return f"{predicate}({', '.join(map(str, arguments))})"
        case _:
            return str(condition)


def _make_statement_from_nested_tuple(condition: Value) -> AtomOrAction:
    """Return a condition as an `AtomOrAction`: predicate, objects, and whether the condition is negated.

    An ill-formed condition becomes a predicate without objects.
    """
    match condition:
        case ("not", (predicate, *arguments)):
            return AtomOrAction(str(predicate), tuple(map(str, arguments)), positive=False)
        case (predicate, *arguments):
            return AtomOrAction(str(predicate), tuple(map(str, arguments)))
        case _:
            return AtomOrAction(_format_condition(condition), None)
