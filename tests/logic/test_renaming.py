from __future__ import annotations

import pytest

from eai.logic.formula import (
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
    Then,
    Until,
    Variable,
)
from eai.logic.ltl_printer import print_ltl
from eai.logic.renaming import rename_objects, rename_variables

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


def test_a_variable_is_renamed_where_it_stands_with_its_category() -> None:
    lamp = Variable("l", "lamp")
    formula = ForAll(lamp, And((Atom("lit", (lamp,)), Equals(lamp, Variable("l")))))
    assert print_ltl(rename_variables(formula)) == "forall x: lamp. (lit(x) and x = x)"
