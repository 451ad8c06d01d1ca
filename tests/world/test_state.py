from __future__ import annotations

import pytest

from eai.base.errors import InputError
from eai.logic.formula import Variable
from eai.world.derived import DefinedPredicate
from eai.world.state import Fact, Scene, WorldObject, compare_states
from eai.world.vocabulary import Predicate, Vocabulary

X = Variable("x")
AT, OPEN, DARK = Predicate("at", 2), Predicate("open", 1), Predicate("dark", 0)
VOCABULARY = Vocabulary((AT, OPEN, DARK), (DefinedPredicate("shut", (X,), ~OPEN(X)),))
SCENE = Scene(VOCABULARY, {"robot": "robot", "dock": "place", "bay-2": "place"}, agent="robot")


def test_objects_of_a_category_come_in_the_order_of_the_scene() -> None:
    things = (WorldObject("b", "cup"), WorldObject("box", "box"), WorldObject("a", "cup"))
    scene = Scene(Vocabulary(()), things)
    assert scene.names_of_category("cup") == ("b", "a")
    assert scene.names_of_category(None) == ("b", "box", "a")
    assert scene.names_of_category("car") == ()


def test_facts_may_be_stated_by_index_by_name_or_as_text() -> None:
    """A character that formulas do not allow in names becomes an underscore in texts."""
    expected = [("open", (2,)), ("dark", ()), ("at", (0, 1))]
    for facts in (
        [("at", (0, 1)), ("open", (2,)), ("dark", ())],
        [Fact("at", (0, 1)), Fact("open", (2,)), Fact("dark", ())],
        [Fact("at", ("robot", "dock")), Fact("open", ("bay-2",)), "dark()"],  # type: ignore[arg-type]
        [("at", ("robot", "dock")), ("open", ["bay-2"]), ("dark", ())],
        ["at(robot, dock)", "open(bay_2)", "dark()"],
    ):
        assert [*SCENE.state(facts).facts()] == expected


def test_facts_about_objects_in_a_mask_name_no_other_object() -> None:
    vocabulary = Vocabulary((AT, OPEN, DARK, Predicate("between", 3)))
    state = Scene(vocabulary, dict.fromkeys("abcd", "place")).state(
        [f"at({x}, {y})" for x in "abcd" for y in "abcd"]
        + ["open(a)", "open(b)", "dark()", "between(a, b, c)", "between(d, b, d)", "between(b, d, d)"]
    )
    for mask in range(16):
        expected = [fact for fact in state.facts() if all(mask >> i & 1 for i in fact.arguments)]
        assert [*state.facts(mask)] == expected != []


@pytest.mark.parametrize(
    ("fact", "problem"),
    [
        ("at(robot, dok)", "there is no object dok; did you mean dock?"),
        (("at", ("robt", "dock")), "there is no object robt; did you mean robot?"),
        (("at", (0, 3)), "there is no object 3"),
        (("at", (-1, 1)), "there is no object -1"),
        (Fact("at", (0, 3)), "there is no object 3"),
        (Fact("at", (0,)), "at takes 2 arguments, not 1"),
        (Fact("att", (0, 1)), "predicate att is not declared; did you mean at?"),
        ("att(robot, dock)", "predicate att is not declared; did you mean at?"),
        ("at(robot)", "at takes 2 arguments, not 1"),
        (
            ("open", ("dock")),
            "open: expected a tuple of objects; write a tuple of one object with a comma, (x,)",
        ),
        (("open", 1), "open: expected a tuple of objects; write a tuple of one object with a comma, (x,)"),
        (("open", "dock", "robot"), "('open', 'dock', 'robot'): expected a fact, as in 'at(robot, dock)'"),
        ("not open(dock)", "'not open(dock)': expected a fact, as in 'at(robot, dock)'"),
        ("at(robot dock)", "'at(robot dock)': line 1, column 10: expected ')' or ','"),
        ("shut(dock)", "shut is derived from other facts: state those facts instead"),
    ],
)
def test_a_wrong_fact_raises_an_error_that_names_the_mistake(fact: object, problem: str) -> None:
    with pytest.raises(InputError) as error:
        SCENE.state([fact])  # type: ignore[list-item]
    assert str(error.value) == problem


@pytest.mark.parametrize(
    ("objects", "agent", "problem"),
    [
        (
            [WorldObject("a", "b"), WorldObject("a", "c")],
            None,
            "two objects are called a: give each object a name of its own",
        ),
        ({"robot": "robot"}, "robt", "there is no object robt; did you mean robot?"),
        ({"robot": "robot"}, 1, "there is no object 1"),
        ([("robot", "robot")], None, "objects: expected WorldObject, found tuple"),
    ],
)
def test_a_wrong_scene_raises_an_error_that_names_the_mistake(
    objects: object, agent: int | str | None, problem: str
) -> None:
    with pytest.raises(InputError) as error:
        Scene(VOCABULARY, objects, agent)  # type: ignore[arg-type]
    assert str(error.value) == problem


def test_replacing_the_facts_gives_a_state_of_the_same_episode() -> None:
    between = Predicate("between", 3)
    vocabulary = Vocabulary((AT, OPEN, DARK, between))
    scene = Scene(vocabulary, {"robot": "robot", "dock": "place", "bay": "place"}, agent="robot")
    before = scene.state(["at(robot, dock)", "between(robot, dock, bay)", "open(bay)"])
    after = before.replace_all_facts(["dark()", "at(robot, bay)", "between(dock, robot, bay)"])
    assert [*map(str, after.facts())] == [
        *map(str, scene.state(["dark()", "at(robot, bay)", "between(dock, robot, bay)"]).facts())
    ]
    assert after.replace_all_facts(before.facts()) == before != after
    assert len(compare_states(before, after).added) == len(compare_states(before, after).removed) == 3
