"""Formulas on traces: examples of the definitions, and agreement with the naive evaluator."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.base.errors import InputError
from eai.logic.formula import (
    Always,
    And,
    Atom,
    Equals,
    Eventually,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Next,
    Not,
    Occurs,
    Or,
    Then,
    Until,
    Variable,
)
from eai.logic.ltl import parse, read_formula
from eai.logic.semantics import (
    _ViolatedSubformula,
    explain_truth,
    find_possible_values_of_variable,
    find_violation,
    holds,
)
from eai.logic.signature import FormulaSignature
from eai.logic.trace import TakenAction, Trace
from logic.naive import Facts, Naive
from logic.random_formulas import SCENE, formulas, trace, traces
from sweeps import examples


@given(formulas(), traces())
@settings(max_examples=examples(250), deadline=None)
def test_formulas_agree_with_the_naive_evaluator(
    formula: Formula, given_: tuple[list[Facts], list[TakenAction]]
) -> None:
    states, actions = given_
    expected = Naive(tuple(states), tuple(actions)).on(formula, 0, len(states) - 1, {})
    trace = Trace(states, actions)
    assert holds(formula, trace) == expected
    evidence = explain_truth(formula, trace)
    assert evidence.holds == expected
    assert bool(evidence.failed) != expected


def sequences() -> st.SearchStrategy[Formula]:
    """Return a strategy for formulas with a complex operand before ``then``."""
    x, y = Variable("x"), Variable("y", "cup")
    some_open = Exists(x, Atom("open", (x,)))
    leaves: st.SearchStrategy[Formula] = st.sampled_from(
        [Atom("-raining"), Not(Atom("-raining")), Occurs("sleep"), some_open]
    )

    def larger(part: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
        pairs = st.tuples(part, part)
        return st.one_of(
            pairs.map(Then),
            pairs.map(And),
            pairs.map(Or),
            pairs.map(lambda both: Until(*both)),
            pairs.map(lambda both: Implies(*both)),
            part.map(Not),
            part.map(Always),
            part.map(Eventually),
            part.map(Next),
            part.map(lambda body: ForAll(y, body)),
            part.map(lambda body: Exactly(1, y, body)),
        )

    part: st.SearchStrategy[Formula] = st.recursive(leaves, larger, max_leaves=6)
    return st.lists(part, min_size=2, max_size=3).map(tuple).map(Then)


@given(sequences(), traces())
@settings(max_examples=examples(250), deadline=None)
def test_sequences_agree_with_the_naive_evaluator(
    formula: Formula, given_: tuple[list[Facts], list[TakenAction]]
) -> None:
    states, actions = given_
    expected = Naive(tuple(states), tuple(actions)).on(formula, 0, len(states) - 1, {})
    assert holds(formula, Trace(states, actions)) == expected


def check(text: str, on: Trace) -> bool:
    return holds(read_formula(text, FormulaSignature({}, {"GRAB": 0, "PUT": 0}))[0], on)


def test_a_state_formula_holds_if_it_holds_at_some_point() -> None:
    path = trace("p", "GRAB", "q", "PUT", "")
    assert check("p()", path)
    assert check("q()", path)
    assert not check("p() and q()", path)
    assert check("not p()", path)


def test_an_action_belongs_to_the_state_before_its_effects() -> None:
    path = trace("p", "GRAB", "q", "PUT", "r")
    assert check("p() and GRAB()", path)
    assert not check("q() and GRAB()", path)
    assert check("q() then r()", path)
    assert not check("GRAB() then p()", path)
    assert check("GRAB() then PUT()", path)
    assert not check("PUT() then GRAB()", path)


def test_then_needs_a_later_position() -> None:
    assert not check("p() then p()", trace("p"))
    assert check("p() then p()", trace("p", "GRAB", "p"))
    assert not check("p() then q()", trace("q", "GRAB", "p"))


def test_a_nested_then_continues_after_its_completion() -> None:
    path = trace("p", "GRAB", "q", "GRAB", "r")
    assert check("(p() then q()) then r()", path)
    assert check("p() then (q() then r())", path)
    assert not check("(p() then r()) then q()", path)


def test_conjunctions_with_then_hold_on_the_same_trace() -> None:
    path = trace("p", "GRAB", "q", "GRAB", "r", "GRAB", "p")
    assert check("(p() then q()) and (q() then r())", path)
    assert check("((p() then q()) and (q() then r())) then p()", path)
    assert not check("((p() then q()) and (q() then p())) then r()", path)
    assert check("(not (r() then q())) then p()", path)


def test_an_operand_before_then_may_end_at_any_position() -> None:
    path = trace("p", "GRAB", "q", "GRAB", "r")
    assert check("(not (p() then q())) then r()", path)
    assert check("(not (p() then q())) then q()", path)
    assert not check("(not (p() then q())) then p()", path)
    assert check("((not (p() then q())) and (GRAB() or p())) then q() then r()", path)
    assert not check("(not (p() then q()) and (p() then p() or q())) then r()", path)
    assert check("(always p() or always (q() or p())) then r()", path)


@pytest.mark.parametrize(
    "text",
    [
        "(always p() and next q()) then p()",
        "(always p() or next q()) then q()",
        "(eventually (p() and always q())) then p()",
        "(p() until always q()) then p() then q()",
        "(not (p() then q()) and (p() then p() or q())) then q()",
        Then((Not(Then(())), Atom("p"))),
        Then((Always(Then(())), Atom("p"))),
    ],
)
def test_operands_without_monotony_agree_with_the_naive_evaluator(text: str | Formula) -> None:
    formula = parse(text) if isinstance(text, str) else text
    states = [frozenset((name, ()) for name in names) for names in ((), ("p",), ("q",), ("p", "q"))]
    for length in range(1, 5):
        for each in product(states, repeat=length):
            facts, actions = [Facts(true, SCENE) for true in each], [("GRAB", ())] * (length - 1)
            expected = Naive(tuple(facts), tuple(actions)).on(formula, 0, length - 1, {})
            assert holds(formula, Trace(facts, actions)) == expected


def test_operators_beyond_the_paper_are_about_positions() -> None:
    path = trace("p", "GRAB", "p q", "GRAB", "r")
    assert check("next q()", path)
    assert not check("next r()", path)
    assert not check("next next next true", path)
    assert check("p() until r()", path)
    assert not check("p() until q() and always p()", path)
    assert check("always (p() or r())", path)
    assert check("always (q() implies next r())", path)
    assert check("(always p()) then r()", path)
    assert not check("always p()", path)


@pytest.mark.parametrize("count", range(5))
def test_forn_means_exactly_that_many_objects(count: int) -> None:
    state = Facts(frozenset({("open", ("cup.1",)), ("open", ("sofa",))}), SCENE)
    formula = parse(f"forn {count} x. (open(x))")
    assert holds(formula, Trace([state])) == (count == 2)


def test_pairs_may_be_made_at_any_position() -> None:
    x, y = Variable("x", "cup"), Variable("y", "bottle.n.01")
    paired = ForPairs(x, y, Atom("in", (x, y)))
    empty, full = Facts(frozenset(), SCENE), Facts(frozenset([("in", ("cup.2", "sofa"))]), SCENE)
    assert holds(paired, Trace([empty, full], [("GRAB", ())]))
    assert not holds(Then((paired, paired)), Trace([empty, full], [("GRAB", ())]))
    assert not holds(paired, Trace([empty, empty], [("GRAB", ())]))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("forall x: nothing. (p())", True),
        ("exists x: nothing. (not p())", False),
        ("forn 0 x: nothing. (p())", True),
        ("forn 1 x: nothing. (p())", False),
        ("forpairs x: nothing, y. (p())", True),
        ("fornpairs 1 x: nothing, y. (p())", False),
        ("not forall x: nothing. (p() then p())", False),
    ],
)
def test_quantifiers_over_an_empty_category_have_their_usual_truth(text: str, expected: bool) -> None:
    assert check(text, trace("p", "GRAB", "")) == expected


def test_unbound_variables_are_an_error() -> None:
    unbound = Atom("open", (Variable("x"),))
    with pytest.raises(InputError, match="variable x is not bound"):
        holds(And((Exists(Variable("x"), unbound), unbound)), trace("p"))


def test_shadowed_variables_take_the_inner_value() -> None:
    state = Facts(frozenset({("open", ("sofa",))}), SCENE)
    assert check("forall x: cup. (exists x. (open(x)))", Trace([state]))
    assert not check("exists x. (open(x) and forall x. (open(x)))", Trace([state]))


def test_evaluation_is_fast_with_many_objects_and_few_actions() -> None:
    names = tuple((f"o.{i}", "thing") for i in range(2000))
    path = Trace([Facts(frozenset(), names)] * 2, [("POUR", ("o.7", "o.9"))])
    signature = FormulaSignature({}, {"POUR": 2})
    assert holds(read_formula("exists x. (exists y. (POUR(x, y)))", signature)[0], path)
    assert not holds(read_formula("exists x. (POUR(x, x))", signature)[0], path)
    assert holds(read_formula("forn 1 x. (exists y. (POUR(x, y)))", signature)[0], path)


PATH = Trace(
    [Facts(frozenset(), SCENE)] * 4,
    [("POUR", ("a", "b")), ("POUR", ("c", "b")), ("GRAB", ("a",))],
)


def taken(leaf: Atom | Occurs, place: int, binding: Mapping[str, str]) -> frozenset[str] | None:
    return PATH.find_values_of_argument(leaf.action, place) if isinstance(leaf, Occurs) else None


@pytest.mark.parametrize(
    ("text", "true", "false"),
    [
        ("POUR(x, b)", {"a", "c"}, None),
        ("not POUR(x, b)", None, {"a", "c"}),
        ("POUR(x, b) and GRAB(x)", {"a"}, None),
        ("POUR(x, b) or GRAB(x)", {"a", "c"}, None),
        ("POUR(x, b) or open(x)", None, None),
        ("POUR(x, b) implies open(x)", None, {"a", "c"}),
        ("x = sofa", {"sofa"}, None),
        ("exists y. (POUR(x, y))", {"a", "c"}, None),
        ("forall y. (not POUR(x, y))", None, {"a", "c"}),
        ("forall y. (POUR(x, y))", None, None),
        ("exists x. (POUR(x, b))", None, None),
        ("exists y. (x = y)", None, None),
        ("next POUR(x, b)", {"a", "c"}, None),
        ("eventually not POUR(x, b)", None, {"a", "c"}),
        ("open(x) until GRAB(x)", {"a"}, None),
        ("GRAB(x) then open(x)", {"a"}, None),
    ],
)
def test_the_support_of_a_variable_is_found_from_the_shape_of_the_formula(
    text: str, true: set[str] | None, false: set[str] | None
) -> None:
    quantified = read_formula(f"exists x. ({text})", FormulaSignature({"open": 1}, {"POUR": 2, "GRAB": 1}))[0]
    assert isinstance(quantified, Exists)
    assert find_possible_values_of_variable(quantified.body, "x", {}, True, taken) == (
        None if true is None else frozenset(true)
    )
    assert find_possible_values_of_variable(quantified.body, "x", {}, False, taken) == (
        None if false is None else frozenset(false)
    )


def test_an_equation_with_a_bound_variable_supports_one_object() -> None:
    equation = Equals(Variable("x"), Variable("y"))
    assert find_possible_values_of_variable(equation, "x", {"y": "cup.1"}, True, taken) == frozenset(
        {"cup.1"}
    )


P, Q, R = Atom("p"), Atom("q"), Atom("r")


@given(formulas(temporal=False), traces())
@settings(max_examples=examples(100), deadline=None)
def test_evidence_of_a_state_formula_is_the_positions_at_which_it_holds(
    formula: Formula, given_: tuple[list[Facts], list[TakenAction]]
) -> None:
    states, actions = given_
    naive = Naive(tuple(states), tuple(actions))
    last = len(states) - 1
    expected = tuple(i for i in range(len(states)) if naive.at(formula, i, last, {}))
    assert explain_truth(formula, Trace(states, actions)).positions == expected


def test_evidence_names_the_conjuncts_that_never_hold() -> None:
    path = trace("p", "GRAB", "q")
    assert explain_truth(And((P, R, Not(Or((P, Q))))), path).failed == (R, Not(Or((P, Q))))
    assert explain_truth(And((P, And((Q, R)))), path).failed == (R,)


def test_a_conjunction_whose_conjuncts_never_hold_together_is_to_blame() -> None:
    assert explain_truth(And((P, Q)), trace("p", "GRAB", "q")).failed == (And((P, Q)),)


def test_evidence_of_then_is_the_completed_positions() -> None:
    path = trace("", "GRAB", "p", "GRAB", "q", "GRAB", "p")
    complete = explain_truth(Then((P, Q, P)), path)
    assert (complete.holds, complete.positions, complete.failed) == (True, (1, 2, 3), ())
    partial = explain_truth(Then((P, And((Q, R)), P)), path)
    assert (partial.holds, partial.positions, partial.failed) == (False, (1,), (R,))
    late = explain_truth(Then((P, Q, P, P)), path)
    assert (late.holds, late.positions, late.failed) == (False, (1, 2, 3), (P,))


def test_a_part_of_then_after_the_last_position_is_to_blame_as_a_whole() -> None:
    assert explain_truth(Then((P, And((Q, R)))), trace("p")).failed == (And((Q, R)),)


def test_a_temporal_part_is_completed_as_early_as_possible() -> None:
    path = trace("", "GRAB", "p", "GRAB", "", "GRAB", "p", "GRAB", "q")
    assert explain_truth(Then((P, Next(P), Q)), path).positions == (1, 3, 4)


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        (And((Eventually(P), R)), _ViolatedSubformula(R, None)),
        (And((Eventually(R), Always(P))), _ViolatedSubformula(Eventually(R), None)),
        (And((Eventually(Q), Always(P))), _ViolatedSubformula(P, 2)),
        (And((Next(Q), R)), _ViolatedSubformula(Next(Q), None)),
        (Always(Or((P, Q))), _ViolatedSubformula(Or((P, Q)), 3)),
        (Until(P, R), _ViolatedSubformula(P, 2)),
        (Until(Not(R), R), _ViolatedSubformula(R, None)),
        (And((And((P, Q)), Eventually(P))), _ViolatedSubformula(And((P, Q)), None)),
    ],
)
def test_a_violation_has_its_part_and_its_position(formula: Formula, expected: _ViolatedSubformula) -> None:
    assert find_violation(formula, trace("p", "GRAB", "p", "GRAB", "q", "GRAB", "")) == expected
