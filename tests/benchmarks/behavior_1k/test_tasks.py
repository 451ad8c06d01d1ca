from __future__ import annotations

import pytest

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import STANDARD
from eai.base.store import DataPackStore
from eai.benchmarks.behavior.benchmark import behavior
from eai.benchmarks.behavior_1k.benchmark import (
    behavior_1k,
    behavior_1k_challenge_2025,
    behavior_1k_in_behavior_100,
    behavior_1k_untold,
)
from eai.benchmarks.behavior_1k.conventions import HEADING
from eai.benchmarks.behavior_1k.kinds import PACK
from eai.benchmarks.behavior_1k.operators import build_domain
from eai.benchmarks.behavior_1k.tasks import load_exclusion_reasons
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import open_suite
from eai.logic import formula as f
from eai.logic.formula import Atom
from eai.logic.traversal import walk_subformulas
from eai.pddl.planning import PlannerOutcome
from eai.pddl.writer import write_formula
from eai.planning.planner import Planner
from eai.planning.search import Limits, SearchEndReason
from eai.tasks.goal_test import GoalTest
from eai.tasks.planning import find_plan
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Task
from eai.world.conformance import check_domain
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from sweeps import every

NUMBER, PLANNED = 1016, 960
CHARACTERS_A_TOKEN = 3.5


@pytest.fixture(scope="module")
def domain() -> Domain:
    return build_domain()


def test_all_definitions_are_read_and_the_store_is_small(
    activities: TaskSet[Task], activity_store: DataPackStore
) -> None:
    assert len(activities) == NUMBER
    assert activity_store.get_pack_path(PACK).stat().st_size < 250_000


@every(20)
def test_gold_plans_reach_the_goals(activities: TaskSet[Task], domain: Domain, every: int) -> None:
    for task_id in list(activities)[::every]:
        task = activities[task_id]
        if task.unsolvable is None:
            trajectory = execute_plan(domain, task.initial, task.script)
            taken = [action.operator for action in task.script]
            assert trajectory.failure is None, task_id
            assert all(GoalTest(task).evaluate_each_goal(trajectory.final_state, taken, trajectory.states)), (
                task_id
            )


@every(20)
def test_no_step_of_a_gold_plan_can_be_left_out(
    activities: TaskSet[Task], domain: Domain, every: int
) -> None:
    for task_id in list(activities)[::every]:
        task = activities[task_id]
        for number in range(len(task.script)):
            fewer = (*task.script[:number], *task.script[number + 1 :])
            trajectory = execute_plan(domain, task.initial, fewer)
            taken = [action.operator for action in fewer]
            reached = GoalTest(task).evaluate_each_goal(trajectory.final_state, taken, trajectory.states)
            assert trajectory.failure is not None or not all(reached), (task_id, number)


@every(10)
def test_no_gold_plan_wipes_with_a_dirty_tool(activities: TaskSet[Task], domain: Domain, every: int) -> None:
    wiping = [name for name in activities if "WIPE" in {a.operator for a in activities[name].script}]
    for task_id in dict.fromkeys(["clean_synthetic_hiking_gear", *wiping[::every]]):
        task = activities[task_id]
        states = execute_plan(domain, task.initial, task.script).states
        for state, action in zip(states, task.script, strict=False):
            if action.operator == "WIPE":
                tool = action.arguments[1]
                assert not state.relation("has_cover").row(tool), task_id
                assert not task.initial.relation("has_cover").row(tool), task_id


def test_each_activity_has_a_plan_or_a_reason_for_its_exclusion(activities: TaskSet[Task]) -> None:
    planned = {task_id for task_id, task in activities.items() if task.script}
    reasons = load_exclusion_reasons()
    assert len(planned) == PLANNED
    assert planned.isdisjoint(reasons)
    assert planned | set(reasons) == set(activities)


def test_the_goal_of_stacking_wood_contradicts_itself(activities: TaskSet[Task]) -> None:
    task = activities["stacking_wood"]
    every_log, on_the_table, on_a_log = (goal.formula for goal in task.goals)
    assert isinstance(every_log, f.ForAll)
    assert isinstance(on_the_table, f.Exactly)
    assert isinstance(on_a_log, f.Exactly)
    assert isinstance(every_log.body, f.Or)
    assert every_log.body.operands == (on_the_table.body, on_a_log.body)
    logs = len(task.scene.names(task.scene.get_category_mask("log")))
    assert on_the_table.count + on_a_log.count < logs
    assert "contradicts itself" in load_exclusion_reasons()["stacking_wood"]


@every(50)
def test_goals_do_not_hold_initially_except_in_one_activity(activities: TaskSet[Task], every: int) -> None:
    for task_id in list(activities)[::every]:
        task = activities[task_id]
        holds = all(GoalTest(task).evaluate_each_goal(task.initial, [], [task.initial]))
        assert holds == (task_id == "clean_a_stainless_steel_dishwasher")


def test_each_activity_of_the_challenge_has_a_plan(activity_store: DataPackStore) -> None:
    tasks = behavior_1k_challenge_2025().tasks(Source(store=activity_store))
    assert len(tasks) == 50
    assert next(iter(tasks)) == "turning_on_radio"
    assert all(task.script and task.unsolvable is None for task in tasks.values())


def test_the_subset_of_behavior_100_has_the_activities_of_equal_names(activity_store: DataPackStore) -> None:
    source = Source(store=activity_store)
    of_100 = {task_id.partition("_0_")[0] for task_id in behavior().tasks(source)}
    assert list(behavior_1k_in_behavior_100().tasks(source)) == [
        name for name in behavior_1k().tasks(source) if name in of_100
    ]


def test_the_planner_uses_a_washer_for_dirty_objects(activities: TaskSet[Task], domain: Domain) -> None:
    search = find_plan(activities["wash_dog_toys"], Planner(domain), Limits(100))
    assert search.end is SearchEndReason.SOLVED
    assert "WASH" in {action.operator for action in search.plan}


def test_the_planner_follows_recipes_which_answers_cannot_name(
    activities: TaskSet[Task], domain: Domain
) -> None:
    task = activities["make_coffee"]
    assert {task.scene.objects[i].category for i in task.unnamed} == {"recipe"}
    assert set(task.relevant).isdisjoint(task.unnamed)
    plan = find_plan(task, Planner(domain), Limits(60, looks=10_000)).plan
    assert "RUN" in [action.operator for action in plan]


def test_the_planner_collects_the_ingredients_of_a_recipe_one_by_one(
    activities: TaskSet[Task], domain: Domain
) -> None:
    task = activities["make_mustard_herb_and_spice_seasoning"]
    search = find_plan(task, Planner(domain), Limits(100, looks=20_000))
    assert [action.operator for action in search.plan].count("POUR") == 6
    assert len(search.plan) == len(task.script)


def test_an_object_without_a_known_floor_is_visible_from_everywhere(activities: TaskSet[Task]) -> None:
    task = activities["clean_the_exterior_of_your_garage"]
    door, stain = (task.scene.index[name] for name in ("door_1", "stain_1"))
    assert not task.initial.relation("by_floor").row(door)
    assert stain in Game(make_setup(task, behavior_1k(), STANDARD)).memory.known


def test_prompts_for_plans_list_conventions_unless_the_benchmark_tests_them(
    activity_store: DataPackStore,
) -> None:
    library, task_id = PromptLibrary("eai", source=Source(store=activity_store)), "clean_a_patio"
    explained, silent = (
        {ability: library.open(benchmark, ability)[task_id].user for ability in PAPER_ABILITIES[:3]}
        for benchmark in (behavior_1k(), behavior_1k_untold())
    )
    for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION):
        assert "mud_1 is removed by wiping with broom_1" in explained[ability]
        assert HEADING not in silent[ability]
    assert explained[Ability.GOAL_INTERPRETATION] == silent[Ability.GOAL_INTERPRETATION]


@pytest.mark.parametrize("task_id", ["clean_clams", "cook_hot_dogs", "make_a_cappuccino"])
def test_planning_problems_contain_the_rules_that_gold_operators_need(
    activity_store: DataPackStore, task_id: str
) -> None:
    suite = open_suite(behavior_1k(), Ability.TRANSITION_MODELING, source=Source(store=activity_store))
    gold = open_gold_answers(behavior_1k(), Ability.TRANSITION_MODELING, source=Source(store=activity_store))
    verdict = suite.score(task_id, gold[task_id].text)
    assert isinstance(verdict, OperatorVerdict)
    assert verdict.planner is PlannerOutcome.SOLVED
    assert verdict.success


def test_prompts_of_transition_modeling_show_the_facts_of_their_operators_and_little_more(
    activity_store: DataPackStore,
) -> None:
    source = Source(store=activity_store)
    operators = behavior_1k().operator_tasks(source)
    prompts = PromptLibrary("eai", source=source).open(behavior_1k(), Ability.TRANSITION_MODELING)
    for task_id in list(operators)[::40]:
        shown, _, question = prompts[task_id].user.partition("An example of another task")
        task = operators[task_id]
        facts = question.partition("Your task")[2]
        read = {
            formula.predicate
            for operator in task.gold_operators.values()
            for formula in walk_subformulas(operator.precondition)
            if isinstance(formula, Atom)
        }
        assert all(f"({name}" in shown for name in read), task_id
        assert all(write_formula(fact) in facts for fact in task.problem.initial if fact.predicate in read), (
            task_id
        )
    lengths = sorted(len(prompt.user) for prompt in prompts.values())
    assert lengths[int(0.95 * len(lengths))] < 6_000 * CHARACTERS_A_TOKEN
    assert "removes_soaked" not in prompts["putting_shoes_on_rack"].user


def test_the_domain_conforms_to_its_declarations(activities: TaskSet[Task], domain: Domain) -> None:
    names = ("cook_cabbage", "make_pizza", "cleaning_up_plates_and_food", "washing_vegetables")
    assert check_domain(domain, [activities[name].initial for name in names]) == ()
