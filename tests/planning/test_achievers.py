from __future__ import annotations

from dataclasses import replace

from eai.planning.achievers import Achievers
from eai.world.frame import AGENT
from world import toy
from world.toy import X, Y, at

START = toy.initial()
SCENE = START.scene
EVERYTHING = SCENE.everything


def test_changes_are_found_in_the_effects() -> None:
    achievers = Achievers(toy.DOMAIN)
    adding = achievers.of("at", adding=True)
    assert [(each.schema.operator.name, len(each.conditions)) for each in adding] == [("GO", 1), ("GO", 2)]
    assert adding[0].match((0, 1), agent=0) == {"x": 1}
    assert adding[0].match((2, 1), agent=0) is None
    assert adding[1].match((2, 1), agent=0) == {"y": 2, "x": 1}
    assert [each.schema.operator.name for each in achievers.of("lit", adding=False)] == ["PRESS"]
    assert [operator.name for operator in achievers.writers(["lit", "holding"])] == ["PRESS", "LIFT", "DROP"]


def test_what_an_effect_hides_is_left_out() -> None:
    hidden = replace(toy.GO, name="HIDE", parameters=(X, Y))
    domain = replace(toy.DOMAIN, operators=(hidden,))
    assert [each.schema.atom for each in Achievers(domain).of("at", adding=True)] == [at(AGENT, X)]


def test_what_an_atom_leaves_open_is_filled_in() -> None:
    go, carry = Achievers(toy.DOMAIN).of("at", adding=True)
    shed, red = SCENE.index["shed"], SCENE.index["red"]
    scopes = [go.scope(binding) for binding in go.bindings(START, {}, EVERYTHING)]
    assert scopes == [{"x": SCENE.index["hall"]}, {"x": shed}], "what is no place is left out at once"
    (binding,) = carry.bindings(START, {"y": red, "x": shed}, EVERYTHING)
    assert carry.arguments(binding) == (shed,)
    assert carry.failing(START, binding, 2) == [toy.holding(Y)]
    assert carry.failing(START, binding, 1) is None
    assert list(go.bindings(START, {}, 0)) == []
