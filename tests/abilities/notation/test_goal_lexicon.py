"""Goals that an answer states, as goals of its task.

Unknown names are kept, ill-formed goals are left out.
"""

from __future__ import annotations

import json

import pytest

from eai.abilities.notation.goal_lexicon import _GoalsStatedByAnswer, read_stated_goals, write_goals
from eai.abilities.notation.goals import JsonGoalNotation
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import Constant
from eai.tasks.goal_test import list_actions_that_meet_goal
from eai.tasks.goal_text import make_task, write_goal
from eai.tasks.task import GoalKind, Task
from world import toy

TASK = make_task("1", "Tidy up.", toy.initial(), toy.lit(Constant("lamp")))


def stated(text: str) -> _GoalsStatedByAnswer:
    return read_stated_goals(text, TASK, toy.DOMAIN, JsonGoalNotation())


def texts(read: _GoalsStatedByAnswer) -> list[tuple[GoalKind, str]]:
    return [(goal.kind, write_goal(goal.formula)) for goal in read.goals]


def test_goals_of_every_kind_are_read_in_the_order_of_kinds() -> None:
    read = stated(
        '{"action goals": ["PRESS"], "edge goals": [["at", "red", "shed"]],'
        ' "node goals": [["lit", "lamp"], ["not", ["lit", "lamp"]], ["lit", "lamp"]]}'
    )
    assert texts(read) == [
        (GoalKind.STATE, "lit(lamp)"),
        (GoalKind.STATE, "not lit(lamp)"),
        (GoalKind.RELATION, "at(red, shed)"),
        (GoalKind.ACTION, "PRESS"),
    ]
    assert (read.meaningful, read.unknown, read.left_out) == (read.goals, (), ())


def test_unknown_names_are_kept_as_written() -> None:
    read = stated(
        '{"node goals": [["lit", "sun"], ["shiny", "lamp"], ["lit", "lamp"]], "action goals": ["SING"]}'
    )
    assert [text for _, text in texts(read)] == ["lit(sun)", "shiny(lamp)", "lit(lamp)", "SING"]
    assert read.unknown == ("sun", "shiny", "SING")
    assert [write_goal(goal.formula) for goal in read.meaningful] == ["lit(lamp)"]


def test_ill_formed_goals_are_left_out() -> None:
    read = stated(
        '{"node goals": [["lit"], ["lit", "lamp", "red"], 7, ["not", "lit", "lamp"], ["lit", "lamp"]]}'
    )
    assert [text for _, text in texts(read)] == ["lit(lamp)"]
    assert len(read.left_out) == 4


class ByClass(JsonGoalNotation):
    """A notation in which the name of an object is its class, so that several objects have one name."""

    def list_object_names(self, task: Task) -> tuple[str, ...]:
        return tuple(thing.category for thing in task.scene.objects)


@pytest.mark.parametrize(
    ("relations", "meant"),
    [
        ([["at", "box", "box"]], ["at(blue, red)"]),  # nothing is related to itself
        ([["at", "lamp", "lamp"]], ["at(lamp, lamp)"]),  # if there is another object
        ([["at", "box", "hall"]] * 3, ["at(blue, hall)", "at(red, hall)"]),
        ([["at", "box", "place"]] * 3, ["at(blue, shed)", "at(blue, hall)", "at(red, shed)"]),
    ],
)
def test_a_class_stands_for_other_objects_each_time(relations: list[list[str]], meant: list[str]) -> None:
    answer = json.dumps({"edge goals": relations})
    read = read_stated_goals(answer, TASK, toy.DOMAIN, ByClass())
    assert [text for _, text in texts(read)] == meant


def test_nested_goals_are_understood() -> None:
    read = stated('{"edge goals": [["exists", "box", ["or", ["at", "box", "hall"], ["lit", "lamp"]]]]}')
    assert texts(read) == [(GoalKind.RELATION, "exists x: box. (at(x, hall) or lit(lamp))")]
    assert read.unknown == ()


@pytest.mark.parametrize("text", ["", "I cannot.", '{"node goals": "lit lamp"}', "[1, 2"])
def test_an_unreadable_answer_states_no_goals(text: str) -> None:
    read = stated(text)
    assert (read.goals, read.left_out) == ((), ())
    assert read.unreadable


def test_gold_answers_state_goals_that_mean_something(
    behavior_tasks: BehaviorTasks, virtualhome_tasks: VirtualHomeTasks
) -> None:
    for name, tasks in (("behavior", behavior_tasks), ("virtualhome", virtualhome_tasks)):
        benchmark = find_benchmark(name)
        for task in tasks.values():
            answer = benchmark.notation.goals.join(
                write_goals(task, benchmark.domain, benchmark.notation.goals)
            )
            read = read_stated_goals(answer, task, benchmark.domain, benchmark.notation.goals)
            assert (read.unreadable, read.unknown, read.left_out) == (None, (), ()), task.id
            assert read.goals == read.meaningful


def test_in_virtualhome_gold_answers_state_the_goals(virtualhome_tasks: VirtualHomeTasks) -> None:
    """Gold answers name only classes. Of alternative actions they state the first."""
    benchmark = find_benchmark("virtualhome")
    for task in virtualhome_tasks.values():
        answer = benchmark.notation.goals.join(write_goals(task, benchmark.domain, benchmark.notation.goals))
        read = read_stated_goals(answer, task, benchmark.domain, benchmark.notation.goals)
        lasting = [{g for g in goals if g.kind is not GoalKind.ACTION} for goals in (read.goals, task.goals)]
        assert lasting[0] == lasting[1], task.id
        actions = [list_actions_that_meet_goal(goal)[0] for goal in task.get_goals_of_kind(GoalKind.ACTION)]
        assert [list_actions_that_meet_goal(g) for g in read.goals if g.kind is GoalKind.ACTION] == [
            (a,) for a in actions
        ]


def test_a_repeated_class_means_the_object_before_its_last(
    virtualhome_tasks: VirtualHomeTasks,
) -> None:
    benchmark, task = find_benchmark("virtualhome"), virtualhome_tasks["120_1"]
    things = task.scene.objects
    lights = [things[i].name for i in task.relevant if things[i].category == "light"]
    assert len(lights) == 2
    last = benchmark.notation.plans.make_object_lookup(task)("light")
    assert last is not None
    assert things[last].name == lights[-1]
    for times, meant in ((1, lights[1:]), (2, lights[::-1]), (5, lights[::-1])):
        answer = json.dumps({"node goals": [{"name": "light", "state": "ON"}] * times})
        read = read_stated_goals(answer, task, benchmark.domain, benchmark.notation.goals)
        assert [write_goal(goal.formula) for goal in read.goals] == [f"ON({name})" for name in meant]
