"""Verdicts on operators with one of forty kinds of damage. A test of this name covers `strict`."""

from __future__ import annotations

import json

import pytest

from abilities.transition_modeling.test_mutations import (
    EACH_MUTATION,
    LONGEST,
    MUTATIONS,
    WHOLE_ANSWERS,
    S,
    U,
    mutate_operator,
    operator,
    score,
    task,
)
from eai.extensions.reference.operator_rules import EaiEvalOperatorScoringRules
from eai.tasks.operator_task import TransitionTask

SHARED = (task,)
"""The fixture of the task."""

OTHERWISE = {
    "undeclared type of a parameter": U,
    "undeclared type of a quantifier": U,
    "a type as a predicate": U,
    "unbound variable in a condition": U,
    "unbound variable under not": S,
    "unbound variable in a deletion": S,
    "unbound variable in an addition": "unsupported",
    "a quantified name used outside": S,
    "an object of the problem": S,
    "an unknown object": U,
    "a parameter of several types": U,
    LONGEST: S,
}
"""Outcomes of mutations that are not those of `strict`."""

WHOLE_OTHERWISE = {
    "": S,
    "I cannot do that.": S,
    "[" * 500_000: S,
    "(" * 1_000_000: S,
    "x" * 1_000_000: S,
    '{"open": {"parameters": ["?o"], "effect": ["wide"]}}': None,
    json.dumps({"output": ""}): S,
    operator(): S,
    f"{operator()} (:action light": S,
}
"""Outcomes of whole answers that differ from `strict`."""


@EACH_MUTATION
def test_a_mutated_operator_has_its_documented_outcome(task: TransitionTask, name: str) -> None:
    planner = score(task, mutate_operator(name), EaiEvalOperatorScoringRules).planner
    assert planner is not None
    assert planner.value == OTHERWISE.get(name, MUTATIONS[name][1])


@pytest.mark.parametrize(("answer", "strict"), WHOLE_ANSWERS)
def test_an_answer_as_a_whole_has_its_documented_outcome(
    task: TransitionTask, answer: str, strict: str
) -> None:
    planner = score(task, answer, EaiEvalOperatorScoringRules).planner
    assert (planner and planner.value) == WHOLE_OTHERWISE.get(answer, strict)
