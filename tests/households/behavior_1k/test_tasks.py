from __future__ import annotations

import pytest

from eai.abilities.goal_test import GoalTest
from eai.abilities.protocol import FOUR, Ability
from eai.abilities.task import Task
from eai.benchmark.prompt_library import Library
from eai.data.store import Store
from eai.households.behavior_1k.benchmark import behavior_1k, challenge_2025, untold
from eai.households.behavior_1k.conventions import HEADING
from eai.households.behavior_1k.operators import declared
from eai.households.behavior_1k.pack import NAME
from eai.households.behavior_1k.tasks import Evidence
from eai.prompts.prompt import PromptSet
from eai.tasks.source import Source, TaskSet
from eai.world.conformance import check
from eai.world.domain import Domain
from eai.world.execution import execute
from sweeps import every

NUMBER, PLANNED = 1016, 960


@pytest.fixture(scope="module")
def domain() -> Domain:
    return declared()


def test_all_definitions_are_read_and_the_store_is_small(
    activities: TaskSet[Task], activity_store: Store
) -> None:
    assert len(activities) == NUMBER
    assert activity_store.path(NAME).stat().st_size < 250_000


@every(20)
def test_gold_plans_reach_the_goals(activities: TaskSet[Task], domain: Domain, every: int) -> None:
    for task_id in list(activities)[::every]:
        task = activities[task_id]
        if task.unsolvable is None:
            trajectory = execute(domain, task.initial, task.script)
            taken = [action.operator for action in task.script]
            assert trajectory.failure is None, task_id
            assert all(GoalTest(task).reached(trajectory.final, taken, trajectory.states)), task_id


@every(20)
def test_no_step_of_a_gold_plan_is_needless(activities: TaskSet[Task], domain: Domain, every: int) -> None:
    for task_id in list(activities)[::every]:
        task = activities[task_id]
        for left_out in range(len(task.script)):
            fewer = (*task.script[:left_out], *task.script[left_out + 1 :])
            trajectory = execute(domain, task.initial, fewer)
            taken = [action.operator for action in fewer]
            reached = GoalTest(task).reached(trajectory.final, taken, trajectory.states)
            assert trajectory.failure is not None or not all(reached), (task_id, left_out)


def test_an_activity_has_a_plan_or_is_left_out_with_a_reason(activities: TaskSet[Task]) -> None:
    planned = {task_id for task_id, task in activities.items() if task.script}
    left_out = Evidence.load().left_out
    assert len(planned) == PLANNED
    assert planned.isdisjoint(left_out)
    assert planned | set(left_out) == set(activities)


@every(50)
def test_a_goal_does_not_hold_at_the_start(activities: TaskSet[Task], every: int) -> None:
    for task_id in list(activities)[::every]:
        task = activities[task_id]
        holds = all(GoalTest(task).reached(task.initial, [], [task.initial]))
        assert holds == (task_id == "clean_a_stainless_steel_dishwasher")


def test_the_challenge_has_a_plan_for_each_of_its_activities(activity_store: Store) -> None:
    tasks = challenge_2025().tasks(Source(store=activity_store))
    assert len(tasks) == 50
    assert next(iter(tasks)) == "turning_on_radio"
    assert all(task.script and task.unsolvable is None for task in tasks.values())


def test_prompts_of_plans_tell_the_conventions_unless_they_are_asked(activity_store: Store) -> None:
    library, task_id = Library(PromptSet.EAI, source=Source(store=activity_store)), "clean_a_patio"
    told, silent = (
        {ability: library.open(each, ability)[task_id].user for ability in FOUR[:3]}
        for each in (behavior_1k(), untold())
    )
    for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION):
        assert "mud_1 is removed by wiping with broom_1" in told[ability]
        assert HEADING not in silent[ability]
    assert told[Ability.GOAL_INTERPRETATION] == silent[Ability.GOAL_INTERPRETATION]


def test_the_declaration_conforms(activities: TaskSet[Task], domain: Domain) -> None:
    names = ("cook_cabbage", "make_pizza", "cleaning_up_plates_and_food", "washing_vegetables")
    assert check(domain, [activities[name].initial for name in names]) == ()
