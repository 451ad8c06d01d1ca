from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.logic.formula import FALSE, TRUE, And, Atom, Constant, Equals, Formula, Not, Or, Variable
from eai.pddl.execute import DerivedPredicates, _ConditionEvaluatorInState
from eai.pddl.glossary import (
    PddlNamesByOriginalName,
    conjoin,
    disjoin,
    make_equality,
    negate,
    replace_variables,
)
from pddl.random_pddl import atoms, formulas


@given(st.lists(st.text(max_size=6), unique=True, max_size=20))
def test_every_name_has_its_own_and_is_found_by_it(names: list[str]) -> None:
    table = PddlNamesByOriginalName(names)
    written = [table[name] for name in names]
    assert len(set(written)) == len(names)
    assert all(re.fullmatch(r"[a-z][a-z0-9_-]*", each) for each in written)
    assert [table.find_original_name(each) for each in written] == names
    assert list(table.items()) == list(zip(names, written, strict=True))


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("on-table", "on-table"),
        ("HOLDS_RH", "holds_rh"),
        ("sofa.352", "sofa_352"),
        ("not", "x-not"),
        ("", "x-"),
    ],
)
def test_what_is_a_name_already_stays_one(name: str, written: str) -> None:
    assert PddlNamesByOriginalName()[name] == written


def test_names_that_would_be_equal_get_numbers() -> None:
    names = PddlNamesByOriginalName(["On", "on", "ON"])
    assert [names[name] for name in ("On", "on", "ON")] == ["on", "on-2", "on-3"]
    twin = PddlNamesByOriginalName(names)
    assert twin["oN"] == "on-4"
    assert "oN" not in names
    with pytest.raises(KeyError):
        names.find_original_name("off")


MEMBERS = {"object": ("a", "b", "c"), "thing": ("a", "b")}
X, A, B = Variable("x"), Constant("a"), Constant("b")
P, Q = Atom("p", (A,)), Atom("r")


@given(st.lists(formulas((), 2), max_size=4), st.frozensets(atoms(()), max_size=8))
def test_they_mean_what_the_connectives_mean(parts: list[Formula], state: frozenset[Atom]) -> None:
    def holds(formula: Formula) -> bool:
        return _ConditionEvaluatorInState(state, DerivedPredicates(()), MEMBERS).holds(formula, {})

    assert holds(conjoin(parts)) == all(map(holds, parts))
    assert holds(disjoin(parts)) == any(map(holds, parts))
    assert all(holds(negate(part)) != holds(part) for part in parts)


@given(formulas(("x",), 2), st.frozensets(atoms(()), max_size=8))
def test_substitution_is_binding(formula: Formula, state: frozenset[Atom]) -> None:
    evaluation = _ConditionEvaluatorInState(state, DerivedPredicates(()), MEMBERS)
    assert evaluation.holds(replace_variables(formula, {"x": B}), {}) == evaluation.holds(formula, {"x": "b"})


def test_what_is_plain_is_left_out() -> None:
    assert conjoin([TRUE, P, And((P, Q))]) == And((P, Q))
    assert conjoin([P, Not(P)]) == FALSE
    assert disjoin([P, Q, Not(Q)]) == TRUE
    assert disjoin([FALSE, P]) == P
    assert (negate(Not(P)), negate(TRUE), negate(FALSE)) == (P, FALSE, TRUE)
    assert (make_equality(A, A), make_equality(A, B), make_equality(X, A)) == (TRUE, FALSE, Equals(X, A))
    assert disjoin([]) == Or(())
