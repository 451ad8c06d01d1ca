"""Counts of usual goals and actions in the tasks of a benchmark."""

from __future__ import annotations

from eai.benchmarks.generator.census import _combine_predicates_with_all_categories
from eai.benchmarks.generator.usual_goals import LiteralPattern
from eai.world import Predicate, Scene, Vocabulary, WorldObject


def test_without_plans_every_literal_of_goals_is_usual_for_every_category() -> None:
    vocabulary = Vocabulary((Predicate("on", 2), Predicate("lit", 1), Predicate("raining", 0)))
    objects = [WorldObject("lamp_1", "lamp"), WorldObject("lamp_2", "lamp"), WorldObject("desk", "desk")]
    state = Scene(vocabulary, objects, None).state([])
    wanted = [("on", True), ("lit", False), ("raining", True)]
    kinds = ("lamp", "desk")
    assert list(_combine_predicates_with_all_categories(wanted, [state])) == [
        *(LiteralPattern("on", (one, other), True) for one in kinds for other in kinds),
        *(LiteralPattern("lit", (kind,), False) for kind in kinds),
        LiteralPattern("raining", (), True),
    ]
