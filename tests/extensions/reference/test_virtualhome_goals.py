"""Verdicts under `eai-1.0.5` against those of the reference, row by row."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.verdict import Verdict
from eai.benchmarks.virtualhome import domain
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.extensions.reference.virtualhome_goals import VirtualHomeGoalInterpretationScorer
from oracle import MODELS, Oracle

DOMAIN = domain.make_domain_with_checks_in_paper_order()
SETS = (*MODELS, "gold", "perturbed")


def of_reference(row: Mapping[str, Any]) -> tuple[object, ...]:
    counts = tuple(tuple(row[kind]) for kind in ("node", "edge", "action"))
    return (*counts, row["format_wrong"], row["hallucination"], row["total"])


def of_ours(verdict: Verdict) -> tuple[object, ...]:
    assert verdict.counts is not None
    assert isinstance(verdict, GoalVerdict)
    counts = tuple(tuple(verdict.counts[kind]) for kind in ("state", "relation", "action"))
    format_wrong = verdict.ill_formed + (verdict.error is not None)
    hallucinated = len(verdict.hallucinated)
    return (*counts, format_wrong, hallucinated, verdict.predicted - hallucinated)


@pytest.mark.parametrize("name", SETS)
def test_every_row_has_the_counts_of_the_reference(
    name: str, oracle: Oracle, virtualhome_tasks: VirtualHomeTasks
) -> None:
    rows = oracle("virtualhome", "goal_interpretation", name)["tasks"]
    differing, compared = {}, 0
    for row in rows:
        task = virtualhome_tasks[row["id"].partition("@")[0]]
        verdict = VirtualHomeGoalInterpretationScorer(task, DOMAIN).score(row["llm_output"])
        assert isinstance(verdict, GoalVerdict)
        assert bool(row["exception"]) == verdict.aborts
        if not row["exception"]:
            compared += 1
            if of_reference(row) != of_ours(verdict):
                differing[row["id"]] = (of_reference(row), of_ours(verdict))
    assert differing == {}
    assert compared >= 114
