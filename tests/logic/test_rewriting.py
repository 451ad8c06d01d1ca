from __future__ import annotations

import pytest

from eai.base.errors import InputError
from eai.logic.formula import (
    FALSE,
    Always,
    And,
    Atom,
    Constant,
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
    Term,
    Then,
    Until,
    Variable,
)
from eai.logic.ltl import parse
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import (
    rename_objects,
    rewrite_leaves,
    rewrite_state_subformulas,
    standardize_variable_names,
    substitute_terms,
)

X, Y = Variable("x", "cup"), Variable("y", "cup")
OLD, NEW, OTHER = Constant("old"), Constant("new"), Constant("other")


def formulas(thing: Constant) -> list[Formula]:
    """One formula of each kind about an object, and about a variable of its name."""
    p = Atom("p", (thing, Variable("old"), OTHER))
    return [
        p,
        Occurs("a", (thing,)),
        Equals(thing, OTHER),
        Not(p),
        Next(p),
        Eventually(p),
        Always(p),
        And((p, p)),
        Or((p,)),
        Then((p, p)),
        Implies(p, p),
        Until(p, p),
        ForAll(X, p),
        Exists(X, p),
        Exactly(2, X, p),
        ForPairs(X, Y, p, 1),
    ]


@pytest.mark.parametrize(("before", "after"), list(zip(formulas(OLD), formulas(NEW), strict=True)))
def test_objects_change_their_names_everywhere_and_variables_keep_them(
    before: Formula, after: Formula
) -> None:
    assert rename_objects(before, {"old": "new", "cup": "mug"}) == after
    assert rename_objects(before, {}) == before


def test_a_bound_variable_is_renamed_and_keeps_its_category() -> None:
    lamp = Variable("l", "lamp")
    formula = ForAll(lamp, And((Atom("lit", (lamp,)), Equals(lamp, Variable("l")))))
    assert format_ltl(standardize_variable_names(formula)) == "forall x: lamp. (lit(x) and x = x)"


def formula(text: str) -> Formula:
    return parse(text)


@pytest.mark.parametrize(
    ("text", "values", "expected"),
    [
        ("p(x) and not q(x, y)", {Constant("x"): "a.1"}, "p(a.1) and not q(a.1, y)"),
        (
            "p(x) then (q(x) or r(x) implies s(x))",
            {Constant("x"): "a"},
            "p(a) then (q(a) or r(a) implies s(a))",
        ),
        (
            "exists x. (p(x, y)) and q(x)",
            {Constant("x"): "a", Constant("y"): "b"},
            "exists x. (p(x, b)) and q(a)",
        ),
        ("forall x. (x = y)", {Constant("y"): "b"}, "forall x. (x = b)"),
        ("forn 2. y. (p(y))", {Constant("y"): "b"}, "forn 2. y. (p(y))"),
        ("forpairs x:c, y:d. (p(x, y, z))", {Constant("z"): "b"}, "forpairs x:c, y:d. (p(x, y, b))"),
    ],
)
def test_objects_are_substituted_where_no_quantifier_hides_them(
    text: str, values: dict[Term, str], expected: str
) -> None:
    replaced = {term: Constant(name) for term, name in values.items()}
    assert substitute_terms(formula(text), replaced) == formula(expected)


def test_a_free_variable_is_substituted_but_not_a_shadowed_one() -> None:
    quantified = formula("exists x. (p(x) and exists x. (q(x)))")
    body = getattr(quantified, "body")  # noqa: B009 - a formula of which we know the class
    assert substitute_terms(body, {Variable("x"): Constant("a")}) == formula("p(a) and exists x. (q(x))")


def test_leaves_are_rewritten_with_the_variables_that_are_bound_there() -> None:
    seen: list[frozenset[str]] = []

    def change(leaf: object, bound: frozenset[str]) -> Formula:
        seen.append(bound)
        return FALSE

    rewrite_leaves(formula("exists x. (p(x) and forall y. (q(x, y))) or r(z)"), change)
    assert seen == [frozenset("x"), frozenset("xy"), frozenset()]


def test_other_temporal_operators_are_rejected() -> None:
    with pytest.raises(InputError, match="Always"):
        substitute_terms(formula("always p(x)"), {})
    assert substitute_terms(Occurs("A"), {}) == Occurs("A")


def test_in_a_temporal_formula_the_largest_state_formulas_are_changed() -> None:
    parts = []

    def change(part: Formula) -> Formula:
        parts.append(part)
        return rename_objects(part, {"old": "new"})

    def over_time(thing: Constant) -> Formula:
        return And((Eventually(And((Atom("p", (thing,)), Atom("q", (OTHER,))))), Always(Atom("r", (thing,)))))

    assert rewrite_state_subformulas(over_time(OLD), change) == over_time(NEW)
    assert len(parts) == 2
    with pytest.raises(InputError, match="a temporal operator stands inside a quantifier"):
        rewrite_state_subformulas(Exists(X, Eventually(Atom("p", (X,)))), change)
