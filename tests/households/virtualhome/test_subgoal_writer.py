from __future__ import annotations

import json

import pytest

from eai.abilities.planning import find_plan
from eai.abilities.protocol import Protocol
from eai.households.virtualhome.subgoal_notation import VirtualHomeSubgoals
from eai.households.virtualhome.tasks import VirtualHomeTasks
from eai.planning.planner import PlanningEnd
from households.virtualhome import flat
from households.virtualhome.household import make_task
from subgoal_scorers import virtualhome_subgoals

WORDS = VirtualHomeSubgoals()

WITHOUT_A_PLAN = {"688_1"}
"""Tasks whose goal no subgoals lead to: one object in both hands (docs/planner.md)."""

COFFEE = {"183_2", "229_1", "310_2", "721_2", "764_2"}
"""Tasks whose goal names POUR, which the reference cannot read."""


AT_HAND = tuple(
    f"NEXT_TO character.65 {thing}.{number}"
    for thing, number in (
        ("fridge", 10),
        ("milk", 11),
        ("table", 12),
        ("cup", 13),
        ("shirt", 17),
        ("bed", 20),
    )
)


@pytest.mark.parametrize(
    ("step", "subgoal"),
    [
        ("WALK kitchen.1", "INSIDE(character.65, kitchen.1)"),
        ("WALK cup.13", "NEXT_TO(character.65, cup.13)"),
        ("FIND book.16", "NEXT_TO(character.65, book.16)"),
        ("OPEN fridge.10", "OPEN(fridge.10)"),
        ("SWITCHOFF fridge.10", "OFF(fridge.10)"),
        ("GRAB cup.13", "HOLDS_RH(character.65, cup.13)"),
        ("PUTON shirt.17", "ONTOP(shirt.17, character.65)"),
        ("LIE bed.20", "ONTOP(character.65, bed.20)"),
        ("WASH table.12", "WASH(table.12)"),
        ("SLEEP", "SLEEP()"),
    ],
)
def test_each_step_has_a_subgoal(step: str, subgoal: str) -> None:
    task = make_task(*AT_HAND)
    assert WORDS.write(task, [flat.action(step, task.scene)]) == (subgoal,)


def test_what_a_step_needs_is_stated_before_it() -> None:
    task = make_task()
    assert WORDS.write(task, [flat.action("PUTIN milk.11 cup.13", task.scene)]) == (
        "NEXT_TO(character.65, milk.11)",
        "HOLDS_RH(character.65, milk.11)",
        "NEXT_TO(character.65, cup.13)",
        "INSIDE(milk.11, cup.13)",
    )


def test_what_is_elsewhere_is_gone_to_before_it_is_faced() -> None:
    task = make_task()
    written = WORDS.write(task, [flat.action("TURNTO television.22", task.scene)])
    assert written == ("NEXT_TO(character.65, television.22)", "FACING(character.65, television.22)")


def test_nothing_stands_for_posture_and_an_action_for_what_holds_already() -> None:
    near = ("NEXT_TO character.65 cup.13", "NEXT_TO character.65 milk.11", "HOLDS_RH character.65 milk.11")
    task = make_task("SITTING character.65", "INSIDE milk.11 cup.13", *near)
    plan = [flat.action(step, task.scene) for step in ("STANDUP", "POUR milk.11 cup.13")]
    assert WORDS.write(task, plan) == ("POUR(milk.11, cup.13)",)


def test_the_second_thing_is_taken_with_the_left_hand() -> None:
    task = make_task("HOLDS_RH character.65 book.16", "NEXT_TO character.65 cup.13")
    assert WORDS.write(task, [flat.action("GRAB cup.13", task.scene)]) == ("HOLDS_LH(character.65, cup.13)",)


def test_subgoals_are_joined_into_an_answer() -> None:
    assert json.loads(WORDS.join(["A(x)", "B(y)"]))["output"] == ["A(x)", "B(y)"]


def test_the_planners_subgoals_reach_every_goal_that_subgoals_can_reach(
    virtualhome_tasks: VirtualHomeTasks,
) -> None:
    planner = WORDS.planner()
    unsolved, wrong = set(), {}
    for task in virtualhome_tasks.values():
        if not task.goals:
            continue
        found = find_plan(task, planner)
        if found.end is not PlanningEnd.SOLVED:
            unsolved.add(task.id)
            continue
        text = WORDS.join(WORDS.write(task, found.plan))
        seated = task.initial.has("SITTING", task.scene.agent)
        verdicts = [virtualhome_subgoals(protocol)(task).score(text) for protocol in Protocol]
        categories = tuple(v.category.value for v in verdicts if v.category is not None)
        # The reference does not know POUR, and no subgoal makes the character stand up there.
        in_reference = "hallucination" if task.id in COFFEE else "runtime" if seated else "correct"
        expected = ("correct", in_reference)
        if categories != expected:
            wrong[task.id] = (categories, text)
    assert unsolved == WITHOUT_A_PLAN
    assert wrong == {}
