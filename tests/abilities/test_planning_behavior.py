from __future__ import annotations

from collections.abc import Sequence

import pytest

from benchmarks.plan_scorers import behavior_scorer
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.notation import BehaviorSubgoalNotation
from eai.benchmarks.behavior.tasks import BehaviorTask, BehaviorTasks
from eai.planning.planner import Planner
from eai.planning.search import SearchResult
from eai.tasks.planning import find_plan
from eai.world.action import Action
from eai.world.execution import attempt_action
from eai.world.history import History
from eai.world.state import State
from subgoal_scorers import behavior_subgoals

DOMAIN = behavior.make_domain_with_checks_in_paper_order()

HARD = ("cleaning_up_the_kitchen_only", "packing_lunches", "preserving_food", "setting_up_candles")
"""Tasks in which goals get in each other's way."""

MOST_STATES = 300
"""More than any of the sample takes; the search is deterministic."""


def sample(tasks: BehaviorTasks) -> list[BehaviorTask]:
    """Return every sixth task, and the tasks that are hard to plan for."""
    ids = list(tasks)
    return [tasks[i] for i in ids if ids.index(i) % 6 == 1 or i.startswith(HARD)]


@pytest.fixture(scope="module")
def planner_results(behavior_tasks: BehaviorTasks) -> list[tuple[BehaviorTask, SearchResult[Action]]]:
    """Return the sample with the planner's result for each task."""
    planner = Planner(DOMAIN)
    return [(task, find_plan(task, planner)) for task in sample(behavior_tasks)]


def reaches(task: BehaviorTask, steps: Sequence[Action]) -> bool:
    """Whether a plan without its impossible steps reaches all goals."""
    state = task.initial
    for step in steps:
        after = attempt_action(DOMAIN, History(state), step)
        state = after if isinstance(after, State) else state
    return all(DOMAIN.holds(goal.formula, state) for goal in task.goals)


def test_plans_score_and_no_step_can_be_left_out(
    planner_results: list[tuple[BehaviorTask, SearchResult[Action]]],
) -> None:
    for task, found in planner_results:
        assert found.states < MOST_STATES, task.id
        scorer = behavior_scorer(task)
        verdict = scorer.score(scorer.notation.join(scorer.notation.write(found.plan, task.scene)))
        assert (verdict.success, verdict.executable, verdict.additional_steps) == (True, True, 0), task.id
        for i in range(len(found.plan)):
            assert not reaches(task, (*found.plan[:i], *found.plan[i + 1 :])), task.id


def test_subgoals_of_the_planner_succeed(
    planner_results: list[tuple[BehaviorTask, SearchResult[Action]]],
) -> None:
    words = BehaviorSubgoalNotation()
    for task, found in planner_results:
        text = words.join(words.write(task, found.plan))
        verdict = behavior_subgoals()(task).score(text)
        assert (verdict.success, verdict.executable) == (True, True), task.id
