"""Verdicts under `eai-1.0.5` against those of the reference, row by row; the data set's own plans."""

from __future__ import annotations

import json
from typing import Any

import pytest

from benchmarks.plan_scorers import behavior_scorer
from eai.abilities.notation.plans import JsonPlanNotation
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.extensions.reference.behavior_plans import BehaviorActionSequencingScorer
from oracle import MODELS, Oracle, read_shared

SETS = (*MODELS, "gt", "perturb")

KINDS = {
    "arguments": "argument_number",
    "affordance_error": "affordance",
    "wrong_temporal_order": "wrong_order",
    "hullucination": "hallucination",
}
"""The reference's name of an error -> our name, if they differ."""

ACCEPTED_BY_STRICT_ONLY = {"putting_away_toys", "serving_hors_d_oeuvres", "sorting_mail"}


def told_by_reference(verdict: Any) -> dict[str, Any]:
    errors = sorted(KINDS.get(error, error) for error in verdict["errors"])
    steps = verdict.get("steps")
    return {
        "executable": verdict["execution_success"],
        "success": verdict["task_success"],
        "errors": ["uncategorised"] if verdict["uncategorised_failure"] else errors,
        "stopped_at": len(steps) - 1 if steps and not verdict["execution_success"] else None,
        "goals": verdict.get("goals"),
    }


def told_by_us(verdict: Verdict, reference: dict[str, Any]) -> dict[str, Any]:
    assert isinstance(verdict, PlanVerdict)
    error = verdict.error
    kinds = [] if error is None else [error.kind.value]
    if kinds != ["uncategorised"] and verdict.additional_steps:
        kinds.append("additional_step")
    in_steps = reference["stopped_at"] is not None
    return {
        "executable": verdict.executable,
        "success": verdict.success,
        "errors": sorted(kinds),
        "stopped_at": error.step if error is not None and in_steps else None,
        "goals": None if reference["goals"] is None else list(verdict.goals_satisfied),
    }


@pytest.mark.parametrize("name", SETS)
def test_every_row_has_the_references_verdict(
    behavior_tasks: BehaviorTasks, oracle: Oracle, name: str
) -> None:
    differing = []
    for row in oracle("behavior", "action_sequencing", name)["records"]:
        task = behavior_tasks[row["identifier"]]
        theirs = told_by_reference(row["verdict"])
        ours = told_by_us(BehaviorActionSequencingScorer(task).score(row["response"]), theirs)
        if ours != theirs:
            differing.append(task.title)
    assert differing == []


def test_the_simulator_met_the_same_goals_as_the_symbolic_state(behavior_tasks: BehaviorTasks) -> None:
    """The authors' own log of iGibson: twenty plans of Claude-3 Haiku, goal by goal."""
    log = read_shared("oracle", "behavior", "igibson_run.claude-3-haiku-20240307.json.gz")
    met_by_physics = {
        row["identifier"]: (row["error_type"]["execution_success"], row["satisfication_info"]["satisfied"])
        for row in log
    }
    verdicts = {
        row["identifier"]: BehaviorActionSequencingScorer(behavior_tasks[row["identifier"]]).score(
            json.dumps(row["parsed_actions"])
        )
        for row in log
    }
    assert len(met_by_physics) == 20
    assert {
        task_id: (v.executable, [number for number, met in enumerate(v.goals_satisfied) if met])
        for task_id, v in verdicts.items()
        if isinstance(v, PlanVerdict)
    } == met_by_physics
    assert sum(bool(met) for _, met in met_by_physics.values()) >= 10


def test_the_data_sets_plans(behavior_tasks: BehaviorTasks) -> None:
    notation = JsonPlanNotation()
    strict, reference = (
        {
            task.title
            for task in behavior_tasks.values()
            if scorer_of(task).score(notation.join(notation.write(task.script, task.scene))).success
        }
        for scorer_of in (behavior_scorer, BehaviorActionSequencingScorer)
    )
    assert len(reference) == 88
    assert strict - reference == ACCEPTED_BY_STRICT_ONLY
    assert reference <= strict
