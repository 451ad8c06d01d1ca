"""A formula that the first state breaks is false on every trace that begins with it."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from eai.logic.formula import Formula
from eai.logic.ltl import read_formula
from eai.logic.semantics import holds
from eai.logic.signature import FormulaSignature
from eai.logic.start import is_refuted_by_initial_state
from eai.logic.trace import TakenAction, Trace
from logic.naive import Facts
from logic.random_formulas import formulas, trace, traces
from sweeps import examples


@given(formulas(), traces())
@settings(max_examples=examples(400), deadline=None)
def test_a_broken_formula_holds_on_no_trace_with_this_start(
    formula: Formula, given_: tuple[list[Facts], list[TakenAction]]
) -> None:
    states, actions = given_
    if is_refuted_by_initial_state(formula, Trace(states[:1])):
        assert not holds(formula, Trace(states, actions))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("always not p()", True),
        ("always (p() implies q())", True),
        ("always (p() implies eventually q())", False),
        ("not eventually p()", True),
        ("not eventually q()", False),
        ("q() until r()", True),
        ("p() until r()", False),
        ("not (p() until p())", True),
        ("always q() and eventually r()", True),
        ("always q() or eventually r()", False),
        ("always not p() then q()", True),
        ("p() implies always q()", True),
        ("q() implies always q()", False),
        ("r() and next q()", False),
        ("always not GRAB()", False),
        ("always (forall x: cup. (p()))", False),
        ("always (exists x: cup. (q()))", True),
        ("not always (true)", False),
    ],
)
def test_examples_of_broken_formulas(text: str, expected: bool) -> None:
    names = FormulaSignature({"p": 0, "q": 0, "r": 0}, {"GRAB": 0})
    formula, misuses = read_formula(text, names)
    assert not misuses
    assert is_refuted_by_initial_state(formula, trace("p")) is expected
