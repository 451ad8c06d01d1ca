"""Verdicts on operators: those that are of `strict`, and those that are not."""

from __future__ import annotations

import pytest

from abilities.transition_modeling.test_scorer import (
    EVERYTHING,
    GHOST,
    LIGHT,
    OPEN,
    SILENT,
    STAMP,
    TASK_OF_TWO,
    MakeRules,
    answer,
    counts,
    score,
    test_a_verdict_names_the_planner,
    test_caches_of_rules_have_a_maximum_size,
    test_equal_operators_are_planned_with_once,
    test_the_gold_answer_has_no_error,
    test_without_a_planner_nothing_is_said_of_plans,
)
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorComparisonStatus, OperatorVerdict
from eai.extensions.reference.operator_rules import EaiEvalOperatorScoringRules
from eai.pddl.planning import PlannerOutcome
from eai.pddl.search import BuiltInPlanner

SHARED = (
    test_a_verdict_names_the_planner,
    test_equal_operators_are_planned_with_once,
    test_caches_of_rules_have_a_maximum_size,
    test_the_gold_answer_has_no_error,
    test_without_a_planner_nothing_is_said_of_plans,
)
"""Tests of `strict` that are run again with the fixtures below."""


@pytest.fixture
def rules_with() -> MakeRules:
    return EaiEvalOperatorScoringRules


@pytest.fixture
def problems() -> int:
    """Gold operators fill the gaps of both answers, so that they are one problem."""
    return 1


def test_a_missing_operator_costs_nothing() -> None:
    verdict = score(answer(LIGHT), EaiEvalOperatorScoringRules)
    assert counts(verdict)["precondition"] == {"spatial_relations": (1, 0, 0)}
    assert verdict.planner is PlannerOutcome.SOLVED


def test_what_was_not_asked_for_helps() -> None:
    verdict = score(answer(OPEN, SILENT, STAMP), EaiEvalOperatorScoringRules)
    assert verdict.planner is PlannerOutcome.SOLVED
    compared, hallucinated = OperatorComparisonStatus.COMPARED, OperatorComparisonStatus.HALLUCINATED
    assert [each.status for each in verdict.operators] == [compared, compared, hallucinated]


def test_a_predicate_that_the_domain_lacks_is_not_counted() -> None:
    found = counts(score(answer(OPEN, GHOST), EaiEvalOperatorScoringRules))["precondition"]
    assert found == {"object_states": (1, 0, 0), "spatial_relations": (1, 1, 1)}


def test_an_unreadable_answer_is_left_out() -> None:
    verdict = score("3", EaiEvalOperatorScoringRules)
    assert verdict.excluded is not None
    assert verdict.counts is None


def test_a_plan_is_enough() -> None:
    scorer = TransitionModelingScorer(TASK_OF_TWO, EaiEvalOperatorScoringRules(BuiltInPlanner()))
    verdict = scorer.score(answer(EVERYTHING, TASK_OF_TWO.domain.operators["light"]))
    assert isinstance(verdict, OperatorVerdict)
    assert (verdict.planner, verdict.success, verdict.plan_works) == (PlannerOutcome.SOLVED, True, None)
