from __future__ import annotations

from eai.logic.formula import Exists, Variable
from eai.logic.traversal import free_variables
from eai.world.reading import Readings
from world import toy
from world.toy import X, Y, at, beside, lit

START = toy.initial()
SCENE = START.scene


def test_formulas_are_read_with_their_free_variables() -> None:
    formula = beside(X) & ~Exists(Y, at(Y, X) & lit(Y))
    assert free_variables(formula) == frozenset("x")
    readings = Readings(toy.VOCABULARY)
    red, shed = SCENE.index["red"], SCENE.index["shed"]
    assert readings.holds(formula, {"x": red}, START)
    assert not readings.holds(formula, {"x": SCENE.index["lamp"]}, START)
    body = at(Y, X)
    assert list(readings.witnesses(Variable("y"), body, {"x": shed}, START)) == [
        SCENE.index["blue"],
        SCENE.index["lamp"],
    ]
    assert list(readings.witnesses(Variable("y", "box"), body, {"x": shed}, START)) == [SCENE.index["blue"]]
