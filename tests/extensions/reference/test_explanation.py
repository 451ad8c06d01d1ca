from __future__ import annotations

import pytest

from abilities.test_explanation import (
    Explain,
    test_a_step_report_lists_changes_of_the_tasks_objects,
    test_an_explanation_reports_every_goal,
)
from benchmarks.plan_scorers import virtualhome_scorer
from benchmarks.virtualhome.household import make_task
from eai.abilities.explanation import VerdictExplanation
from eai.extensions.reference.virtualhome_plans import VirtualHomeActionSequencingScorer
from eai.tasks.task import Task

SHARED = (test_a_step_report_lists_changes_of_the_tasks_objects, test_an_explanation_reports_every_goal)
"""Tests of `strict` that are run again with the fixture `explained` below."""


def explain_as_reference(text: str, task: Task) -> VerdictExplanation:
    return VirtualHomeActionSequencingScorer(task).explain(text)


@pytest.fixture
def explained() -> Explain:
    return explain_as_reference


def test_a_plan_that_the_reference_counts_as_failed_is_executed_all_the_same() -> None:
    explanation = explain_as_reference('{"WALK": ["fridge"]}', make_task(script=["WALK fridge.10"]))
    assert explanation.notes == (
        "the plan equals the data set's script, which the reference counts as a failure",
    )
    assert [step.outcome for step in explanation.steps] == ["executed"]


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        (
            '{"STANDUP": [], "WALK": ["fridge"], "OPEN": ["fridge"]}',
            ("lossy_reading: not seen: step 1, STANDUP()", "strict, which passes over nothing: success"),
        ),
        (
            '{"WALK": ["fridge"], "OPEN": []}',
            (
                "lossy_reading: not seen: step 2, OPEN()",
                "strict, which passes over nothing: argument_number at step 2, OPEN takes 1 object, not 0",
            ),
        ),
        (
            '<think>{"WALK": ["bed"]}</think>{"WALK": ["fridge"]}',
            (
                "lossy_reading: seen, but no step of the plan: WALK(bed)",
                "strict, which passes over nothing: goal_missed",
            ),
        ),
        ('{"WALK": ["fridge"]}', ()),
        ("I cannot.", ("parsing: no step was found",)),
    ],
)
def test_what_the_reference_does_not_see_is_told_beside_the_verdict_of_strict(
    text: str, notes: tuple[str, ...]
) -> None:
    assert explain_as_reference(text, make_task()).notes == notes
    assert not any("lossy" in note for note in virtualhome_scorer(make_task()).explain(text).notes)
