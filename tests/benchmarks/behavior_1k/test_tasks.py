from __future__ import annotations

import pytest

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.agents.game import Game
from eai.agents.reference import staged
from eai.agents.rules import STANDARD
from eai.base.store import Store
from eai.benchmarks.behavior.benchmark import behavior
from eai.benchmarks.behavior_1k.benchmark import behavior_1k, challenge_2025, of_behavior_100, untold
from eai.benchmarks.behavior_1k.conventions import HEADING
from eai.benchmarks.behavior_1k.kinds import PACK
from eai.benchmarks.behavior_1k.operators import declared
from eai.benchmarks.behavior_1k.tasks import load_exclusions
from eai.benchmarks.gold_answers import open_answer_book
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.suite import open_suite
from eai.logic import formula as f
from eai.logic.formula import Atom
from eai.logic.traversal import walk
from eai.pddl.planning import PlannerOutcome
from eai.pddl.writer import write_formula
from eai.planning.planner import Planner
from eai.planning.search import Limits, SearchEnd
from eai.tasks.goal_test import GoalTest
from eai.tasks.planning import find_plan
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Task
from eai.world.conformance import check
from eai.world.domain import Domain
from eai.world.execution import execute
from sweeps import every

NUMBER, PLANNED = 1016, 960
CHARACTERS_A_TOKEN = 3.5


@pytest.fixture(scope="module")
def domain() -> Domain:
    return declared()


def test_all_definitions_are_read_and_the_store_is_small(
    activities: TaskSet[Task], activity_store: Store
) -> None:
    assert len(activities) == NUMBER
    assert activity_store.path(PACK).stat().st_size < 250_000


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
        for number in range(len(task.script)):
            fewer = (*task.script[:number], *task.script[number + 1 :])
            trajectory = execute(domain, task.initial, fewer)
            taken = [action.operator for action in fewer]
            reached = GoalTest(task).reached(trajectory.final, taken, trajectory.states)
            assert trajectory.failure is not None or not all(reached), (task_id, number)


@every(10)
def test_no_gold_plan_wipes_with_something_dirty(
    activities: TaskSet[Task], domain: Domain, every: int
) -> None:
    wiping = [each for each in activities if "WIPE" in {a.operator for a in activities[each].script}]
    for task_id in dict.fromkeys(["clean_synthetic_hiking_gear", *wiping[::every]]):
        task = activities[task_id]
        states = execute(domain, task.initial, task.script).states
        for state, action in zip(states, task.script, strict=False):
            if action.operator == "WIPE":
                tool = action.arguments[1]
                assert not state.relation("has_cover").row(tool), task_id
                assert not task.initial.relation("has_cover").row(tool), task_id


def test_an_activity_has_a_plan_or_is_left_out_with_a_reason(activities: TaskSet[Task]) -> None:
    planned = {task_id for task_id, task in activities.items() if task.script}
    reasons = load_exclusions()
    assert len(planned) == PLANNED
    assert planned.isdisjoint(reasons)
    assert planned | set(reasons) == set(activities)


def test_the_goal_of_stacking_wood_counts_four_of_six_logs(activities: TaskSet[Task]) -> None:
    task = activities["stacking_wood"]
    each, on_the_table, on_a_log = (goal.formula for goal in task.goals)
    assert isinstance(each, f.ForAll)
    assert isinstance(on_the_table, f.Exactly)
    assert isinstance(on_a_log, f.Exactly)
    assert isinstance(each.body, f.Or)
    assert each.body.operands == (on_the_table.body, on_a_log.body)
    logs = len(task.scene.names(task.scene.category("log")))
    assert on_the_table.count + on_a_log.count < logs
    assert "contradicts itself" in load_exclusions()["stacking_wood"]


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


def test_the_activities_of_behavior_100_are_those_of_the_same_name(activity_store: Store) -> None:
    source = Source(store=activity_store)
    of_100 = {task_id.partition("_0_")[0] for task_id in behavior().tasks(source)}
    assert list(of_behavior_100().tasks(source)) == [
        name for name in behavior_1k().tasks(source) if name in of_100
    ]


def test_the_planner_puts_into_a_washer_what_is_to_be_washed(
    activities: TaskSet[Task], domain: Domain
) -> None:
    found = find_plan(activities["wash_dog_toys"], Planner(domain), Limits(100))
    assert found.end is SearchEnd.SOLVED
    assert "WASH" in {action.operator for action in found.plan}


def test_the_planner_follows_a_recipe_which_no_answer_names(
    activities: TaskSet[Task], domain: Domain
) -> None:
    task = activities["make_coffee"]
    assert {task.scene.objects[i].category for i in task.unnamed} == {"recipe"}
    assert set(task.relevant).isdisjoint(task.unnamed)
    plan = find_plan(task, Planner(domain), Limits(60, looks=10_000)).plan
    assert "RUN" in [action.operator for action in plan]


def test_the_planner_brings_together_one_by_one_what_a_recipe_takes(
    activities: TaskSet[Task], domain: Domain
) -> None:
    task = activities["make_mustard_herb_and_spice_seasoning"]
    found = find_plan(task, Planner(domain), Limits(100, looks=20_000))
    assert [action.operator for action in found.plan].count("POUR") == 6
    assert len(found.plan) == len(task.script)


def test_what_is_on_no_known_floor_is_seen_from_anywhere(activities: TaskSet[Task]) -> None:
    task = activities["clean_the_exterior_of_your_garage"]
    door, stain = (task.scene.index[name] for name in ("door_1", "stain_1"))
    assert not task.initial.relation("by_floor").row(door)
    assert stain in Game(staged(task, behavior_1k(), STANDARD)).memory.known


def test_prompts_of_plans_tell_the_conventions_unless_they_are_asked(activity_store: Store) -> None:
    library, task_id = Library("eai", source=Source(store=activity_store)), "clean_a_patio"
    told, silent = (
        {ability: library.open(each, ability)[task_id].user for ability in PAPER_ABILITIES[:3]}
        for each in (behavior_1k(), untold())
    )
    for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION):
        assert "mud_1 is removed by wiping with broom_1" in told[ability]
        assert HEADING not in silent[ability]
    assert told[Ability.GOAL_INTERPRETATION] == silent[Ability.GOAL_INTERPRETATION]


@pytest.mark.parametrize("task_id", ["clean_clams", "cook_hot_dogs", "make_a_cappuccino"])
def test_problems_tell_the_rules_without_which_the_gold_operators_reach_no_goal(
    activity_store: Store, task_id: str
) -> None:
    suite = open_suite(behavior_1k(), Ability.TRANSITION_MODELING, source=Source(store=activity_store))
    gold = open_answer_book(behavior_1k(), Ability.TRANSITION_MODELING, source=Source(store=activity_store))
    verdict = suite.score(task_id, gold[task_id].text)
    assert isinstance(verdict, OperatorVerdict)
    assert verdict.planner is PlannerOutcome.SOLVED
    assert verdict.success


def test_prompts_of_transition_modeling_tell_what_their_operators_read_and_little_else(
    activity_store: Store,
) -> None:
    source = Source(store=activity_store)
    operators = behavior_1k().operators(source)
    prompts = Library("eai", source=source).open(behavior_1k(), Ability.TRANSITION_MODELING)
    for task_id in list(operators)[::40]:
        shown, _, asked = prompts[task_id].user.partition("An example of another task")
        task = operators[task_id]
        facts = asked.partition("Your task")[2]
        read = {
            part.predicate
            for each in task.gold.values()
            for part in walk(each.precondition)
            if isinstance(part, Atom)
        }
        assert all(f"({name}" in shown for name in read), task_id
        assert all(write_formula(fact) in facts for fact in task.problem.initial if fact.predicate in read), (
            task_id
        )
    lengths = sorted(len(prompt.user) for prompt in prompts.values())
    assert lengths[int(0.95 * len(lengths))] < 6_000 * CHARACTERS_A_TOKEN
    assert "removes_soaked" not in prompts["putting_shoes_on_rack"].user


def test_the_declaration_conforms(activities: TaskSet[Task], domain: Domain) -> None:
    names = ("cook_cabbage", "make_pizza", "cleaning_up_plates_and_food", "washing_vegetables")
    assert check(domain, [activities[name].initial for name in names]) == ()
