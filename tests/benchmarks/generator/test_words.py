"""Instructions state exactly the goals: each sentence is listed in a table, and read back."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import get_args

import pytest

import eai.logic.formula as f
from benchmarks.generator.worlds import tasks
from eai.base.errors import InputError
from eai.benchmarks.generator.spec import GoalFormFrequency
from eai.benchmarks.generator.words import InstructionWriter, _InstructionReader
from eai.benchmarks.registry import find_benchmark
from eai.logic.ltl import read_formula
from eai.logic.signature import FormulaSignature
from eai.tasks.english import EnglishWords, PhraseStyle, pluralize
from eai.world import Predicate, Scene, Vocabulary, WorldObject
from eai.world.state import Fact
from sweeps import swept

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
WORDS = InstructionWriter(
    ARITIES,
    Scene(
        Vocabulary(tuple(Predicate(name, arity) for name, arity in ARITIES.items())),
        [WorldObject(name, category) for name, category in THINGS.items()],
        agent=0,
    ),
    EnglishWords(
        says={"ON": ["{x} is switched on", "{x} is turned on"], "on_top": ["{x} is on top of {y}"]},
        asks={"ON": ["switch {x} on", "turn {x} on"], "inside": ["put {x} inside {y}", "put {x} into {y}"]},
        denies={"ON": ["switch {x} off"], "inside": ["take {x} out of {y}"]},
    ),
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


ASKED = PhraseStyle(0, True)
REQUESTED = [
    ("ON(lamp_1)", ASKED, "switch the lamp on"),
    ("ON(lamp_1)", PhraseStyle(1, True), "turn the lamp on"),
    ("ON(lamp_1)", PhraseStyle(1), "the lamp is turned on"),
    ("not ON(lamp_1)", PhraseStyle(1, True), "switch the lamp off"),
    ("is_clean(cup_1)", ASKED, "see to it that cup_1 is clean"),
    ("inside(me, box_1)", ASKED, "see to it that the robot is inside box_1"),
    ("forall x: cup. (inside(x, box_1))", PhraseStyle(1, True), "put each cup into box_1"),
    ("forall x: cup. (not inside(x, box_1))", PhraseStyle(1, True), "take each cup out of box_1"),
    ("forall x: cup. (not inside(x, box_1))", PhraseStyle(1), "no cup is inside box_1"),
    ("exists x: cup. (not inside(x, box_1))", ASKED, "take at least one cup out of box_1"),
    ("exists x: cup. (inside(x, box_1))", ASKED, "put at least one cup inside box_1"),
    (
        "forall x: cup. (exists y: gift_box. (inside(x, y)))",
        ASKED,
        "put every cup inside some gift box",
    ),
    (
        "forpairs x: cup, y: gift_box. (inside(x, y))",
        PhraseStyle(1, True),
        "put each cup into a separate gift box",
    ),
    ("forn 1. x: cup. (is_clean(x))", PhraseStyle(1), "precisely one cup is clean"),
    (
        "forn 2. x: cup. (inside(x, box_1))",
        ASKED,
        "see to it that exactly two cups are inside box_1",  # to put two inside may make it three
    ),
    (
        "ON(lamp_1) or inside(cup_1, box_1)",
        PhraseStyle(1, True),
        "see to it that either the lamp is turned on or cup_1 is inside box_1",
    ),
    (
        "not ON(lamp_1) until inside(cup_1, box_1)",
        ASKED,
        "see to it that the lamp is not switched on until cup_1 is inside box_1",
    ),
]


@pytest.mark.parametrize(("text", "voice", "clause"), REQUESTED)
def test_a_goal_has_several_sentences(text: str, voice: PhraseStyle, clause: str) -> None:
    goal = formula(text)
    assert WORDS.make_clause(goal, voice) == clause
    opening = "Your task is to" if voice.requests else "Make sure that"
    assert _InstructionReader(WORDS).read_goals(f"{opening} {clause}.") == (goal,)


@pytest.mark.parametrize("text", [text for text, _ in CASES])
@pytest.mark.parametrize("requests", [False, True])
def test_every_phrase_style_reads_back_as_the_goal(text: str, requests: bool) -> None:
    goal, opening = formula(text), "Please" if requests else "See to it that"
    clauses = {WORDS.make_clause(goal, PhraseStyle(pick, requests)) for pick in range(12)}
    assert [_InstructionReader(WORDS).read_goals(f"{opening} {clause}.") for clause in clauses] == [
        (goal,)
    ] * len(clauses)


def formula(text: str) -> f.Formula:
    return read_formula(text, FormulaSignature(ARITIES, {"GRAB": None, "TOUCH": None}))[0]


@pytest.mark.parametrize(("text", "sentence"), CASES)
def test_each_goal_has_an_exact_sentence(text: str, sentence: str) -> None:
    goal = formula(text)
    assert WORDS.make_clause(goal) == sentence
    assert _InstructionReader(WORDS).read_goals(f"Make sure that {sentence}.") == (goal,)


@pytest.mark.parametrize("number", [1, 2, 3, 5])
def test_several_goals_are_joined(number: int) -> None:
    goals = [formula(text) for text, _ in CASES[:number]]
    for seed in range(6):
        text = WORDS.make_instruction(goals, random.Random(seed))
        assert _InstructionReader(WORDS).read_goals(text) == tuple(goals)


@pytest.mark.parametrize(
    "text",
    [
        "the lamp is switched on.",
        "Make sure that the lamp is switched on",
        "Make sure that the lamp is blue.",
        "Make sure that every lamb is clean.",
        "Make sure that exactly two cup are clean.",
        "Make sure that exactly ² cups are clean.",
        f"Make sure that exactly {'9' * 5000} cups are clean.",
        "Make sure that the cup is clean.",
        "Make sure that switch the lamp on.",
        "Please the lamp is switched on.",
        "Please put no cup inside box_1.",
        "Please put exactly two cups inside box_1.",
        "Make sure that cup_1 is clean until cup_1 is clean until the lamp is switched on.",
    ],
)
def test_a_sentence_without_a_goal_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        _InstructionReader(WORDS).read_goals(text)


def test_a_goal_without_sentence_is_refused() -> None:
    with pytest.raises(InputError, match="no sentence can state a goal of the class Implies"):
        WORDS.make_clause(f.Implies(f.TRUE, f.FALSE))


@pytest.mark.parametrize(
    ("noun", "nouns"),
    [
        ("cup", "cups"),
        ("box", "boxes"),
        ("berry", "berries"),
        ("knife", "knives"),
        ("shelf", "shelves"),
        ("key", "keys"),
        ("pair of jeans", "pairs of jeans"),
        ("box of cereal", "boxes of cereal"),
    ],
)
def test_plurals(noun: str, nouns: str) -> None:
    assert pluralize(noun) == nouns


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize(
    ("like", "forms"),
    [
        ("virtualhome", "data"),
        *(("behavior", forms) for forms in get_args(GoalFormFrequency)),
        *swept(("virtualhome", "all")),
    ],
)
def test_instructions_read_back_as_the_goals(like: str, forms: GoalFormFrequency) -> None:
    benchmark = find_benchmark(like)
    for each in tasks(like, 40, forms):
        goals = _InstructionReader(
            InstructionWriter.make_writer_for_benchmark(benchmark, each.task.initial)
        ).read_goals(each.task.instruction)
        assert goals == tuple(goal.formula for goal in each.task.goals)


def test_objects_are_described_by_their_places() -> None:
    """An object is described by an object that is the only one of its category, or keeps its name."""
    benchmark = find_benchmark("behavior")
    told = 0
    for each in tasks("behavior"):
        words = InstructionWriter.make_writer_for_benchmark(
            benchmark, each.task.initial, distinguishes_objects_by_place=True
        )
        goals = [goal.formula for goal in each.task.goals]
        instruction = words.make_instruction(goals, random.Random(0))
        try:
            assert _InstructionReader(words).read_goals(instruction) == tuple(goals)
        except InputError as error:  # such a task is not made
            assert "one meaning" in str(error)  # noqa: PT017
        told += " that is " in instruction
    assert told


def test_objects_are_described_by_facts_true_of_no_other_object() -> None:
    scene = WORDS.scene
    seen = [Fact("inside", (1, 4)), Fact("is_clean", (2,)), Fact("ON", (1,)), Fact("ON", (2,))]
    words = replace(WORDS, initial_facts=[Fact("on_top", (1, 3)), *seen])
    assert [words.can_object_be_described_without_name(thing.name) for thing in scene.objects] == [
        True
    ] * 4 + [
        False,
        False,
        True,
    ]
    said = words.make_clause(formula("inside(cup_1, box_1) or not is_clean(cup_2)"))
    assert said == (
        "either the cup that is on top of the shelf is inside box_1 or the cup that is clean now is not clean"
    )
    assert _InstructionReader(words).read_goals(f"Make sure that {said}.") == (
        formula("inside(cup_1, box_1) or not is_clean(cup_2)"),
    )


def test_categories_with_equal_nouns_keep_their_names() -> None:
    things = ["gift_box.n.01", "gift_box", "cup.n.01", "cup.n.01", "can__of__soda"]
    objects = [WorldObject(f"thing_{n}", kind) for n, kind in enumerate(things)]
    scene = Scene(WORDS.scene.vocabulary, objects)
    assert replace(WORDS, scene=scene).noun_by_category == {
        "gift_box.n.01": "gift box",
        "gift_box": "gift_box",
        "cup.n.01": "cup",
        "can__of__soda": "can of soda",
    }
    called = replace(WORDS, scene=scene, english=EnglishWords(nouns={"gift_box": "case"}))
    assert called.noun_by_category["gift_box"] == "case"


def test_an_action_is_read_only_with_objects_of_the_scene() -> None:
    def read(things: str) -> tuple[f.Formula, ...]:
        text = f"the lamp is not switched on until the action GRAB has been taken on {things}"
        return _InstructionReader(WORDS).read_goals(f"Make sure that {text}.")

    lit = f.Not(f.Atom("ON", (f.Constant("lamp_1"),)))
    on = tuple(map(f.Constant, ("cup_1", "box_2")))
    assert read("cup_1 with box_2") == (f.Until(lit, f.Occurs("GRAB", on)),)
    assert read("cup_1 with nothing") == (f.Until(lit, f.Occurs("GRAB", on[:1])),)
