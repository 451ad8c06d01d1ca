from __future__ import annotations

import json
from typing import Any

import jsonschema
import pytest

from abilities.goal_interpretation.lamps import DOMAIN, make_task
from eai.abilities.notation.goals import (
    JsonGoalNotation,
    WrittenGoal,
    WrittenGoals,
    read_nested_formula,
)
from eai.abilities.verdict import Unreadable
from eai.logic.formula import Atom, Formula
from eai.logic.signature import make_term
from eai.tasks.task import GoalKind
from logic.bddl_text import print_condition

NOTATION = JsonGoalNotation()
OPEN = WrittenGoal("open", ("box",))


@pytest.mark.parametrize(
    ("text", "goals"),
    [
        ('{"node goals": [["open", "box"]]}', [OPEN]),
        ('{"node goals": [["not", ["open", "box"]]]}', [OPEN._replace(positive=False)]),
        ('{"edge goals": [["inside", "ball", "box"]]}', [WrittenGoal("inside", ("ball", "box"))]),
        ('{"action goals": ["PRESS"]}', [WrittenGoal("PRESS", is_action=True)]),
        ('{"action goals": [["PRESS", "lamp"]]}', [WrittenGoal("PRESS", ("lamp",), is_action=True)]),
        ('{"node goals": null, "other": [["open", "box"]]}', [OPEN]),
        ('{"output": {"node goals": [["open", "box"]]}}', [OPEN]),
        ("Here: {'node goals': [['open', 'box']]}!", [OPEN]),
        ("{}", []),
        ('{"node goals": [["open", "box"]]} in the form {"node goals": [], "edge goals": []}', [OPEN]),
        ('{"node goals": []} No: {"node goals": [["open", "box"]]}', [OPEN]),
        ('{} No: {"node goals": []}', []),
        ('{"goals": [["lit", "box"]]} No: {"goals": [["open", "box"]]}', [OPEN]),
    ],
)
def test_goals_are_read(text: str, goals: list[WrittenGoal]) -> None:
    found = NOTATION.read(text)
    assert isinstance(found, WrittenGoals)
    assert (list(found.goals), found.ill_formed) == (goals, ())


@pytest.mark.parametrize("entry", ["[]", "7", '"open"', '["open", 7]', '["not", "open", "box"]', '["not"]'])
def test_an_entry_that_is_not_a_literal_is_ill_formed(entry: str) -> None:
    found = NOTATION.read(f'{{"node goals": [{entry}], "others": [{entry}]}}')
    assert isinstance(found, WrittenGoals)
    assert found.goals == ()
    assert [kind for kind, _ in found.ill_formed] == [GoalKind.STATE, None]


@pytest.mark.parametrize(
    "text",
    [
        'States: {"node goals": [["open", "box"]]} Relations: {"edge goals": [["inside", "ball", "box"]]}',
        '{"node goals": [["lit", "box"]], "edge goals": []} or {"node goals": [["open", "box"]]} and '
        '{"action goals": ["PRESS"]}',
    ],
)
def test_goals_in_separate_objects_are_unreadable(text: str) -> None:
    assert isinstance(NOTATION.read(text), Unreadable)


@pytest.mark.parametrize("text", ["", "PRESS", "[]", '{"node goals": "open"}', '{"a": 1}'])
def test_an_object_without_lists_is_unreadable(text: str) -> None:
    assert isinstance(NOTATION.read(text), Unreadable)


@pytest.mark.parametrize(
    ("key", "text", "is_read"),
    [
        ("more", "on(a, b)", False),
        ("more", '"edge goals": [["on", "a", "b"]]', False),
        ("reasoning", "on(a, b)", True),
        ("note", "The lamp(s) must be on.", True),
    ],
)
def test_a_text_beside_goals_is_no_goal(key: str, text: str, is_read: bool) -> None:
    answer = NOTATION.read(json.dumps({"node goals": [], "edge goals": [], key: text}))
    assert isinstance(answer, WrittenGoals) is is_read


def test_written_goals_are_read_back() -> None:
    goals = (
        OPEN,
        WrittenGoal("inside", ("ball", "box"), positive=False),
        WrittenGoal("raining"),
        WrittenGoal("PRESS", is_action=True),
    )
    found = NOTATION.read(NOTATION.join(NOTATION.write(goals)))
    assert isinstance(found, WrittenGoals)
    assert set(found.goals) == set(goals)


def test_goals_may_use_visible_predicates_that_change() -> None:
    assert NOTATION.map_spellings_to_predicate_names(DOMAIN).keys() == {
        ("lit", 1),
        ("open", 1),
        ("inside", 2),
        ("together", 2),
    }


def test_an_object_is_called_by_its_name() -> None:
    assert NOTATION.list_object_names(make_task())[:2] == ("lamp_0", "lamp_1")


def test_a_goal_is_printed_as_its_text() -> None:
    assert str(OPEN._replace(positive=False)) == "not open(box)"
    assert str(WrittenGoal("PRESS", is_action=True)) == "PRESS"


JAR = ["jar", "-", "jar"]
OPEN_JAR = ["open", "jar"]


def literal(entry: object, variables: frozenset[str]) -> Formula | None:
    match entry:
        case [str(predicate), *names] if all(isinstance(name, str) for name in names):
            return Atom(predicate, tuple(make_term(str(name), variables) for name in names))
        case _:
            return None


@pytest.mark.parametrize(
    ("entry", "condition"),
    [
        (OPEN_JAR, "(open jar)"),
        (["not", OPEN_JAR], "(not (open jar))"),
        (["not", ["not", OPEN_JAR]], "(not (not (open jar)))"),
        (["or", OPEN_JAR, ["lit", "lamp"]], "(or (open jar) (lit lamp))"),
        (["or", [OPEN_JAR, ["lit", "lamp"]]], "(or (open jar) (lit lamp))"),
        (["and", OPEN_JAR, ["or", OPEN_JAR, OPEN_JAR]], "(and (open jar) (or (open jar) (open jar)))"),
        (["and", OPEN_JAR], "(and (open jar))"),
        (["imply", OPEN_JAR, ["lit", "lamp"]], "(imply (open jar) (lit lamp))"),
        (["forall", JAR, ["not", OPEN_JAR]], "(forall (?jar - jar) (not (open ?jar)))"),
        (["forall", "jar", ["not", OPEN_JAR]], "(forall (?jar - jar) (not (open ?jar)))"),
        (["exists", ["x", "-", "jar"], ["open", "x"]], "(exists (?x - jar) (open ?x))"),
        (["forn", ["2"], JAR, OPEN_JAR], "(forn (2) (?jar - jar) (open ?jar))"),
        (["forn", 2, JAR, OPEN_JAR], "(forn (2) (?jar - jar) (open ?jar))"),
        (["forn", 0, JAR, OPEN_JAR], "(forn (0) (?jar - jar) (open ?jar))"),
        (["forn", "9" * 9, JAR, OPEN_JAR], "(forn (999999999) (?jar - jar) (open ?jar))"),
        (
            ["forpairs", JAR, ["lid", "-", "lid"], ["ontop", "lid", "jar"]],
            "(forpairs (?jar - jar) (?lid - lid) (ontop ?lid ?jar))",
        ),
        (
            ["fornpairs", "2", JAR, "lid", ["ontop", "lid", "jar"]],
            "(fornpairs (2) (?jar - jar) (?lid - lid) (ontop ?lid ?jar))",
        ),
        (
            ["exists", JAR, ["forall", "lid", ["ontop", "lid", "jar"]]],
            "(exists (?jar - jar) (forall (?lid - lid) (ontop ?lid ?jar)))",
        ),
    ],
)
def test_nested_entries_become_formulas(entry: list[Any], condition: str) -> None:
    read = read_nested_formula(entry, literal)
    assert read is not None
    assert print_condition(read) == condition


@pytest.mark.parametrize(
    "entry",
    [
        *(None, 1, [], [[]], "open", {"open": "jar"}, ["open", 1], ["open", ["jar"]]),
        *(["not", [1]], ["not", OPEN_JAR, OPEN_JAR, 3], ["and", OPEN_JAR, 1], ["or", [OPEN_JAR, 2]]),
        ["imply", OPEN_JAR, 1],
        *(["forall", JAR], ["forall", OPEN_JAR], ["forall", 1, OPEN_JAR], ["forall", JAR, JAR, OPEN_JAR]),
        *(["forn", JAR, OPEN_JAR], ["forn", "two", JAR, OPEN_JAR], ["forn", True, JAR, OPEN_JAR]),
        *(["forn", -1, JAR, OPEN_JAR], ["forn", "9" * 10, JAR, OPEN_JAR], ["fornpairs", 1, JAR, OPEN_JAR]),
        *(["forn", 10**9, JAR, OPEN_JAR], ["fornpairs", [10**4000], JAR, JAR, OPEN_JAR]),
        ["forpairs", JAR, OPEN_JAR],
    ],
)  # fmt: skip
def test_an_entry_that_is_not_a_condition_has_no_meaning(entry: object) -> None:
    assert read_nested_formula(entry, literal) is None


@pytest.mark.parametrize(
    ("words", "refused"),
    [
        (None, [["open", 7]]),
        (("box", "lamp"), [["open", "jar"], ["not", "jar"]]),
    ],
)
def test_the_form_of_goals_has_the_words_of_the_task(
    words: tuple[str, ...] | None, refused: list[Any]
) -> None:
    schema = NOTATION.make_json_schema_of_answer(DOMAIN, words)
    rest = {"edge goals": [], "action goals": []}
    for literal in (["open", "box"], ["not", ["open", "box"]]):
        jsonschema.validate({"node goals": [literal], **rest}, schema)
    for literal in refused:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({"node goals": [literal], **rest}, schema)
