"""Every counter and every planner outcome of the reference, row by row, under eai-1.0.5."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import pytest

from abilities.transition_modeling.test_oracle import (
    behavior,
    planner,
    test_an_operator_has_the_name_that_was_asked_for,
    test_gold_answers_are_right_in_every_respect,
    virtualhome,
)
from eai.abilities.protocol import Protocol
from eai.abilities.transition_modeling.rules import OperatorScoringRules
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorComparisonStatus, OperatorVerdict
from eai.abilities.verdict import ConfusionCounts, Verdict
from eai.base.store import DataPackStore
from eai.benchmarks.published import TransitionTasks, open_behavior_transition_tasks
from eai.extensions.reference.operator_rules import EaiEvalOperatorScoringRules
from eai.pddl.matching import ClauseComparison
from eai.pddl.planning import PlannerOutcome
from eai.tasks.source import Source
from oracle import MODELS, Oracle
from sweeps import first_of

SHARED = (
    behavior,
    test_an_operator_has_the_name_that_was_asked_for,
    test_gold_answers_are_right_in_every_respect,
    virtualhome,
)
"""Tests of `strict`, with their fixtures of tasks, that are run again with the fixtures below."""


@pytest.fixture
def protocol() -> Protocol:
    return Protocol("eai-1.0.5")


@pytest.fixture
def status() -> OperatorComparisonStatus:
    return OperatorComparisonStatus.HALLUCINATED


@pytest.fixture
def rules() -> OperatorScoringRules:
    return EaiEvalOperatorScoringRules(planner())


@pytest.fixture
def plan_works() -> None:
    """No verdict says whether its plan works."""


@pytest.fixture(scope="module")
def behavior_as_published(data_store: DataPackStore) -> TransitionTasks:
    return open_behavior_transition_tasks(Source(data_store))


def expected(row: Mapping[str, Any], side: str) -> dict[str, list[int]]:
    counts = row[f"{side}_predicate_type_res"]
    return {name.replace("-", "_"): values for name, values in counts.items() if any(values)}


def counted(verdict: Verdict, side: str) -> dict[str, list[int]]:
    counts = (verdict.counts or {}).get(side, {})
    assert not isinstance(counts, ConfusionCounts)
    return {name: list(confusion) for name, confusion in counts.items()}


def assert_equal(row: Mapping[str, Any], verdict: Verdict, known: Collection[str], place: str) -> None:
    if row.get("format_wrong") or row.get("format_wrong_num"):
        assert verdict.excluded, place
        return
    for ours, theirs in (("precondition", "precond"), ("effect", "effect")):
        assert counted(verdict, ours) == expected(row, theirs), f"{place} {ours}"
    assert isinstance(verdict, OperatorVerdict), place
    operators = verdict.operators
    assert len(operators) == row["total_predict_action_num"], place
    hallucinated = [each for each in operators if each.status is OperatorComparisonStatus.HALLUCINATED]
    assert len(hallucinated) == row["hallucination_num"], place
    for part, key in (("precondition", "precond_action_type"), ("effect", "effect_action_type")):
        found = {each.name: _sizes(getattr(each, part), known) for each in operators}
        reference = {name: values for name, values in row[key].items() if any(values)}
        assert {name: sizes for name, sizes in found.items() if any(sizes)} == reference, f"{place} {part}"


def _sizes(side: ClauseComparison, known: Collection[str]) -> list[int]:
    """Matched, additional and missing predicates; the reference does not count those without a category."""
    return [sum(name in known for name in names) for names in (side.matched, side.additional, side.missing)]


@pytest.mark.parametrize("name", [*first_of(MODELS), "gold", "perturbed"])
def test_virtualhome_counters_and_planner(virtualhome: TransitionTasks, oracle: Oracle, name: str) -> None:
    rows = oracle("virtualhome", "transition_modeling", name)["tasks"]
    rules = EaiEvalOperatorScoringRules(planner())
    for row in rows:
        task = virtualhome[row["id"].split("@")[0]]
        verdict = TransitionModelingScorer(task, rules).score(row["llm_output"])
        assert_equal(row, verdict, task.domain.categories, row["id"])
        if row.get("planner"):
            assert verdict.success is row["planner"]["success"], row["id"]


@pytest.mark.parametrize("name", [*MODELS, "gt", "perturb_logic_only"])
def test_behavior_counters(behavior_as_published: TransitionTasks, oracle: Oracle, name: str) -> None:
    rows = oracle("behavior", "transition_modeling", name)["records"]
    rules = EaiEvalOperatorScoringRules(None)
    for row in rows:
        task = behavior_as_published[row["identifier"].split("@")[0]]
        verdict = TransitionModelingScorer(task, rules).score(row["response"])
        assert verdict.planner is PlannerOutcome.NOT_RUN
        assert_equal(row["verdict"], verdict, task.domain.categories, row["identifier"])
