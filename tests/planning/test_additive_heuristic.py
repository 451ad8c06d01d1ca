from __future__ import annotations

import pytest

from eai.logic.formula import And, Atom, Constant, Exactly, Exists, Formula, ForPairs, Not, Or, Variable
from eai.planning.additive_heuristic import INFINITE, Distances, Regression
from eai.planning.preferred_operators import Helpful
from eai.planning.wanted import Wanted
from eai.world.execution import Action
from world import toy
from world.toy import X, Y, at, holding

START = toy.initial()
SCENE = START.scene
EVERYTHING = tuple(range(len(SCENE.objects)))
REGRESSION = Regression(toy.DOMAIN)


def named(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


def wanted(formula: Formula) -> Wanted:
    return Wanted(formula, {}, True)


LAMP_LIT = named("lit", "lamp")
RED_IN_SHED = named("at", "red", "shed")
BOX = Variable("x", "box")
PLACE = Variable("y", "place")


@pytest.mark.parametrize(
    ("condition", "cost"),
    [
        (named("at", "red", "hall"), 0),
        (named("holding", "red"), 1),
        (named("holding", "blue"), 2),  # GO, LIFT
        (LAMP_LIT, 2),  # GO, PRESS
        (RED_IN_SHED, 2),  # LIFT, GO
        (Not(named("at", "robot", "hall")), 1),
        (And((LAMP_LIT, named("holding", "red"))), 3),
        (Or((LAMP_LIT, named("holding", "red"))), 1),
        (Exists(X, holding(X)), 1),
        (named("at", "lamp", "hall"), INFINITE),
    ],
)
def test_the_estimate_adds_up_what_must_be_done(condition: Formula, cost: float) -> None:
    distances = Distances(REGRESSION, START, EVERYTHING)
    assert distances.to(Wanted(condition, {}, True)) == cost


def helpful(distances: Distances, formula: Formula) -> list[Action]:
    found = Helpful(REGRESSION, distances)
    found.towards(Wanted(formula, {}, True))
    return list(found.actions)


def test_helpful_actions_are_possible_at_once() -> None:
    distances = Distances(REGRESSION, START, EVERYTHING)
    go, lift = Action("GO", (SCENE.index["shed"],)), Action("LIFT", (SCENE.index["red"],))
    both = And((LAMP_LIT, named("holding", "red")))
    assert helpful(distances, LAMP_LIT) == [go]
    assert helpful(distances, both) == [go, lift]
    way = distances.to_action(("PRESS",))
    assert (way.cost, way.action) == (2.0, Action("PRESS", (SCENE.index["lamp"],)))
    found = Helpful(REGRESSION, distances)
    found.along(way)
    assert list(found.actions) == [go]
    assert distances.to_action(("FLY",)).cost == INFINITE


def test_an_estimate_tells_what_an_action_would_undo() -> None:
    something_in_hall = Exists(X, at(X, Constant("hall")))
    robot_in_hall = named("at", "robot", "hall")
    away = wanted(named("at", "robot", "shed"))
    assert Distances(REGRESSION, START, EVERYTHING, [wanted(robot_in_hall)]).to(away) == 2
    assert Distances(REGRESSION, START, EVERYTHING, [wanted(something_in_hall)]).to(away) == 1


def test_a_condition_comes_down_to_its_cheapest_parts() -> None:
    distances = Distances(REGRESSION, START, EVERYTHING)
    lifted = named("holding", "red")
    both = And((Or((LAMP_LIT, lifted)), Not(named("lit", "lamp"))))
    assert [part.formula for part in distances.chosen(wanted(both))] == [lifted, LAMP_LIT]
    assert distances.chosen(wanted(LAMP_LIT)) == (wanted(LAMP_LIT),)
    assert distances.alternatives(wanted(Or((LAMP_LIT, lifted)))) == [wanted(lifted)]


def test_numbers_and_pairs_are_chosen_cheaply() -> None:
    distances = Distances(REGRESSION, START, EVERYTHING)
    boxes = [SCENE.index[name] for name in ("red", "blue")]
    one = distances.chosen(wanted(Exactly(1, BOX, holding(X))))
    assert [(each.scope["x"], each.truth) for each in one] == [(boxes[0], True), (boxes[1], False)]
    pairs = distances.chosen(wanted(ForPairs(BOX, PLACE, at(X, Y))))
    places = [SCENE.index[name] for name in ("hall", "shed")]
    assert [(each.scope["x"], each.scope["y"]) for each in pairs] == list(zip(boxes, places, strict=True))
