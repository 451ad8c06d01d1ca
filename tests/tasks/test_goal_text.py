from __future__ import annotations

import pytest

from eai.base.errors import InputError
from eai.logic.formula import Atom, Constant, Exists, ForAll, Formula, ForPairs, Not, Occurs, Then, Variable
from eai.logic.ltl import parse
from eai.tasks.goal_text import make_task
from eai.world.frame import AGENT
from eai.world.state import Scene
from world import toy

BOX, BIX, RED = Variable("b", "box"), Variable("b", "bix"), Constant("red")


def test_a_goal_as_text_is_the_formula() -> None:
    """Of every part: kinds, numbers, order, actions where the domain says which there are."""
    state = toy.initial()
    told = make_task(
        "t", "", state, "forall b: box. (at(b, hall)) and lit(lamp)", "lit(lamp) then holding(red)"
    )
    everywhere = ForAll(BOX, toy.at(Variable("b"), "hall"))
    assert (
        told.goals
        == make_task("t", "", state, everywhere & toy.lit("lamp"), parse("lit(lamp) then holding(red)")).goals
    )
    assert make_task("t", "", state, "LIFT()", domain=toy.DOMAIN).goals[0].formula == Occurs("LIFT", ())


def test_the_agent_may_be_named_as_in_the_domain() -> None:
    task = make_task("t", "", toy.initial(), toy.at(AGENT, "hall"))
    assert task.goals == make_task("t", "", toy.initial(), toy.at("robot", "hall")).goals
    assert task.find_objects_named_in_goals(task.goals) == {0, 1}
    scene = Scene(toy.VOCABULARY, {"hall": "place"})
    with pytest.raises(InputError, match="there is no object agent"):
        make_task("t", "", scene.state([]), toy.at(AGENT, "hall"))


@pytest.mark.parametrize(
    ("goal", "problem"),
    [
        ("lit(lmap)", "line 1, column 5: there is no object lmap; did you mean lamp?"),
        ("lot(lamp)", "line 1, column 1: lot is no predicate and no action; did you mean lit?"),
        ("Lit(lamp)", "line 1, column 1: Lit is no predicate and no action; did you mean lit?"),
        ("lit()", "line 1, column 1: lit takes 1 argument, not 0"),
        ("lit(box)", "there is no object box"),
        ("exists b: bax. (lit(b))", "the scene has no object of the category bax; did you mean box?"),
        ("lit(lamp", "line 1, column 9: expected ')' or ','"),
        ("LIFT(red)", "line 1, column 1: LIFT is no predicate and no action"),
        (toy.lit("lmap"), "there is no object lmap; did you mean lamp?"),
        (Atom("lot", (RED,)), "predicate lot is not declared; did you mean lit?"),
        (Atom("lit", (RED, RED)), "lit takes 1 argument, not 2"),
        (Exists(BIX, toy.lit(BIX)), "the scene has no object of the category bix; did you mean box?"),
        (
            ForPairs(BOX, BIX, toy.at(BOX, BIX)),
            "the scene has no object of the category bix; did you mean box?",
        ),
        (
            toy.lit(Variable("b")),
            "variable b is not bound; add a quantifier, as in 'exists b: lamp. (lit(b))'",
        ),
    ],
)
def test_a_mistake_in_a_goal_is_named(goal: Formula | str, problem: str) -> None:
    with pytest.raises(InputError) as error:
        make_task("light", "", toy.initial(), "lit(lamp)", goal)
    assert str(error.value) == f"task light, goal 2: {problem}"


@pytest.mark.parametrize(
    ("goal", "problem"),
    [
        (
            "LIFT() and lit(lamp)",
            "a goal with actions may only join actions by 'or', without objects and other conditions",
        ),
        ("lit(lamp) then LIFT()", "LIFT takes 1 object, not 0"),
        (
            Not(Occurs("LIFT")),
            "a goal with actions may only join actions by 'or', without objects and other conditions",
        ),
        (Occurs("LIFTS"), "action LIFTS is not declared; did you mean LIFT?"),
        (Then((toy.lit("lamp"), Occurs("LIFT"))), "LIFT takes 1 object, not 0"),
    ],
)
def test_a_mistake_in_a_goal_of_actions_is_named(goal: Formula | str, problem: str) -> None:
    with pytest.raises(InputError) as error:
        make_task("light", "", toy.initial(), goal, domain=toy.DOMAIN)
    assert str(error.value) == f"task light, goal 1: {problem}"
