from __future__ import annotations

import pytest

from eai.abilities.transition_modeling.counting import count_by_category
from eai.abilities.transition_modeling.task import Category
from eai.abilities.verdict import Confusion
from eai.pddl.matching import SideMatch

CATEGORIES = {
    "open": Category.OBJECT_STATES,
    "lit": Category.OBJECT_STATES,
    "inside": Category.SPATIAL_RELATIONS,
}
ONE = Confusion(1, 0, 0)


@pytest.mark.parametrize(
    ("clause", "by_clause", "by_predicate"),
    [
        ("(open ?x)", {"all": ONE, "object_states": ONE}, {"object_states": ONE}),
        (
            "(or (open ?x) (lit ?x))",  # both are of one category: it is one clause of it
            {"all": ONE, "object_states": ONE},
            {"object_states": ONE},
        ),
        (
            "(or (open ?x) (not (inside ?x ?y)))",
            {"all": ONE, "object_states": ONE, "spatial_relations": ONE},
            {"object_states": ONE, "spatial_relations": ONE},
        ),
        ("(shiny ?x)", {"all": ONE, "other": ONE}, {}),
        (
            "(or (shiny ?x) (open ?x))",
            {"all": ONE, "object_states": ONE, "other": ONE},
            {"object_states": ONE},
        ),
    ],
)
def test_a_clause_counts_once_in_every_category_of_its_predicates(
    clause: str, by_clause: dict[str, Confusion], by_predicate: dict[str, Confusion]
) -> None:
    side = SideMatch(matched=(clause,), additional=(), missing=())
    assert count_by_category([side], CATEGORIES, clauses=True) == by_clause
    assert count_by_category([side], CATEGORIES, clauses=False) == by_predicate


def test_what_is_matched_additional_and_missing_is_added_up() -> None:
    sides = [
        SideMatch(("(open ?x)",), ("(lit ?x)", "(inside ?x ?y)"), ()),
        SideMatch((), ("(lit ?x)",), ("(open ?y)",)),
    ]
    assert count_by_category(sides, CATEGORIES, clauses=True) == {
        "all": Confusion(1, 3, 1),
        "object_states": Confusion(1, 2, 1),
        "spatial_relations": Confusion(0, 1, 0),
    }
    assert count_by_category([], CATEGORIES, clauses=True) == {}
