"""Goal interpretation of BEHAVIOR as in eai-eval 1.0.5 (``evaluate_results.py``)."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from eai.abilities.explanation import Explanation, GoalReport, Statement, find_names
from eai.abilities.goal_interpretation.scorer import wrong_goal_notes
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import ALL, Confusion, ErrorReport, Unreadable
from eai.benchmarks.behavior.notation import RELATIONS, STATES
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.tasks.task import GoalKind
from eai.world.fault import FaultKind

_OBJECT = re.compile(r"{[^{}]*}")

_NO_LIST = Unreadable("a section is not a list")
_NO_CONDITION = Unreadable("a condition is empty, or not a list")
"""Answers at which the whole run of the reference ends."""

Value: TypeAlias = object
"""An element of an answer's list: a JSON value, lists as tuples."""


_WELL_FORMED = (2, 3)
"""How many parts a condition has: a predicate, and one object or two."""


def see(condition: Value) -> tuple[Value, ...]:
    """The parts of a condition after ``not``, the first of which is its predicate; none if it is none.

    A string is a list of letters here.
    """
    parts = _parts(condition)
    if parts[:1] == ("not",):
        return _parts(parts[1]) if len(parts) > 1 else ()
    return parts


def _kind(predicate: Value) -> GoalKind | None:
    """State or relation, by the predicate; None if there is no such predicate."""
    if predicate in STATES:
        return GoalKind.STATE
    return GoalKind.RELATION if predicate in RELATIONS else None


def read_conditions(text: str) -> tuple[Value, ...] | Unreadable:
    """The conditions that the reference finds in an answer.

    Its quirks: the whole answer is put in lower case, apostrophes become quotation marks, and what counts is
    what stands between the first opening brace and the next brace; names of sections do not matter. Values of
    an unexpected type abort the whole run.
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
            return _NO_LIST
        conditions += map(_frozen, section)
    return tuple(conditions) if all(map(see, conditions)) else _NO_CONDITION


class ByFirstOption(Scorer):
    """The scorer of goals as the reference compares conditions with those of a task.

    Its quirks: of several options that meet equally many conditions the first counts; a condition that stands
    in two goals counts twice, and so does a wrong one stated twice; ``nextto`` has a direction; a wrong
    condition whose predicate does not exist is neither a state nor a relation; an answer that cannot be read
    predicts nothing.
    """

    def __init__(self, task: BehaviorTask) -> None:
        self._goals = task.record.goal_options
        self._objects = frozenset(thing.instance for thing in task.record.objects)

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and which goals of the task it has, and what else it says."""
        conditions = read_conditions(text)
        if isinstance(conditions, Unreadable):
            verdict = replace(
                self._judge(()),
                error=ErrorReport(FaultKind.PARSING, None, conditions.reason),
                aborts=conditions in (_NO_LIST, _NO_CONDITION),
            )
            return Assessment(verdict, partial(self._explain, (f"parsing: {conditions.reason}",), ()))
        verdict = self._judge(conditions)
        return Assessment(verdict, lambda: self._explain(wrong_goal_notes(verdict), conditions))

    def _judge(self, conditions: Sequence[Value]) -> GoalVerdict:
        seen = [*map(see, conditions)]
        formed = [parts for parts in seen if len(parts) in _WELL_FORMED]
        unknown = [[name for name in names if name not in self._objects] for _, *names in formed]
        groups = self._groups(conditions)
        kinds = [[_kind(see(each)[0]) for each in group] for group in groups]
        matched, wrong, missing = [tuple(map(_text, group)) for group in groups]
        return GoalVerdict(
            counts={
                **{kind.value: Confusion(*[group.count(kind) for group in kinds]) for kind in GoalKind},
                ALL: Confusion(*map(len, groups)),
            },
            predicted=len(conditions),
            ill_formed=len(seen) - len(formed),
            hallucinated=tuple(str(names[0]) for names in unknown if names),
            unknown_predicates=tuple(str(parts[0]) for parts in seen if _kind(parts[0]) is None),
            matched=matched,
            wrong=wrong,
            missing=missing,
        )

    def _groups(self, predicted: Sequence[Value]) -> tuple[list[Value], list[Value], list[Value]]:
        """Return the conditions that are right, that are wrong and that are missed."""
        stated = frozenset(predicted)
        wanted = [condition for option in self._chosen(stated) for condition in option]
        needed = frozenset[Value](wanted)
        return (
            [condition for condition in wanted if condition in stated],
            [condition for condition in predicted if condition not in needed],
            [condition for condition in wanted if condition not in stated],
        )

    def _chosen(self, stated: frozenset[Value]) -> list[tuple[Value, ...]]:
        """Of each goal the first of the options that meet most conditions."""
        return [
            max(options, key=lambda option: sum([condition in stated for condition in option]))
            for options in self._goals
        ]

    def _explain(self, notes: tuple[str, ...], predicted: Sequence[Value]) -> Explanation:
        stated = frozenset(predicted)
        return Explanation(
            notes=notes,
            goals=tuple(
                GoalReport("condition", text, stated.issuperset(option), predicates=find_names(text))
                for option in self._chosen(stated)
                for text in (" and ".join(map(_text, option)),)
            ),
            atoms={_text(each): _statement(each) for group in self._groups(predicted) for each in group},
        )


def _parts(value: Value) -> tuple[Value, ...]:
    return tuple(value) if isinstance(value, tuple | str) else ()


def _frozen(value: object) -> Value:
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def _text(condition: Value) -> str:
    match condition:
        case ("not", inner):
            return f"not {_text(inner)}"
        case (predicate, *arguments):
            return f"{predicate}({', '.join(map(str, arguments))})"
        case _:
            return str(condition)


def _statement(condition: Value) -> Statement:
    """The statement of a condition; one of another form is a name."""
    match condition:
        case ("not", (predicate, *arguments)):
            return Statement(str(predicate), tuple(map(str, arguments)), positive=False)
        case (predicate, *arguments):
            return Statement(str(predicate), tuple(map(str, arguments)))
        case _:
            return Statement(_text(condition), None)
