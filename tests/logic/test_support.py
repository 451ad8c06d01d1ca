"""Support: the objects that a quantifier need try."""

from __future__ import annotations

import pytest

from eai.logic.formula import (
    Equals,
    Exists,
    Variable,
)
from eai.logic.ltl import parse
from eai.logic.semantics import holds
from eai.logic.signature import Signature
from eai.logic.support import support
from eai.logic.trace import TakenAction, Trace
from logic.naive import Facts
from logic.random_formulas import SCENE


def test_many_objects_do_not_matter_to_rare_actions() -> None:
    names = tuple((f"o.{i}", "thing") for i in range(2000))
    path = Trace([Facts(frozenset(), names)] * 2, [TakenAction("POUR", ("o.7", "o.9"))])
    signature = Signature({}, {"POUR": 2})
    assert holds(parse("exists x. (exists y. (POUR(x, y)))", signature).formula, path)
    assert not holds(parse("exists x. (POUR(x, x))", signature).formula, path)
    assert holds(parse("forn 1 x. (exists y. (POUR(x, y)))", signature).formula, path)


PATH = Trace(
    [Facts(frozenset(), SCENE)] * 4,
    [TakenAction("POUR", ("a", "b")), TakenAction("POUR", ("c", "b")), TakenAction("GRAB", ("a",))],
)


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
def test_support(text: str, true: set[str] | None, false: set[str] | None) -> None:
    quantified = parse(f"exists x. ({text})", Signature({"open": 1}, {"POUR": 2, "GRAB": 1})).formula
    assert isinstance(quantified, Exists)
    assert support(quantified.body, "x", {}, True, PATH) == (None if true is None else frozenset(true))
    assert support(quantified.body, "x", {}, False, PATH) == (None if false is None else frozenset(false))


def test_an_equation_with_a_bound_variable() -> None:
    equation = Equals(Variable("x"), Variable("y"))
    assert support(equation, "x", {"y": "cup.1"}, True, PATH) == frozenset({"cup.1"})
