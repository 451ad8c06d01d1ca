from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from eai.logic.formula import FALSE, TRUE, And, Atom, Constant, Equals, Formula, Not, Or, Variable
from eai.pddl.evaluation import DerivedPredicates, Evaluation
from eai.pddl.simplify import conjunction, disjunction, equality, negation, substitute
from pddl.random_pddl import atoms, formulas

MEMBERS = {"object": ("a", "b", "c"), "thing": ("a", "b")}
X, A, B = Variable("x"), Constant("a"), Constant("b")
P, Q = Atom("p", (A,)), Atom("r")


@given(st.lists(formulas((), 2), max_size=4), st.frozensets(atoms(()), max_size=8))
def test_they_mean_what_the_connectives_mean(parts: list[Formula], state: frozenset[Atom]) -> None:
    def holds(formula: Formula) -> bool:
        return Evaluation(state, DerivedPredicates(()), MEMBERS).holds(formula, {})

    assert holds(conjunction(parts)) == all(map(holds, parts))
    assert holds(disjunction(parts)) == any(map(holds, parts))
    assert all(holds(negation(part)) != holds(part) for part in parts)


@given(formulas(("x",), 2), st.frozensets(atoms(()), max_size=8))
def test_substitution_is_binding(formula: Formula, state: frozenset[Atom]) -> None:
    evaluation = Evaluation(state, DerivedPredicates(()), MEMBERS)
    assert evaluation.holds(substitute(formula, {"x": B}), {}) == evaluation.holds(formula, {"x": "b"})


def test_what_is_plain_is_left_out() -> None:
    assert conjunction([TRUE, P, And((P, Q))]) == And((P, Q))
    assert conjunction([P, Not(P)]) == FALSE
    assert disjunction([P, Q, Not(Q)]) == TRUE
    assert disjunction([FALSE, P]) == P
    assert (negation(Not(P)), negation(TRUE), negation(FALSE)) == (P, FALSE, TRUE)
    assert (equality(A, A), equality(A, B), equality(X, A)) == (TRUE, FALSE, Equals(X, A))
    assert disjunction([]) == Or(())
