"""BEHAVIOR's goals as in the reference's records, for tests that compare options."""

from __future__ import annotations

from typing import Any

from eai.logic.choice import Literal, ObjectsByCategory
from eai.logic.formula import Atom, Formula, Not
from logic.bddl_text import read_condition
from logic.naive import Facts


def as_list(literal: Literal) -> list[Any]:
    if isinstance(literal, Not):
        assert isinstance(literal.operand, (Atom, Not))
        return ["not", as_list(literal.operand)]
    assert isinstance(literal, Atom)
    return [literal.predicate, *(term.name for term in literal.arguments)]


def as_text(tree: list[Any] | str) -> str:
    return tree if isinstance(tree, str) else f"({' '.join(map(as_text, tree))})"


def records(oracle: Any) -> dict[str, tuple[list[Formula], ObjectsByCategory, int]]:
    """Return the goals, the objects and the reference's number of goal options of each task."""
    found = {}
    for task, record in oracle("behavior", "", "reconstructed").items():
        goals = [read_condition(as_text(goal)) for goal in record["bddl_goal"]]
        objects = tuple((thing["bddl_instance"], thing["category"]) for thing in record["objects"])
        found[task] = (goals, Facts(frozenset(), objects).list_objects, record["n_goal_options"])
    return found


def universe(**sizes: int) -> Facts:
    return Facts(
        frozenset(), tuple((f"{kind}{i}", kind) for kind, size in sizes.items() for i in range(size))
    )
