"""Score BEHAVIOR plans as eai-eval 1.0.5 (the paper's package) does (``action_sequence_evaluator.py``).

The package eai-eval evaluates the text from the first ``[`` to the first ``]`` of an answer as a Python
expression. It keeps dictionaries with an action and an object, and silently drops everything else. This
module evaluates only literals and calls of ``dict``, and executes no other code.
"""

from __future__ import annotations

import ast
import json
import re
import warnings
from collections.abc import Collection, Sequence

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.notation.plan_form import WrittenPlan, WrittenStep, strip_blanks_around_names
from eai.abilities.notation.plans import Execution, JsonPlanNotation, PlanExecutor
from eai.abilities.scorer import Assessment
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.benchmarks.behavior.domain import make_domain_with_checks_in_paper_order
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.extensions.reference import behavior_quirks
from eai.extensions.reference.behavior_quirks import make_behavior_goal_test
from eai.extensions.reference.plans import add_notes_on_strict_protocol
from eai.world.fault import FaultKind
from eai.world.state import State

_NO_ACTIONS = Unreadable("no actions were found")
_MAX_LIST_CHARACTERS = 1_000_000
_TEXT_OR_COMMENT = re.compile(r'("[^"\r\n]*")|#[^\r\n]*')


class _BehaviorPlanNotation(JsonPlanNotation):
    """The notation of BEHAVIOR plans, read as eai-eval (the paper's package) reads it."""

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Return the plan in an answer (eai-eval: ``parse_response``)."""
        return read_plan(text)


class BehaviorActionSequencingScorer(ActionSequencingScorer):
    """Scores plans for a task of BEHAVIOR as eai-eval (the paper's package) does.

    If an answer cannot be executed, the goals that hold in the initial state count as reached. A plan that
    fails after it has reached all goals succeeds.
    """

    def __init__(self, task: BehaviorTask) -> None:
        domain = behavior_quirks.make_domain_with_all_quirks()
        super().__init__(task, domain, _BehaviorPlanNotation(), make_behavior_goal_test(task))

    def assess(self, text: str) -> Assessment:
        """Return the verdict on an answer by eai-eval (the paper's package), with an explanation.

        If the protocol `strict` (the paper's text) reads other steps in the answer, the explanation also has
        the verdict by `strict`.
        """
        return add_notes_on_strict_protocol(
            super().assess(text), text, self.notation, self._make_scorer_of_strict_protocol
        )

    def _make_scorer_of_strict_protocol(self) -> ActionSequencingScorer:
        return ActionSequencingScorer(self.task, make_domain_with_checks_in_paper_order(), JsonPlanNotation())

    def _get_final_state(self, execution: Execution) -> State:
        """Return the final state of a plan. An action on which eai-eval crashes is executed in part."""
        trajectory = execution.trajectory
        final, failure = trajectory.final_state, trajectory.failure
        if failure is not None and failure.kind is FaultKind.UNCATEGORISED:
            return behavior_quirks.find_state_left_by_aborted_action(final, trajectory.steps[-1].action)
        return final

    def _test_goals(self, execution: Execution) -> tuple[bool, ...]:
        return self.goals.evaluate_each_goal(self._get_final_state(execution), ())

    def _get_goals_met_by_rejected_answer(self, execute: PlanExecutor) -> tuple[bool, ...]:
        return self.goals.evaluate_each_goal(execute(()).trajectory.final_state, ())

    def _is_success(self, error: ErrorReport | None, reached: tuple[bool, ...]) -> bool:
        return all(reached)


def read_plan(text: str) -> WrittenPlan | Unreadable:
    """Return the steps that eai-eval (the paper's package) finds in an answer, in order."""
    start, end = text.find("["), text.find("]")
    segment = text[start : end + 1]
    if start < 0 or len(segment) > _MAX_LIST_CHARACTERS:
        return _NO_ACTIONS
    steps = _read_json_steps(segment) or _read_python_steps(segment)
    return WrittenPlan(tuple(steps)) if steps else _NO_ACTIONS


def _read_json_steps(segment: str) -> list[WrittenStep] | None:
    """Return the steps of a list whose meaning in JSON and in Python is equal; None for any other list.

    All values must be plain strings. Most answers are such lists. Reading them as JSON makes scoring twice as
    fast.
    """
    if "\\" in segment:
        return None
    elements = _parse_json(segment)
    if elements is None and "#" in segment:
        elements = _parse_json(_TEXT_OR_COMMENT.sub(r"\1", segment))
    if elements is None:
        return None
    if {*map(type, elements)} - {dict}:
        return None
    values = {type(value) for element in elements for value in element.values()}
    return None if values - {str} else _to_steps(elements)


def _parse_json(segment: str) -> list[dict[str, str]] | None:
    """Return the value of a JSON text without checking its type, or None if it is not JSON."""
    try:
        elements: list[dict[str, str]] = json.loads(segment)
    except (ValueError, RecursionError):
        return None
    return elements


def _read_python_steps(segment: str) -> list[WrittenStep] | None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            elements = _evaluate_expression(ast.parse(segment.strip(), mode="eval").body)
    except (SyntaxError, ValueError, TypeError, RecursionError, MemoryError):
        return None
    if not isinstance(elements, list):
        return None
    dictionaries = [element for element in elements if isinstance(element, dict)]
    return _to_steps(
        [
            {key: str(element[key]) for key in ("action", "object") if key in element}
            for element in dictionaries
        ]
    )


def _to_steps(dictionaries: list[dict[str, str]]) -> list[WrittenStep]:
    return [
        WrittenStep(step["action"], strip_blanks_around_names(step["object"].strip().split(",")))
        for step in dictionaries
        if "action" in step and "object" in step
    ]


def _evaluate_expression(node: ast.expr) -> object:
    """Return the value of an expression of literals, lists, dictionaries and calls of ``dict`` with keywords.

    An f-string counts as a literal if it has no replacement field.

    Raises:
        ValueError, TypeError: the expression has another form, or Python cannot evaluate it.
    """
    match node:
        case ast.List(elements):
            return [_evaluate_expression(element) for element in elements]
        case ast.Dict(keys, values):
            return _evaluate_dictionary(keys, values)
        case ast.Call(ast.Name("dict"), [], keywords):
            keys = [None if keyword.arg is None else ast.Constant(keyword.arg) for keyword in keywords]
            return _evaluate_dictionary(keys, [keyword.value for keyword in keywords])
        case ast.JoinedStr(parts):
            return "".join([str(_evaluate_literal(part)) for part in parts])
        case _:
            return _evaluate_literal(node)


def _evaluate_dictionary(keys: Sequence[ast.expr | None], values: Sequence[ast.expr]) -> dict[object, object]:
    """Build a dictionary. An entry without a key (``**name``) adds the entries of another dictionary."""
    dictionary: dict[object, object] = {}
    for key, node in zip(keys, values, strict=True):
        value = _evaluate_expression(node)
        if key is not None:
            dictionary[_evaluate_literal(key)] = value
        elif isinstance(value, dict):
            dictionary.update(value)
        else:
            raise TypeError("expected a dictionary after **")
    return dictionary


def _evaluate_literal(node: ast.expr) -> object:
    """Return the value of a literal. Constants skip `ast.literal_eval`, which leaves reference cycles."""
    return node.value if isinstance(node, ast.Constant) else ast.literal_eval(node)
