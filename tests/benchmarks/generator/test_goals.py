"""Goals proposed for small scenes, one shape at a time, by a hand-written prior."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import replace

import pytest

import eai.logic.formula as f
from benchmarks.generator.worlds import NOTHING_IS_USUAL
from eai.benchmarks.generator.goals import GoalSampler
from eai.benchmarks.generator.usual_goals import LiteralPattern, UsualGoalsOfDataSet
from eai.world import Predicate, Scene, Vocabulary, WorldObject

PUT = LiteralPattern("inside", ("cup", "box"), True)
CLEAN, DIRTY = LiteralPattern("clean", ("cup",), True), LiteralPattern("clean", ("cup",), False)
VOCABULARY = Vocabulary((Predicate("inside", 2), Predicate("clean", 1)))
DRAWN = 60


def prior(
    patterns: Mapping[LiteralPattern, int], forms: Mapping[str, int], several: frozenset[str]
) -> UsualGoalsOfDataSet:
    by_key: dict[tuple[str, bool], dict[LiteralPattern, float]] = {}
    for pattern, weight in patterns.items():
        by_key.setdefault((pattern.predicate, pattern.truth), {})[pattern] = weight
    wanted = {key: int(sum(known.values())) for key, known in by_key.items()}
    return replace(
        NOTHING_IS_USUAL,
        patterns=by_key,
        goal_counts=wanted,
        shape_counts=forms,
        countable_categories=several,
    )


def drawn(
    things: Mapping[str, int],
    patterns: Mapping[LiteralPattern, int],
    *shapes: str,
    several: frozenset[str] = frozenset(),
) -> set[f.Formula]:
    """Return all goals of some shapes that are drawn for a scene with these numbers of objects."""
    objects = [WorldObject(f"{kind}_{n}", kind) for kind, number in things.items() for n in range(number)]
    known = prior(patterns, dict.fromkeys(shapes, 1), several)
    proposals = GoalSampler.make_goal_sampler_for_scene(
        Scene(VOCABULARY, objects, None), known, "data", actions=False
    )
    rng = random.Random(0)
    return {goal for goal in (proposals.draw_goal(rng) for _ in range(DRAWN)) if goal is not None}


@pytest.mark.parametrize(
    ("cups", "boxes", "is_made"), [(1, 2, False), (2, 1, False), (2, 2, True), (2, 3, True), (3, 2, False)]
)
def test_pairs_are_of_two_things_or_more_each_with_one_of_its_own(
    cups: int, boxes: int, is_made: bool
) -> None:
    pairs = f.ForPairs(
        f.Variable("x", "cup"), f.Variable("y", "box"), f.Atom("inside", (f.Variable("x"), f.Variable("y")))
    )
    made = drawn({"cup": cups, "box": boxes}, {PUT: 1}, "Atom", "ForPairs")
    assert (pairs in made) is is_made
    assert all(isinstance(goal, f.Atom) or goal == pairs for goal in made)


@pytest.mark.parametrize(("cups", "numbers"), [(2, {1}), (3, {1, 2}), (6, {1, 2, 3, 4})])
def test_exact_counts_are_below_all_and_at_most_four(cups: int, numbers: set[int]) -> None:
    made = drawn({"cup": cups}, {CLEAN: 1}, "Exactly")
    assert made == {
        f.Exactly(number, f.Variable("x", "cup"), f.Atom("clean", (f.Variable("x"),))) for number in numbers
    }


def test_quantifiers_range_over_categories_with_several_objects() -> None:
    body = f.Atom("clean", (f.Variable("x"),))
    assert drawn({"cup": 2}, {CLEAN: 1}, "ForAll") == {f.ForAll(f.Variable("x", "cup"), body)}
    assert drawn({"cup": 2}, {CLEAN: 1}, "Exists") == {f.Exists(f.Variable("x", "cup"), body)}
    one = {f.Atom("clean", (f.Constant("cup_0"),))}
    assert drawn({"cup": 1}, {CLEAN: 1}, "Atom", "ForAll", "Exists", "Exactly") == one
    others = frozenset({"plate"})
    assert drawn({"cup": 2}, {CLEAN: 1}, "Atom", "ForAll", several=others) == {
        f.Atom("clean", (f.Constant(f"cup_{n}"),)) for n in range(2)
    }
    assert len(drawn({"cup": 2}, {CLEAN: 1}, "Atom", "ForAll", several=frozenset({"cup"}))) == 3


def test_negated_goals_are_usual_as_false() -> None:
    not_clean = f.Not(f.Atom("clean", (f.Constant("cup_0"),)))
    assert drawn({"cup": 1}, {CLEAN: 1, DIRTY: 1}, "Not") == {not_clean}
    assert drawn({"cup": 1}, {CLEAN: 1}, "Not") == set()
    assert f.ForAll(f.Variable("x", "cup"), f.Not(f.Atom("clean", (f.Variable("x"),)))) in drawn(
        {"cup": 2}, {CLEAN: 1, DIRTY: 1}, "ForAll"
    )


def test_some_of_several_places_may_be_one_for_each() -> None:
    x, y = f.Variable("x"), f.Variable("y")
    anywhere = f.Exists(f.Variable("y", "box"), f.Atom("inside", (x, y)))
    made = drawn({"cup": 2, "box": 2}, {PUT: 1}, "ForAll")
    assert made == {
        f.ForAll(f.Variable("x", "cup"), body)
        for body in (anywhere, *(f.Atom("inside", (x, f.Constant(f"box_{n}"))) for n in range(2)))
    }
    assert len(drawn({"cup": 2, "box": 1}, {PUT: 1}, "ForAll")) == 1


def test_one_of_two_places_is_of_the_same_thing_and_of_different_others() -> None:
    made = drawn({"cup": 2, "box": 2}, {PUT: 1, CLEAN: 1}, "Or")
    boxes = [("box_0", "box_1"), ("box_1", "box_0")]
    assert made == {
        f.Or(tuple(f.Atom("inside", (f.Constant(f"cup_{n}"), f.Constant(box))) for box in both))
        for n in range(2)
        for both in boxes
    }
    assert drawn({"cup": 2, "box": 1}, {PUT: 1, CLEAN: 1}, "Or") == set()
