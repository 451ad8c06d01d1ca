"""The rules of a domain in formulas reveal no hidden predicate."""

from __future__ import annotations

import eai.world as w
from eai.tasks.rules import DomainRulesInPrompts

x = w.Variable("x")
lit, used = w.Predicate("lit", 1), w.Predicate("used", 1, visible=False)
ready, worn = w.DefinedPredicate("ready", (x,), ~lit(x)), w.DefinedPredicate("worn", (x,), used(x) & lit(x))


def test_definitions_that_read_memory_are_left_out() -> None:
    press = w.Operator("PRESS", (x,), (), (w.Add(lit(x)), w.Add(used(x))))
    rules = DomainRulesInPrompts(w.Domain("lamps", w.Vocabulary((lit, used), (ready, worn)), (press,)))
    assert rules.write_predicate_definitions() == ["ready(x) means: not lit(x)"]
    assert "used" not in rules.write_rules(["PRESS"])
