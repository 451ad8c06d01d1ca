"""Grounding a formula into what there is to choose."""

from __future__ import annotations

import pytest

from eai.errors import InputError
from eai.logic.choice import AllOf, AnyOf, Choose, Leaf, Pairing, ground, literals
from eai.logic.formula import And, Atom, Constant, Not, Variable
from eai.logic.ltl import parse
from eai.logic.options import options
from logic.activities import universe
from protocols import of_reference


@pytest.mark.parametrize(
    "text",
    [
        "not forn 2 x. (p(x))",
        "not (p() then q())",
        "always p()",
        "forn 1 x. (not forpairs x: a, y: a. (r(x, y)))",
    ],
)
def test_what_leaves_no_finite_choice_is_an_error(text: str) -> None:
    with pytest.raises(InputError, match="no finite choice"):
        list(options(parse(text).formula, universe(a=2).objects))


def test_unbound_variables_are_an_error() -> None:
    unbound = And((Atom("p", (Variable("x"),)),))
    with pytest.raises(InputError, match="variable x is not bound"):
        list(options(unbound, universe().objects))
    with pytest.raises(InputError, match="variable x is not bound"):
        of_reference("behavior_goal_test").truncated_options(unbound, universe().objects)


def test_the_tree_of_a_formula() -> None:
    formula = parse("forall x: a. (not (p(x) and q(x))) and forn 1 y: a. (p(y))").formula
    p, q = ([Leaf(Atom(name, (Constant(f"a{i}"),))) for i in range(2)] for name in ("p", "q"))
    negated = [AnyOf((Leaf(Not(x.literal)), Leaf(Not(y.literal)))) for x, y in zip(p, q, strict=True)]
    tree = ground(formula, universe(a=2).objects)
    assert tree == AllOf((AllOf(tuple(negated)), Choose(1, tuple(p))))
    assert len(list(literals(tree))) == 6


def test_no_object_is_paired_with_itself() -> None:
    formula = parse("forpairs x: a, y: a. (p(x, y))").formula
    tree = ground(formula, universe(a=2).objects)
    cells = [[Leaf(Atom("p", (Constant(f"a{i}"), Constant(f"a{j}")))) for j in range(2)] for i in range(2)]
    assert tree == Pairing(2, ((None, cells[0][1]), (cells[1][0], None)))


def test_equations_are_decided() -> None:
    formula = parse("exists x: a. (x = a1 and not x = a0)").formula
    assert ground(formula, universe(a=2).objects) == AnyOf(
        (AllOf((AnyOf(()), AnyOf(()))), AllOf((AllOf(()), AllOf(()))))
    )
