from __future__ import annotations

import pytest

from eai.abilities.subgoal_decomposition.rewriting import rewrite, substitute
from eai.errors import InputError
from eai.logic.formula import FALSE, Constant, Formula, Occurs, Term, Variable
from eai.logic.ltl import parse


def formula(text: str) -> Formula:
    return parse(text).formula


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
    assert substitute(formula(text), replaced) == formula(expected)


def test_a_free_variable_is_substituted_but_not_a_shadowed_one() -> None:
    quantified = formula("exists x. (p(x) and exists x. (q(x)))")
    body = getattr(quantified, "body")  # noqa: B009 - a formula of which we know the class
    assert substitute(body, {Variable("x"): Constant("a")}) == formula("p(a) and exists x. (q(x))")


def test_leaves_are_rewritten_with_the_variables_that_are_bound_there() -> None:
    seen: list[frozenset[str]] = []

    def change(leaf: object, bound: frozenset[str]) -> Formula:
        seen.append(bound)
        return FALSE

    rewrite(formula("exists x. (p(x) and forall y. (q(x, y))) or r(z)"), change)
    assert seen == [frozenset("x"), frozenset("xy"), frozenset()]


def test_other_temporal_operators_are_rejected() -> None:
    with pytest.raises(InputError, match="Always"):
        substitute(formula("always p(x)"), {})
    assert substitute(Occurs("A"), {}) == Occurs("A")
