from __future__ import annotations

import pytest

from abilities.goal_interpretation.lamps import DOMAIN, make_task
from eai.abilities.goal_interpretation.notation import IllFormed, JsonGoals, Word, WrittenGoal, WrittenGoals
from eai.abilities.task import GoalKind
from eai.abilities.verdict import Unreadable

NOTATION = JsonGoals()
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
    ],
)
def test_goals_are_read(text: str, goals: list[WrittenGoal]) -> None:
    found = NOTATION.read(text)
    assert isinstance(found, WrittenGoals)
    assert (list(found.goals), found.ill_formed) == (goals, ())


@pytest.mark.parametrize("entry", ["[]", "7", '"open"', '["open", 7]', '["not", "open", "box"]', '["not"]'])
def test_what_is_no_literal_is_ill_formed(entry: str) -> None:
    found = NOTATION.read(f'{{"node goals": [{entry}], "others": [{entry}]}}')
    assert isinstance(found, WrittenGoals)
    assert found.goals == ()
    assert [each.kind for each in found.ill_formed] == [GoalKind.STATE, None]
    assert all(isinstance(each, IllFormed) for each in found.ill_formed)


@pytest.mark.parametrize("text", ["", "PRESS", "[]", '{"node goals": "open"}', '{"a": 1}'])
def test_what_has_no_lists_is_unreadable(text: str) -> None:
    assert isinstance(NOTATION.read(text), Unreadable)


def test_what_is_written_is_read() -> None:
    goals = (
        OPEN,
        WrittenGoal("inside", ("ball", "box"), positive=False),
        WrittenGoal("raining"),
        WrittenGoal("PRESS", is_action=True),
    )
    found = NOTATION.read(NOTATION.join(NOTATION.write(goals)))
    assert isinstance(found, WrittenGoals)
    assert set(found.goals) == set(goals)


def test_goals_may_speak_of_what_changes_and_can_be_seen() -> None:
    assert NOTATION.words(DOMAIN).keys() == {
        Word("lit", 1),
        Word("open", 1),
        Word("inside", 2),
        Word("together", 2),
    }


def test_an_object_is_called_by_its_name() -> None:
    assert NOTATION.names(make_task())[:2] == ("lamp_0", "lamp_1")


def test_goals_as_text() -> None:
    assert str(OPEN._replace(positive=False)) == "not open(box)"
    assert str(WrittenGoal("PRESS", is_action=True)) == "PRESS"
