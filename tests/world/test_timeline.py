from __future__ import annotations

import pytest

from eai.logic.ltl import parse
from eai.logic.semantics import explain, holds
from eai.logic.signature import Signature
from eai.world.execution import Action, execute
from eai.world.timeline import timeline
from world import toy

START = toy.initial()
ROBOT, HALL, SHED, RED, BLUE, LAMP = range(6)
PLAN = (Action("LIFT", (RED,)), Action("LIFT", (RED,)), Action("GO", (SHED,)), Action("PRESS", (LAMP,)))
TIMELINE = timeline(execute(toy.DOMAIN, START, PLAN[::2]))
SIGNATURE = Signature({"at": 2, "holding": 1, "lit": 1, "beside": 1}, {"GO": 1, "LIFT": 1})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("holding(red) then at(red, shed)", True),
        ("LIFT(red) then GO(shed)", True),
        ("GO(shed) then LIFT(red)", False),
        ("beside(blue)", True),
        ("beside(red) then beside(lamp)", True),
        ("beside(lamp) then beside(red) then beside(red)", False),
        ("forall x:box. (at(x, shed))", True),
        ("exists x. (lit(x))", False),
        ("at(red, moon)", False),
        ("flies(red)", False),
        ("at(red)", False),
    ],
)
def test_formulas_are_asked_of_what_was_executed(text: str, expected: bool) -> None:
    assert holds(parse(text, SIGNATURE).formula, TIMELINE) is expected


def test_the_evidence_is_in_terms_of_executed_steps() -> None:
    evidence = explain(parse("holding(red) then (at(red, shed) and lit(lamp))").formula, TIMELINE)
    assert (evidence.holds, evidence.positions) == (False, (1,))
    assert evidence.failed == (parse("lit(lamp)").formula,)


def test_steps_that_were_not_executed_are_no_part_of_it() -> None:
    failed = timeline(execute(toy.DOMAIN, START, (Action("DROP", (RED,)),)))
    assert failed.length == 1
    assert not holds(parse("DROP(red)", Signature({}, {"DROP": 1})).formula, failed)
