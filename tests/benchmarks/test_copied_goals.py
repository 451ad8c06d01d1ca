"""Goals copied as subgoals."""

from __future__ import annotations

import pytest

from eai.abilities.notation.subgoals import SubgoalNotation
from eai.benchmarks.copied_answers import write_goal_parts_as_subgoals
from eai.logic.formula import (
    And,
    Constant,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Not,
    Occurs,
    Or,
    Variable,
)
from eai.logic.ltl_printer import format_ltl
from eai.tasks.goal_text import make_task
from eai.tasks.task import Task
from world import toy

X, Y = Variable("x"), Variable("y")
BOX, PLACE = Variable("x", "box"), Variable("y", "place")
RED, SHED = Constant("red"), Constant("shed")


def task(*goals: Formula) -> Task:
    return make_task("1", "Tidy up.", toy.initial(), *goals)


@pytest.mark.parametrize(
    ("goals", "copied"),
    [
        ([toy.at(RED, SHED)], "at(red, shed)"),
        ([toy.at(RED, SHED), toy.lit(RED)], "at(red, shed); lit(red)"),
        (
            [And((toy.at(RED, SHED), ForAll(BOX, And((toy.lit(X), toy.lit(RED))))))],
            "at(red, shed); lit(red); lit(blue)",
        ),
        ([Occurs("PRESS"), Occurs("PRESS")], "exists x0. PRESS(x0); exists x0. PRESS(x0)"),
        # Actions come first, in order, on any objects.
        (
            [toy.lit(RED), Or((Occurs("LIFT"), Occurs("DROP"))), Occurs("PRESS")],
            "(exists x0. LIFT(x0) or exists x0. DROP(x0)); exists x0. PRESS(x0); lit(red)",
        ),
        # Quantifiers are written out.
        ([ForAll(BOX, toy.lit(X))], "lit(red); lit(blue)"),
        ([Exists(BOX, Not(toy.lit(X)))], "not lit(red) or not lit(blue)"),
        ([Exactly(1, BOX, toy.lit(X))], "lit(red)"),
        ([ForPairs(BOX, PLACE, toy.at(X, Y))], "at(red, hall); at(blue, shed)"),
        ([ForPairs(BOX, PLACE, toy.at(X, Y), 1)], "at(red, hall)"),
    ],
)
def test_each_part_of_a_goal_is_copied_as_a_subgoal(goals: list[Formula], copied: str) -> None:
    parts = write_goal_parts_as_subgoals(task(*goals), SubgoalNotation(toy.DOMAIN))
    written = "; ".join(map(format_ltl, parts))
    assert written.replace("(", "").replace(")", "") == copied.replace("(", "").replace(")", "")
