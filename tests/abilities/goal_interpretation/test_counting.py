from __future__ import annotations

from collections import Counter
from itertools import permutations

from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.goal_interpretation.counting import (
    confusion,
    count_alternatives,
    count_up_to_renaming,
    match_alternatives,
)
from eai.abilities.verdict import Confusion

GOALS = st.lists(st.sampled_from("abc"), max_size=5)


def test_a_confusion_has_what_is_matched_what_is_too_much_and_what_is_missing() -> None:
    assert confusion(2, 5, 3) == Confusion(2, 3, 1)


def test_a_goal_said_twice_matches_two_of_its_kind() -> None:
    assert count_up_to_renaming(Counter("aa"), Counter("aab"), {"a": 2}) == Confusion(2, 0, 1)


def test_a_goal_said_more_often_than_there_are_objects_is_mere_repetition() -> None:
    assert count_up_to_renaming(Counter("aaaa"), Counter("a"), {"a": 2}) == Confusion(1, 1, 0)
    assert count_up_to_renaming(Counter("aaaa"), Counter("a"), {"a": 1}) == Confusion(1, 0, 0)


def test_a_goal_about_nothing_that_exists_is_a_false_positive() -> None:
    assert count_up_to_renaming(Counter("aab"), Counter("b"), {"a": 0, "b": 1}) == Confusion(1, 1, 0)


def test_a_goal_with_alternatives_is_met_once() -> None:
    assert count_alternatives(["GRAB", "WIPE", "WASH"], [("GRAB",), ("WASH", "WIPE")]) == Confusion(2, 1, 0)


@given(GOALS, GOALS)
def test_without_repetition_the_counts_are_those_of_multisets(predicted: list[str], gold: list[str]) -> None:
    counts = count_up_to_renaming(Counter(predicted), Counter(gold), dict.fromkeys("abc", 9))
    both = (Counter(predicted) & Counter(gold)).total()
    assert counts == Confusion(both, len(predicted) - both, len(gold) - both)


@given(
    st.lists(st.sampled_from("abc"), max_size=3, unique=True),
    st.lists(st.sets(st.sampled_from("abc"), min_size=1), max_size=3),
)
def test_as_many_alternatives_are_matched_as_any_assignment_can(
    predicted: list[str], gold: list[set[str]]
) -> None:
    orders = permutations([*gold, *[set[str]()] * len(predicted)], len(predicted))
    best = max(sum(p in g for p, g in zip(predicted, order, strict=True)) for order in orders)
    assert len(match_alternatives(predicted, gold)) == best
