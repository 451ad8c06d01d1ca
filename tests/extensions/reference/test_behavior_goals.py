"""Counts under `eai-1.0.5` against those of the reference, row by row."""

from __future__ import annotations

from collections import Counter

import pytest

from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.verdict import ConfusionCounts
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.extensions.reference.behavior_goals import BehaviorGoalInterpretationScorer
from oracle import MODELS, Oracle, read_shared

SETS = (*MODELS, "gt_lastoption", "gt_option0", "perturb0", "perturb1")


def told_by_reference(part: dict[str, int]) -> ConfusionCounts:
    return ConfusionCounts(
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
        verdict = BehaviorGoalInterpretationScorer(task).score(row["response"])
        parts = {"all": "overall", "state": "state_goal", "relation": "relation_goal"}
        expected = {key: told_by_reference(row["verdict"][part]) for key, part in parts.items()}
        counts = {key: (verdict.counts or {})[key] for key in expected}
        assert (row["identifier"], counts) == (row["identifier"], expected)
        assert isinstance(verdict, GoalVerdict)
        errors["format_error_num"] += verdict.ill_formed
        errors["state_hallucination_num"] += len(verdict.unknown_predicates)
        errors["object_hallucination_num"] += len(verdict.hallucinated)
    assert {key: content["summary"]["grammatical_errors"][key] for key in errors} == errors


PRINTED = {
    "claude-3-opus-20240229": "Claude-3 Opus",
    "cohere-command-r": "Cohere Command R",
    "gemini-1.5-pro-preview-0409": "Gemini 1.5 Pro",
    "gpt-3.5-turbo-0125": "GPT-3.5-turbo",
    "gpt-4o-2024-05-13": "GPT-4o",
    "llama-3-8b-chat": "Llama 3 8B",
    "mixtral-8x22b-instruct-v0.1": "Mixtral 8x22B MoE",
}
"""The models of the authors' own analysis by predicate whose answers are there."""


@pytest.mark.parametrize("name", PRINTED)
def test_the_atoms_by_predicate_are_those_of_the_authors(
    behavior_tasks: BehaviorTasks, oracle: Oracle, name: str
) -> None:
    expected = read_shared("paper", "goal_interpretation_behavior_by_predicate.json")["rows"][PRINTED[name]]
    found = [Counter[str](), Counter[str](), Counter[str]()]
    for row in oracle("behavior", "goal_interpretation", name)["records"]:
        verdict = BehaviorGoalInterpretationScorer(behavior_tasks[row["identifier"]]).score(row["response"])
        assert isinstance(verdict, GoalVerdict)
        for counter, atoms in zip(found, (verdict.matched, verdict.wrong, verdict.missing), strict=True):
            counter.update([atom.removeprefix("not ").partition("(")[0] for atom in atoms])
    assert {predicate: [counter[predicate] for counter in found] for predicate in expected} == expected
