"""Smallest repairs of models' answers: they name the failure, work when executed, and keep to the effort."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from functools import cache
from random import Random

import pytest

import eai
from eai.abilities import plan_repairer
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.repair import DEFAULT_EFFORT, SmallestPlanRepair
from eai.abilities.verdict import PlanVerdict, Unreadable
from eai.base.store import DataPackStore
from eai.planning.repair import search as repair_search
from eai.planning.repair.edits import PlanEdit, PlanSteps
from eai.tasks.goal_test import GoalTest
from eai.tasks.planning import to_planning_goal
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.execution import execute_plan
from made_answers import made_answers
from oracle import MODELS, Oracle
from suites import answer_book
from sweeps import sweep, swept

SLACK = 200
"""By how much the last thing that is done may exceed the effort that is allowed."""


def repair_of(scorer: ActionSequencingScorer, text: str) -> tuple[PlanVerdict, SmallestPlanRepair]:
    look_back = scorer.assess(text).analyze_failure
    assert look_back is not None
    verdict = look_back(DEFAULT_EFFORT)
    assert isinstance(verdict, PlanVerdict)
    assert verdict.repair is not None
    return verdict, verdict.repair


def apply_edits(steps: PlanSteps, repair: SmallestPlanRepair, task: Task) -> list[Action | None]:
    """Return a plan after the edits of a repair, read from their texts."""
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


def succeeds(scorer: ActionSequencingScorer, plan: list[Action | None]) -> bool:
    steps = [step for step in plan if step is not None]
    course = execute_plan(scorer.domain, scorer.task.initial, steps)
    taken = [action.operator for action in course.executed_actions]
    reached = GoalTest(scorer.task).evaluate_each_goal(course.final_state, taken, course)
    return len(steps) == len(plan) and course.failure is None and all(reached)


@pytest.mark.parametrize(("name", "every"), swept(("virtualhome", 31), ("behavior", 29)))
def test_published_answers_have_distance_zero_exactly_if_they_succeed(
    name: str, every: int, data_store: DataPackStore, oracle: Oracle
) -> None:
    files = [oracle(name, "action_sequencing", model) for model in MODELS]
    rows = [row for file in files for row in file.get("tasks") or file["records"]]
    check_repairs(
        name,
        data_store,
        [
            (row.get("id", row.get("identifier")), row.get("llm_output", row.get("response")) or "")
            for row in rows[::every]
        ],
    )


@pytest.mark.parametrize(
    ("name", "every"), [("virtualhome", 57), ("behavior", 15), *swept(("virtualhome", 3), ("behavior", 2))]
)
def test_answers_have_distance_zero_exactly_if_they_succeed(
    name: str, every: int, data_store: DataPackStore
) -> None:
    check_repairs(name, data_store, made_answers(name, Ability.ACTION_SEQUENCING, data_store)[::every])


def check_repairs(name: str, store: DataPackStore, answers: Sequence[tuple[str, str]]) -> None:
    """Check the smallest repairs of answers to tasks."""
    suite = eai.open(name, "action_sequencing", source=Source(store))
    seen = set()
    for task_id, text in answers:
        scorer = suite.scorer(task_id)
        if not isinstance(scorer, ActionSequencingScorer) or scorer.excluded is not None:
            continue
        verdict, repair = repair_of(scorer, text)
        assert (repair.distance == 0) == bool(verdict.success)
        assert repair.effort <= DEFAULT_EFFORT + SLACK
        seen.add(min(repair.at_least, 2))
        plan = scorer.notation.read(text)
        if repair.at_most:
            assert not isinstance(plan, Unreadable)
            assert len(repair.edits) == repair.at_most >= repair.at_least
            assert succeeds(scorer, apply_edits(scorer.repairer.read_steps(plan), repair, scorer.task))
    assert seen > {0}


def test_caches_of_plans_are_bounded_and_change_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    scorer = eai.open("virtualhome", "action_sequencing").scorer("27_2")
    assert isinstance(scorer, ActionSequencingScorer)
    text = '{"WALK": ["washing_machine", 1001]}'
    plan_repairer._get_cached_repairer.cache_clear()
    first = repair_of(scorer, text)
    assert repair_of(scorer, text) == first
    assert plan_repairer._get_cached_repairer.cache_info().currsize == 1
    assert plan_repairer._get_cached_repairer.cache_info().maxsize
    monkeypatch.setattr(repair_search, "_MAX_CACHED_STATES", 0)
    assert repair_of(scorer, text) == first


def test_the_reported_edit_is_about_the_objects_of_the_failed_step() -> None:
    """The food lies in the freezer, so walking to either would do. The failed step grabs the food."""
    scorer = eai.open("virtualhome", "action_sequencing").scorer("152_2")
    assert isinstance(scorer, ActionSequencingScorer)
    text = """{"WALK": ["dining_room", 201], "GRAB": ["food_food", 1000], "WALK": ["freezer", 289],
               "OPEN": ["freezer", 289], "PUTIN": ["food_food", 1000, "freezer", 289]}"""
    _, repair = repair_of(scorer, text)
    assert [edit.text for edit in repair.edits] == ["insert WALK(food_food.1000) before step 2"]


@cache
def good_plans(name: str) -> list[tuple[ActionSequencingScorer, tuple[Action, ...]]]:
    """Return successful plans, each with the scorer of its task."""
    suite, book = eai.open(name, "action_sequencing"), answer_book(name, Ability.ACTION_SEQUENCING)
    found = []
    for task_id in suite.task_ids:
        scorer, gold = suite.scorer(task_id), book[task_id]
        text = gold.join(gold.parts)
        if isinstance(scorer, ActionSequencingScorer) and getattr(scorer.score(text), "success", None):
            plan = scorer.notation.read(text)
            assert not isinstance(plan, Unreadable)
            steps = [step for step in scorer.repairer.read_steps(plan) if step is not None]
            found.append((scorer, tuple(steps)))
    return found


Fault = tuple[list[Action], PlanEdit]
"""A plan with a fault, and the edit that undoes it."""


def plant_fault(task: Task, plan: Sequence[Action], kind: str, random: Random) -> Fault:
    """Return a plan with a planted fault: a dropped step, another object, or an additional step.

    The edit that undoes the fault is returned with the plan.
    """
    steps, at = [*plan], random.randrange(len(plan))
    was = steps[at]
    if kind == "drop":
        del steps[at]
        return steps, PlanEdit(at, None, was)
    if kind == "extra":
        steps.insert(at, random.choice(plan))
        return steps, PlanEdit(at, at, None)
    others = [index for step in plan for index in step.arguments if index not in was.arguments]
    if others and was.arguments:
        steps[at] = Action(was.operator, (random.choice(others), *was.arguments[1:]))
    return steps, PlanEdit(at, at, was)


def is_idle(scorer: ActionSequencingScorer, action: Action) -> bool:
    """Whether no repair needs an action, since it changes nothing and is no goal."""
    operator = scorer.domain.compiled_operators[action.operator].operator
    asked = {name for names in to_planning_goal(scorer.task).actions for name in names}
    return not (operator.effects or operator.alternatives or operator.name in asked)


@pytest.mark.parametrize("kind", ["drop", "object", "extra"])
@pytest.mark.parametrize(
    ("name", "number"), [("virtualhome", 8), *swept(("virtualhome", 200), ("behavior", 20))]
)
def test_the_single_edits_include_the_one_that_undoes_a_planted_fault(
    name: str, number: int, kind: str
) -> None:
    """A plan with one planted fault has a distance of at most one."""
    random, harmful = Random(11), 0
    notation = eai.open(name, "action_sequencing").benchmark.notation.plans
    for scorer, plan in random.sample(good_plans(name), number):
        faulty, undoing = plant_fault(scorer.task, plan, kind, random)
        text = notation.join(notation.write(faulty, scorer.task.scene)) if faulty else "[]"
        _, repair = repair_of(scorer, text)
        assert repair.at_least <= 1
        if repair.distance != 1 or (undoing.action and is_idle(scorer, undoing.action)):
            continue
        harmful += 1
        singles = {*scorer.repairer._make_repairer(faulty).find_single_edit_repairs(faulty)}
        assert singles & {undoing, undoing._replace(action=None)}, "a step that was skipped may as well go"
        assert repair.blame != "step" or repair.blamed == undoing.step
    assert harmful


TOLD_OF_SOME = """
import sys
import eai
from eai.abilities.repair import DEFAULT_EFFORT
from suites import answer_book
for name, step in (("virtualhome", 60), ("behavior", 50)):
    suite, book = eai.open(name, "action_sequencing"), answer_book(name, eai.Ability.ACTION_SEQUENCING)
    told = []
    for task_id in list(suite.task_ids[::step])[:: int(sys.argv[1])]:
        gold = book[task_id]
        look_back = suite.scorer(task_id).assess(gold.join(gold.parts[1:])).analyze_failure
        told.append(f"{task_id} {look_back(DEFAULT_EFFORT).repair}")
    print(*sorted(told), sep="\\n")
"""


@sweep
def test_repairs_do_not_depend_on_order_or_hash_seed() -> None:
    printed = {
        subprocess.run(
            [sys.executable, "-c", TOLD_OF_SOME, step],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for seed, step in (("1", "1"), ("2", "-1"))
    }
    (told,) = printed
    assert told.count("Repair(") == 8
