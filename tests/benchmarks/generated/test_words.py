"""Instructions say exactly the goals: each sentence in a table, and read again."""

from __future__ import annotations

import random

import pytest

import eai.logic.formula as f
from benchmarks.generated.worlds import HOUSEHOLDS, tasks
from eai.benchmarks.generated.reader import Reader
from eai.benchmarks.generated.spec import Forms
from eai.benchmarks.generated.words import Words, plural
from eai.benchmarks.registry import find_benchmark
from eai.errors import InputError
from eai.logic.ltl import parse
from eai.logic.signature import Signature
from eai.world import Predicate, Scene, Vocabulary, WorldObject

THINGS = {
    "me": "robot",
    "cup_1": "cup",
    "cup_2": "cup",
    "shelf_1": "shelf.n.01",
    "box_1": "gift_box",
    "box_2": "gift_box",
    "lamp_1": "lamp",
}
ARITIES = {"is_clean": 1, "ON": 1, "inside": 2, "on_top": 2, "holds": 2}
WORDS = Words(
    ARITIES,
    Scene(
        Vocabulary(tuple(Predicate(name, arity) for name, arity in ARITIES.items())),
        [WorldObject(name, category) for name, category in THINGS.items()],
    ),
    {"ON": "{x} is switched on", "on_top": "{x} is on top of {y}"},
)

CASES = [
    ("ON(lamp_1)", "the lamp is switched on"),
    ("not ON(lamp_1)", "the lamp is not switched on"),
    ("is_clean(cup_1)", "cup_1 is clean"),
    ("inside(cup_1, shelf_1)", "cup_1 is inside the shelf"),
    ("holds(me, cup_2)", "the robot holds cup_2"),
    ("not holds(me, cup_2)", "the robot does not hold cup_2"),
    ("forall x: cup. (is_clean(x))", "every cup is clean"),
    ("forall x: cup. (not is_clean(x))", "no cup is clean"),
    ("forall x: cup. (inside(x, box_1))", "every cup is inside box_1"),
    ("forall x: cup. (exists y: gift_box. (inside(x, y)))", "every cup is inside some gift box"),
    ("forpairs x: cup, y: gift_box. (inside(x, y))", "every cup is inside a gift box of its own"),
    ("exists x: cup. (on_top(x, shelf_1))", "at least one cup is on top of the shelf"),
    ("exists x: cup. (not is_clean(x))", "at least one cup is not clean"),
    ("forn 1. x: cup. (is_clean(x))", "exactly one cup is clean"),
    ("forn 2. x: gift_box. (inside(x, shelf_1))", "exactly two gift boxes are inside the shelf"),
    ("is_clean(cup_1) or inside(cup_1, box_2)", "either cup_1 is clean or cup_1 is inside box_2"),
    ("GRAB() or TOUCH()", "the action GRAB or TOUCH has been taken"),
]


def formula(text: str) -> f.Formula:
    return parse(text, Signature(ARITIES, {"GRAB": None, "TOUCH": None})).formula


@pytest.mark.parametrize(("text", "sentence"), CASES)
def test_each_goal_has_a_sentence_that_says_it(text: str, sentence: str) -> None:
    goal = formula(text)
    assert WORDS.clause(goal) == sentence
    assert Reader(WORDS).goals(f"Make sure that {sentence}.") == (goal,)


@pytest.mark.parametrize("number", [1, 2, 3, 5])
def test_several_goals_are_joined(number: int) -> None:
    goals = [formula(text) for text, _ in CASES[:number]]
    for seed in range(6):
        text = WORDS.instruction(goals, random.Random(seed))
        assert Reader(WORDS).goals(text) == tuple(goals)


@pytest.mark.parametrize(
    "text",
    [
        "the lamp is switched on.",
        "Make sure that the lamp is switched on",
        "Make sure that the lamp is blue.",
        "Make sure that every lamb is clean.",
        "Make sure that exactly two cup are clean.",
        "Make sure that the cup is clean.",
    ],
)
def test_what_says_no_goal_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        Reader(WORDS).goals(text)


def test_a_goal_without_sentence_is_refused() -> None:
    with pytest.raises(InputError, match="no sentence for Implies"):
        WORDS.clause(f.Implies(f.TRUE, f.FALSE))


@pytest.mark.parametrize(
    ("noun", "nouns"),
    [
        ("cup", "cups"),
        ("box", "boxes"),
        ("berry", "berries"),
        ("knife", "knives"),
        ("shelf", "shelves"),
        ("key", "keys"),
    ],
)
def test_plurals(noun: str, nouns: str) -> None:
    assert plural(noun) == nouns


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("like", HOUSEHOLDS)
@pytest.mark.parametrize("forms", Forms)
def test_instructions_give_the_goals_back(like: str, forms: Forms) -> None:
    benchmark = find_benchmark(like)
    for each in tasks(like, 40, forms):
        goals = Reader(Words.of(benchmark, each.task.initial)).goals(each.task.instruction)
        assert goals == tuple(goal.formula for goal in each.task.goals)


def test_things_are_told_by_their_places() -> None:
    """What only one of its kind is to a thing that is the only one of its own; else by their names."""
    benchmark = find_benchmark("behavior")
    told = 0
    for each in tasks("behavior"):
        words = Words.of(benchmark, each.task.initial, by_place=True)
        goals = [goal.formula for goal in each.task.goals]
        instruction = words.instruction(goals, random.Random(0))
        try:
            assert Reader(words).goals(instruction) == tuple(goals)
        except InputError as error:  # such a task is not made
            assert "one meaning" in str(error)  # noqa: PT017
        told += " that is " in instruction
    assert told
