"""Labels of steps equal the distances that a search of all states finds, or are unknown."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import pytest

import eai
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.notation.plans import JsonPlanNotation
from eai.abilities.plan_distance import NOT_TRIED, StepLabeler, make_labeler_of_step_distances_to_goals
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.tasks.goal_test import GoalTest, find_remaining_goals
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.execution import execute_plan
from eai.world.state import State
from world import toy

MOST = 20_000
GOALS = [
    ("lit(lamp)",),
    ("at(red, shed)", "at(blue, hall)"),
    ("at(red, shed)", "not holding(red)", "lit(lamp)"),
    ("at(red, hall) or at(blue, hall)", "holding(blue)"),
    ("forall b: box. (at(b, shed))", "LIFT()"),
]
TASKS = [eai.make_task(f"{n}", "Do it.", toy.initial(), *g, domain=toy.DOMAIN) for n, g in enumerate(GOALS)]


def labeler(task: Task, limit: int = MOST) -> StepLabeler:
    return make_labeler_of_step_distances_to_goals(
        ActionSequencingScorer(task, toy.DOMAIN, JsonPlanNotation()).repairer, limit
    )


def successors(state: State) -> Iterator[tuple[Action, State]]:
    for operator in toy.DOMAIN.operators:
        objects = range(len(state.scene.objects))
        for action in generate_applicable_actions_of_operator(toy.DOMAIN, operator, state, objects):
            yield action, toy.DOMAIN.apply(state, action)


def distance(task: Task, actions: Sequence[Action]) -> int:
    """Return the length of a shortest plan after some actions, by breadth-first search."""
    start = execute_plan(toy.DOMAIN, task.initial, actions).final_state
    names = frozenset(action.operator for action in actions)
    queue, seen = deque([(start, names, 0)]), {(start, names)}
    while True:
        state, taken, depth = queue.popleft()
        if all(GoalTest(task).evaluate_each_goal(state, [*taken])):
            return depth
        for action, after in successors(state):
            if (node := (after, taken | {action.operator})) not in seen:
                seen.add(node)
                queue.append((*node, depth + 1))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("task", TASKS, ids=lambda task: "-".join(GOALS[int(task.id)]))
def test_distances_and_changes_are_those_of_a_search_of_all_states(task: Task, seed: int) -> None:
    rng, state, plan = random.Random(seed), task.initial, []
    for _ in range(6):
        action, state = rng.choice([*successors(state)])
        plan.append(action)
    expected = [distance(task, plan[:number]) for number in range(len(plan) + 1)]
    start, labels = labeler(task)(plan)
    assert [start, *(label.distance for label in labels)] == expected
    assert [label.change for label in labels] == [after - before for before, after in pairwise(expected)]
    assert {label.outcome for label in labels} == {"executed"}


def action(name: str, *objects: str) -> Action:
    return Action(name, tuple([toy.initial().scene.index[each] for each in objects]))


def test_a_skipped_or_failed_step_changes_nothing_and_later_steps_have_no_label() -> None:
    steps = [action("GO", "shed"), action("GO", "shed"), action("LIFT", "red"), action("PRESS", "lamp")]
    start, labels = labeler(TASKS[0])(steps)
    assert start == 2
    assert [(label.outcome, label.distance, label.change) for label in labels] == [
        ("executed", 1, -1),
        ("additional_step", 1, 0),
        ("wrong_order", 1, 0),
        (NOT_TRIED, None, None),
    ]
    assert [label.step for label in labels] == ["GO(shed)", "GO(shed)", "LIFT(red)", "PRESS(lamp)"]


def test_a_low_limit_makes_distances_unknown_but_never_wrong() -> None:
    plan = [action("LIFT", "red"), action("GO", "shed"), action("DROP", "red"), action("PRESS", "lamp")]
    start, exact = labeler(TASKS[2])(plan)
    assert (start, [label.distance for label in exact]) == (4, [3, 2, 1, 0])
    first, labels = labeler(TASKS[2], 1)(plan)
    assert first in (None, 4)
    for label, other in zip(labels, exact, strict=True):
        assert label.distance in (None, other.distance)
        assert label.change in (None, other.change)


def test_goals_over_time_have_no_distance() -> None:
    task = eai.make_task("t", "", toy.initial(), "lit(lamp)", "always not holding(red)", domain=toy.DOMAIN)
    start, labels = labeler(task)([action("GO", "shed"), action("GO", "shed")])
    assert (start, labels[0].change, labels[1].change) == (None, None, 0)


def test_equal_plans_have_equal_labels_in_any_order_of_answers() -> None:
    one, two = [action("GO", "shed"), action("PRESS", "lamp")], [action("LIFT", "red"), action("GO", "shed")]
    label, again = labeler(TASKS[2], 200), labeler(TASKS[2], 200)
    assert (label(one), label(two)) == tuple(reversed((again(two), again(one))))


def test_an_object_that_the_task_does_not_name_may_be_used_if_the_answer_names_it() -> None:
    index = toy.initial().scene.index
    task = replace(TASKS[0], relevant=(index["lamp"],))
    start, labels = labeler(task)([action("GO", "shed"), action("PRESS", "lamp")])
    assert (start, [label.change for label in labels]) == (2, [-1, -1])
    assert find_remaining_goals(task, ["GO", "PRESS"]) == task.goals
