"""Smallest repairs of models' answers: told where they fail, carried out as told, within their effort."""

from __future__ import annotations

import pytest

import eai
from eai.abilities.action_sequencing import mending
from eai.abilities.action_sequencing.scorer import ActionSequencing
from eai.abilities.goal_test import GoalTest
from eai.abilities.repair import EFFORT, Repair
from eai.abilities.task import Task
from eai.abilities.verdict import PlanVerdict, Unreadable
from eai.planning import repair as planning_repair
from eai.planning.repair import Plan
from eai.world.execution import Action, execute
from oracle import MODELS, Oracle
from sweeps import swept

SLACK = 200
"""By how much the last thing that is done may exceed the effort that is allowed."""


def repair_of(scorer: ActionSequencing, text: str) -> tuple[PlanVerdict, Repair]:
    look_back = scorer.assess(text).look_back
    assert look_back is not None
    verdict = look_back(EFFORT)
    assert isinstance(verdict, PlanVerdict)
    assert verdict.repair is not None
    return verdict, verdict.repair


def as_told(steps: Plan, repair: Repair, task: Task) -> list[Action | None]:
    """A plan with the edits of a repair made, read from their texts."""
    plan: list[Action | None] = []
    for i, step in enumerate((*steps, None)):
        edits = [edit for edit in repair.edits if edit.step == i]
        plan += [action_of(edit.action, task) for edit in edits if edit.kind == "insert"]
        others = [edit for edit in edits if edit.kind != "insert"]
        plan += [action_of(edit.action, task) for edit in others if edit.action]
        plan += [step] * (i < len(steps) and not others)
    return plan


def action_of(text: str, task: Task) -> Action:
    operator, _, names = text.removesuffix(")").partition("(")
    return Action(operator, tuple(task.scene.index[name] for name in names.split(", ") if name))


def succeeds(scorer: ActionSequencing, plan: list[Action | None]) -> bool:
    steps = [step for step in plan if step is not None]
    course = execute(scorer.domain, scorer.task.initial, steps)
    taken = [action.operator for action in course.executed]
    reached = GoalTest(scorer.task).reached(course.final, taken, course)
    return len(steps) == len(plan) and course.failure is None and all(reached)


@pytest.mark.parametrize(
    ("name", "every"),
    [("virtualhome", 307), ("behavior", 151), *swept(("virtualhome", 31), ("behavior", 29))],
)
def test_answers_are_at_no_distance_just_if_they_succeed_and_repairs_do(
    name: str, every: int, oracle: Oracle
) -> None:
    suite = eai.open(name, "action_sequencing")
    files = [oracle(name, "action_sequencing", model) for model in MODELS]
    rows = [row for file in files for row in file.get("tasks") or file["records"]]
    seen = set()
    for row in rows[::every]:
        scorer = suite.scorer(row.get("id", row.get("identifier")))
        text = row.get("llm_output", row.get("response")) or ""
        if not isinstance(scorer, ActionSequencing) or scorer.excluded is not None:
            continue
        verdict, repair = repair_of(scorer, text)
        assert (repair.distance == 0) == bool(verdict.success)
        assert repair.effort <= EFFORT + SLACK
        seen.add(min(repair.at_least, 2))
        plan = scorer.notation.read(text)
        if repair.at_most:
            assert not isinstance(plan, Unreadable)
            assert len(repair.edits) == repair.at_most >= repair.at_least
            assert succeeds(scorer, as_told(scorer.mender.steps(plan), repair, scorer.task))
    assert seen >= {0, 1}


def test_what_is_kept_of_plans_is_bounded_and_makes_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    scorer = eai.open("virtualhome", "action_sequencing").scorer("27_2")
    assert isinstance(scorer, ActionSequencing)
    text = '{"WALK": ["washing_machine", 1001]}'
    mending._mender_of.cache_clear()
    first = repair_of(scorer, text)
    assert repair_of(scorer, text) == first
    assert mending._mender_of.cache_info().currsize == 1
    assert mending._mender_of.cache_info().maxsize
    monkeypatch.setattr(planning_repair, "_KEPT", 0)
    assert repair_of(scorer, text) == first
