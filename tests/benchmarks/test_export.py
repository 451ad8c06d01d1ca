"""Households exported as PDDL: engine and exported operators agree on the data set's own plans."""

from __future__ import annotations

import random
from collections.abc import Mapping

import pytest

from eai.base.errors import DataError
from eai.benchmarks.behavior.domain import make_domain_with_checks_in_paper_order as behavior
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.benchmarks.virtualhome.domain import make_domain_with_checks_in_paper_order as virtualhome
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.pddl.execute import PddlPlanExecutor, PddlState
from eai.pddl.export import export_domain_and_problem
from eai.pddl.fast_downward import FastDownward
from eai.pddl.planning import PlannerOutcome, PlanningTask
from eai.tasks.task import GoalKind, Task
from eai.world.action import Fault
from eai.world.domain import Domain
from eai.world.execution import attempt_action, execute_plan
from eai.world.fault import FaultKind
from eai.world.history import History
from sweeps import sweep, swept


def draw_tasks(tasks: Mapping[str, Task], count: int) -> list[Task]:
    return [tasks[name] for name in random.Random(11).sample(list(tasks), count)]


def compare_engines(domain: Domain, task: Task) -> tuple[int, list[frozenset[str]]]:
    """Return the number of executed steps, and for each differing state the differing predicates.

    After a difference, the PDDL executor continues from the engine's state. A step that the engine does not
    execute must not be applicable.
    """
    exported = export_domain_and_problem(domain, task.initial, [goal.formula for goal in task.goals])
    executor = PddlPlanExecutor(exported.domain, exported.problem)
    state: PddlState = executor.initial_state
    static = state - exported.export_state(task.initial)
    executed, differing = 0, []
    past = History(task.initial)
    for action in task.script:
        operator = domain.find_operator(action.operator)
        if operator is None or operator.arity != len(action.arguments):
            break
        outcome = attempt_action(domain, past, action)
        reached = executor.execute_step(state, exported.to_pddl_step(action))
        if isinstance(outcome, Fault):
            assert isinstance(reached, str), action
            if outcome.kind is FaultKind.ADDITIONAL_STEP:
                continue
            break
        assert not isinstance(reached, str), reached
        executed += 1
        past = past.extend(outcome)
        state = exported.export_state(outcome) | static
        predicates = {atom.predicate for atom in reached ^ state if not atom.predicate.startswith("done-")}
        if predicates:
            differing.append(frozenset(predicates))
        state |= {atom for atom in reached if atom.predicate.startswith("done-")}
    return executed, differing


def test_exported_behavior_operators_agree_with_the_engine(behavior_tasks: BehaviorTasks) -> None:
    comparisons = [compare_engines(behavior(), task) for task in draw_tasks(behavior_tasks, 10)]
    assert sum(executed for executed, _ in comparisons) > 60
    assert [differing for _, differing in comparisons if differing] == []


@sweep
def test_exported_virtualhome_operators_agree_with_the_engine(virtualhome_tasks: VirtualHomeTasks) -> None:
    comparisons = [compare_engines(virtualhome(), task) for task in draw_tasks(virtualhome_tasks, 2)]
    assert sum(executed for executed, _ in comparisons) > 10
    assert [differing for _, differing in comparisons if differing] == []


def test_the_export_of_virtualhome_leaves_nothing_out(virtualhome_tasks: VirtualHomeTasks) -> None:
    (task,) = draw_tasks(virtualhome_tasks, 1)
    assert export_domain_and_problem(virtualhome(), task.initial, ()).unsupported == ()


def find_planner() -> FastDownward:
    try:
        return FastDownward.find_installed(cpu_seconds=60)
    except DataError as error:
        pytest.skip(str(error))


def assert_plan_works(domain: Domain, task: Task, objects: int | None) -> None:
    """Fail unless Fast Downward's plan for the exported task reaches the goal in the engine."""
    exported = export_domain_and_problem(
        domain, task.initial, [goal.formula for goal in task.goals], objects=objects
    )
    result = find_planner().solve(PlanningTask(exported.domain, exported.problem))
    assert result.outcome is PlannerOutcome.SOLVED, result.detail
    trajectory = execute_plan(domain, task.initial, [exported.to_action(step) for step in result.plan])
    assert trajectory.failure is None
    assert trajectory.needless_step_count == 0
    goals = [goal for goal in task.goals if goal.kind is not GoalKind.ACTION]
    assert all(domain.holds(goal.formula, trajectory.final_state) for goal in goals)


@pytest.mark.parametrize("activity", ["moving_boxes_to_storage", "picking_up_take-out_food"])
def test_fast_downward_solves_exported_behavior_tasks(behavior_tasks: BehaviorTasks, activity: str) -> None:
    task = next(behavior_tasks[name] for name in behavior_tasks if name.startswith(activity))
    assert_plan_works(behavior(), task, None)


@pytest.mark.parametrize("number", [1, *swept(0)])
def test_fast_downward_solves_exported_virtualhome_tasks_with_relevant_objects(
    virtualhome_tasks: VirtualHomeTasks, number: int
) -> None:
    task = draw_tasks(virtualhome_tasks, 2)[number]
    about = task.initial.mask("ROOM")
    for index in task.relevant:
        about |= 1 << index
    assert_plan_works(virtualhome(), task, about)
