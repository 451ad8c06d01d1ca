from __future__ import annotations

from benchmarks.plan_scorers import virtualhome_scorer
from benchmarks.virtualhome.household import make_task
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import Atom, Constant
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import SearchEndReason
from eai.tasks.planning import find_plan, to_planning_goal
from sweeps import every

UNREACHABLE = {"688_1"}
"""Tasks whose goal no plan reaches (docs/pddl.md)."""


def test_the_goal_of_a_plan_is_that_of_the_task() -> None:
    task = make_task(goals=("state OPEN fridge.10", "action LOOKAT|WATCH", "action TYPE"))
    assert to_planning_goal(task) == PlanningGoal(
        (Atom("OPEN", (Constant("fridge.10"),)),), (("LOOKAT", "WATCH"), ("TYPE",))
    )


@every(8)
def test_the_planner_solves_every_task_whose_goal_can_be_reached(
    virtualhome_tasks: VirtualHomeTasks, every: int
) -> None:
    """Not only by its own account: the plans score."""
    planner = Planner(virtualhome.make_domain_with_checks_in_paper_order())
    unsolved, wrong = set(), {}
    tasks = [virtualhome_tasks[task_id] for task_id in sorted(virtualhome_tasks)[::every]]
    for task in tasks:
        found = find_plan(task, planner)
        if found.end is not SearchEndReason.SOLVED:
            unsolved.add(task.id)
        elif task.goals:
            scorer = virtualhome_scorer(task)
            text = scorer.notation.join(scorer.notation.write(found.plan, task.scene))
            verdict = scorer.score(text)
            if not (verdict.success and verdict.executable and verdict.additional_steps == 0):
                wrong[task.id] = text
    assert unsolved == UNREACHABLE & {task.id for task in tasks}
    assert wrong == {}
