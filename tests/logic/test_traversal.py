"""Functions that walk over formulas."""

from __future__ import annotations

import pytest

from eai.logic.formula import And, Atom, Constant, Equals, Exists, Not, Or, Variable
from eai.logic.ltl import parse
from eai.logic.traversal import (
    find_object_names,
    find_subformula_ids_monotone_in_trace_length,
    find_temporal_subformula_ids,
    is_state_formula,
    walk_subformulas,
)

P, Q, R = Atom("p"), Atom("q"), Atom("r")


def test_walk_goes_from_left_to_right_and_top_to_bottom() -> None:
    left, right = Not(P), Or((Q, R))
    formula = And((left, right))
    assert list(walk_subformulas(formula)) == [formula, left, P, right, Q, R]


def test_walking_does_not_recurse() -> None:
    formula: Not | Atom = P
    for _ in range(5000):
        formula = Not(formula)
    assert is_state_formula(formula)


def test_temporal_parts_are_those_with_a_temporal_operator_inside() -> None:
    formula = parse("p() and exists x. (q(x) then not p())")
    temporal = [
        part for part in walk_subformulas(formula) if id(part) in find_temporal_subformula_ids(formula)
    ]
    assert [type(part).__name__ for part in temporal] == ["And", "Exists", "Then"]
    assert not is_state_formula(formula)


@pytest.mark.parametrize(
    ("text", "lasting", "perishing"),
    [
        ("p() and not q()", True, False),
        ("p() then q()", True, False),
        ("p() and (p() then q())", True, False),
        ("exists x. (p(x) then q())", True, False),
        ("(always p()) then q()", True, False),
        ("p() then always q()", False, False),
        ("next p()", True, False),
        ("p() until q()", True, False),
        ("not (p() then q())", False, True),
        ("always p()", False, True),
        ("forall x. (always p(x))", False, True),
        ("not always p()", True, False),
        ("p() and always q()", False, False),
        ("always next p()", False, False),
        ("forn 1 x. (p(x) then q())", False, False),
        ("(p() then q()) implies r()", False, False),
    ],
)
def test_lasting_and_perishing_parts_are_found_by_their_shape(
    text: str, lasting: bool, perishing: bool
) -> None:
    formula = parse(text)
    found = find_subformula_ids_monotone_in_trace_length(formula)
    assert (
        id(formula) in found.ids_staying_true_when_longer,
        id(formula) in found.ids_staying_true_when_shorter,
    ) == (
        lasting,
        perishing,
    )


def test_object_names_are_listed_once_and_variables_are_left_out() -> None:
    x, cup, box = Variable("x"), Constant("cup"), Constant("box")
    formula = And((Atom("in", (cup, x)), Equals(x, box), Exists(x, Atom("on", (x, cup)))))
    assert find_object_names(formula) == ("cup", "box")
