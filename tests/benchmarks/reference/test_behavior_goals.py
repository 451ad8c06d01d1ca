"""Counts under `eai-1.0.5` against those of the reference, row by row."""

from __future__ import annotations

import pytest

from eai.abilities.verdict import Confusion, GoalVerdict
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.benchmarks.reference.behavior_goals import ByFirstOption
from oracle import MODELS, Oracle

SETS = (*MODELS, "gt_lastoption", "gt_option0", "perturb0", "perturb1")


def told_by_reference(part: dict[str, int]) -> Confusion:
    return Confusion(
        part["num_satisfied_conditions"],
        part["num_false_positive_conditions"],
        part["num_unsatisfied_conditions"],
    )


@pytest.mark.parametrize("name", SETS)
def test_every_row_has_the_references_counts(
    behavior_tasks: BehaviorTasks, oracle: Oracle, name: str
) -> None:
    content = oracle("behavior", "goal_interpretation", name)
    errors = {"format_error_num": 0, "state_hallucination_num": 0, "object_hallucination_num": 0}
    for row in content["records"]:
        task = behavior_tasks[row["identifier"]]
        verdict = ByFirstOption(task).score(row["response"])
        parts = {"all": "overall", "state": "state_goal", "relation": "relation_goal"}
        expected = {key: told_by_reference(row["verdict"][part]) for key, part in parts.items()}
        counts = {key: (verdict.counts or {})[key] for key in expected}
        assert (row["identifier"], counts) == (row["identifier"], expected)
        assert isinstance(verdict, GoalVerdict)
        errors["format_error_num"] += verdict.ill_formed
        errors["state_hallucination_num"] += len(verdict.unknown_predicates)
        errors["object_hallucination_num"] += len(verdict.hallucinated)
    assert {key: content["summary"]["grammatical_errors"][key] for key in errors} == errors
