"""What eai-eval 1.0.5 does with subgoals in every domain (reference: ``subgoal_plan.py``)."""

from __future__ import annotations

import json
import re

from eai.abilities.subgoal_decomposition.written import Unreadable
from eai.benchmarks.reference.lots import Lots
from eai.logic.formula import And, Atom, Formula, Not, Occurs, Or, Then
from eai.logic.traversal import children

_OBJECT = re.compile(r"{[^{}]*}")


def read_output(text: str) -> list[str] | Unreadable:
    """The strings of an answer's ``output``, stripped; every ``}}`` is one brace, and the first ends it."""
    found = _OBJECT.search(text.strip().replace("}}", "}"))
    if found is None:
        return Unreadable("there is no JSON object")
    try:
        output = json.loads(found[0]).get("output")
    except (ValueError, RecursionError) as error:
        return Unreadable(f"the first pair of braces holds no JSON object: {error}")
    if not isinstance(output, list) or not all(isinstance(subgoal, str) for subgoal in output):
        return Unreadable('"output" is not a list of strings')
    return [subgoal.strip() for subgoal in output]


def literals(formula: Formula, lots: Lots) -> list[Formula] | None:
    """The atoms, actions and negated ones of a formula in order; None for what is rejected at once.

    Of an ``or`` one operand is taken by lot.
    """
    if isinstance(formula, (Atom, Occurs)):
        return [formula]
    if isinstance(formula, Or):
        return literals(lots.choice(formula.operands), lots)
    if isinstance(formula, Not):
        return [formula] if _is_odd_negation(formula) else None
    if not isinstance(formula, (And, Then)):
        return None
    found: list[Formula] = []
    for part in children(formula):
        inner = literals(part, lots)
        if inner is None:
            return None
        found += inner
    return found


def _is_odd_negation(formula: Formula) -> bool:
    """Whether an atom or action is negated an odd number of times, which is rejected when it is reached."""
    odd = False
    while isinstance(formula, Not):
        formula, odd = formula.operand, not odd
    return odd and isinstance(formula, (Atom, Occurs))
