"""Evidence: where a formula holds, or which part is to blame."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from eai.logic.evidence import _Breach, breach, explain
from eai.logic.formula import Always, And, Atom, Eventually, Formula, Next, Not, Or, Then, Until
from eai.logic.trace import TakenAction, Trace
from logic.naive import Facts, Naive
from logic.random_formulas import formulas, trace, traces
from sweeps import examples

P, Q, R = Atom("p"), Atom("q"), Atom("r")


@given(formulas(temporal=False), traces())
@settings(max_examples=examples(100), deadline=None)
def test_evidence_of_a_state_formula_is_where_it_holds(
    formula: Formula, given_: tuple[list[Facts], list[TakenAction]]
) -> None:
    states, actions = given_
    naive = Naive(tuple(states), tuple(actions))
    last = len(states) - 1
    expected = tuple(i for i in range(len(states)) if naive.at(formula, i, last, {}))
    assert explain(formula, Trace(states, actions)).positions == expected


def test_evidence_names_the_conjuncts_that_never_hold() -> None:
    path = trace("p", "GRAB", "q")
    assert explain(And((P, R, Not(Or((P, Q))))), path).failed == (R, Not(Or((P, Q))))
    assert explain(And((P, And((Q, R)))), path).failed == (R,)


def test_evidence_of_conjuncts_that_hold_only_apart_is_the_conjunction() -> None:
    assert explain(And((P, Q)), trace("p", "GRAB", "q")).failed == (And((P, Q)),)


def test_evidence_of_then_is_how_far_it_went() -> None:
    path = trace("", "GRAB", "p", "GRAB", "q", "GRAB", "p")
    complete = explain(Then((P, Q, P)), path)
    assert (complete.holds, complete.positions, complete.failed) == (True, (1, 2, 3), ())
    partial = explain(Then((P, And((Q, R)), P)), path)
    assert (partial.holds, partial.positions, partial.failed) == (False, (1,), (R,))
    late = explain(Then((P, Q, P, P)), path)
    assert (late.holds, late.positions, late.failed) == (False, (1, 2, 3), (P,))


def test_of_what_comes_after_the_end_all_is_to_blame() -> None:
    assert explain(Then((P, And((Q, R)))), trace("p")).failed == (And((Q, R)),)


def test_a_part_about_time_is_completed_as_early_as_possible() -> None:
    path = trace("", "GRAB", "p", "GRAB", "", "GRAB", "p", "GRAB", "q")
    assert explain(Then((P, Next(P), Q)), path).positions == (1, 3, 4)


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        (And((Eventually(P), R)), _Breach(R, None)),
        (And((Eventually(R), Always(P))), _Breach(Eventually(R), None)),
        (And((Eventually(Q), Always(P))), _Breach(P, 2)),
        (And((Next(Q), R)), _Breach(Next(Q), None)),
        (Always(Or((P, Q))), _Breach(Or((P, Q)), 3)),
        (Until(P, R), _Breach(P, 2)),
        (Until(Not(R), R), _Breach(R, None)),
        (And((And((P, Q)), Eventually(P))), _Breach(And((P, Q)), None)),
    ],
)
def test_what_is_violated_and_where(formula: Formula, expected: _Breach) -> None:
    assert breach(formula, trace("p", "GRAB", "p", "GRAB", "q", "GRAB", "")) == expected
