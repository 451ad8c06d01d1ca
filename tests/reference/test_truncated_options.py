"""bddl's truncated options, compared on every goal of the data set."""

from __future__ import annotations

from typing import Any

from eai.logic.options import count_options, options
from eai.reference.truncated_options import truncated_options
from logic.activities import as_list, records, universe
from logic.bddl_text import read_condition


def test_truncated_options_are_those_of_the_reference(oracle: Any) -> None:
    expected = oracle("behavior", "", "goal_options_truncated")
    for task, (goals, objects, _) in records(oracle).items():
        found = [[list(map(as_list, o)) for o in truncated_options(goal, objects)] for goal in goals]
        assert found == expected[task], task


def test_truncation_loses_options_of_large_pairings() -> None:
    formula = read_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))")
    assert len(truncated_options(formula, universe(a=4, b=4))) == 10
    assert len(truncated_options(formula, universe(a=3, b=3))) == 6


def test_truncation_loses_the_last_options_of_small_products() -> None:
    formula = read_condition("(forall (?x - a) (exists (?y - b) (in ?x ?y)))")
    objects = universe(a=2, b=2)
    missing = set(options(formula, objects)) - set(truncated_options(formula, objects))
    assert missing == set()
    assert (
        len(truncated_options(formula, universe(a=5, b=2))) < count_options(formula, universe(a=5, b=2)) == 32
    )


def test_negated_goals_choose_one_condition_of_every_option() -> None:
    formula = read_condition("(imply (or (p a) (and (q a) (r a))) (not (s a)))")
    found = [list(map(as_list, option)) for option in truncated_options(formula, universe())]
    assert found == [
        [["not", ["p", "a"]], ["not", ["q", "a"]]],
        [["not", ["p", "a"]], ["not", ["r", "a"]]],
        [["not", ["s", "a"]]],
    ]
