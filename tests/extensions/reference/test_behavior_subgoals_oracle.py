"""Verdicts under `eai-1.0.5` against those of the reference, row by row."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator
from typing import Any

import pytest

from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.extensions.reference.behavior_subgoals import BehaviorSubgoalDecompositionScorer
from oracle import MODELS, SUBGOAL_CATEGORIES, Oracle
from subgoal_scorers import behavior_subgoals

SETS = (*MODELS, "gt", "perturb0", "perturb1", "perturb2")

KINDS = {"wrong_temporal_order": "wrong_order", "affordance_error": "affordance"}
"""The reference's name of an error -> our name, if they differ."""


def told_by_us(scorer: SubgoalDecompositionScorer, text: str) -> tuple[object, ...]:
    verdict = scorer.score(text)
    assert verdict.category is not None
    rejected = verdict.category.value in ("hallucination", "not_parseable")
    goals = None if rejected else list(verdict.goals_satisfied)
    errors = [kind.value for kind in verdict.errors]
    return verdict.category.value, verdict.success, errors, goals


def told_by_reference(verdict: Any) -> tuple[object, ...]:
    kinds = [KINDS.get(kind, kind) for (kind,) in verdict["error_types"] if kind != "goal_failed"]
    return SUBGOAL_CATEGORIES[verdict["category"]], verdict["task_success"], kinds, verdict["goals"]


def drawn(text: str) -> Iterator[str]:
    """Yield the answers that the reference may draw: one alternative of each subgoal."""
    found = re.search(r"{[^{}]*}", text.strip().replace("}}", "}"))
    assert found is not None
    output = json.loads(found[0])["output"]
    for pieces in itertools.product(*(dict.fromkeys(subgoal.split(" or ")) for subgoal in output)):
        yield json.dumps({"output": pieces})


@pytest.mark.parametrize("name", SETS)
def test_every_row_has_the_references_verdict(
    behavior_tasks: BehaviorTasks, oracle: Oracle, name: str
) -> None:
    for row in oracle("behavior", "subgoal_decomposition", name)["records"]:
        scorer = BehaviorSubgoalDecompositionScorer(behavior_tasks[row["identifier"]])
        expected = told_by_reference(row["verdict"])
        if not row["contains_or"]:
            assert (row["identifier"], told_by_us(scorer, row["response"])) == (row["identifier"], expected)
        elif told_by_us(scorer, row["response"]) != expected:
            others = itertools.islice(drawn(row["response"]), 2_000)
            assert any(told_by_us(scorer, other) == expected for other in others), row["identifier"]


def test_strict_finds_at_least_what_the_reference_finds(
    behavior_tasks: BehaviorTasks, oracle: Oracle
) -> None:
    """Whatever ends well there ends well here, in the data set's own subgoals."""
    rows = oracle("behavior", "subgoal_decomposition", "gt")["records"]
    make = behavior_subgoals()
    for row in rows:
        if row["verdict"]["task_success"]:
            verdict = make(behavior_tasks[row["identifier"]]).score(row["response"])
            assert verdict.success, row["identifier"]
