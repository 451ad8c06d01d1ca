from __future__ import annotations

import pytest

from eai.abilities.protocol import FOUR, Ability
from eai.scoring.epochs import majority, meaning

PLANS = Ability.ACTION_SEQUENCING
GOALS = Ability.GOAL_INTERPRETATION
SUBGOALS = Ability.SUBGOAL_DECOMPOSITION
OPERATORS = Ability.TRANSITION_MODELING


@pytest.mark.parametrize(
    ("ability", "one", "other"),
    [
        (PLANS, '{"WALK": ["sofa", "3"]}', "Here it is:\n```json\n{'WALK':\n['sofa', '3']}\n```"),
        (PLANS, '[{"action": "OPEN"}]', '  [ {"action" : "OPEN"} ]'),
        (GOALS, '{"node goals": [["a"], ["b", "c"]]}', '{"node goals": [["b", "c"], ["a"]]}'),
        (GOALS, '{"a": [{"x": "1", "y": "2"}]}', '{"a": [{"y": "2", "x": "1"}]}'),
        (SUBGOALS, '{"output": ["ON(tv.1)  and A"], "n": 1}', '{"n": 1, "output": ["ON(tv.1) and A"]}'),
        (OPERATORS, "(:action a\n  :effect (b))", "Sure.\n(:action a :effect (b))"),
    ],
)
def test_accidents_do_not_matter(ability: Ability, one: str, other: str) -> None:
    assert meaning(one, ability) == meaning(other, ability) is not None


@pytest.mark.parametrize(
    ("ability", "one", "other"),
    [
        (PLANS, '{"WALK": ["a"], "GRAB": ["a"]}', '{"GRAB": ["a"], "WALK": ["a"]}'),
        (PLANS, '{"WALK": ["a"], "WALK": ["b"]}', '{"WALK": ["b"], "WALK": ["a"]}'),
        (PLANS, '{"POUR": ["a", "b"]}', '{"POUR": ["b", "a"]}'),
        (GOALS, '{"edge goals": [["inside", "a", "b"]]}', '{"edge goals": [["inside", "b", "a"]]}'),
        (SUBGOALS, '{"output": ["A", "B"]}', '{"output": ["B", "A"]}'),
        (SUBGOALS, '{"output": [1]}', '{"output": [true]}'),
    ],
)
def test_what_is_said_matters(ability: Ability, one: str, other: str) -> None:
    assert meaning(one, ability) != meaning(other, ability)


@pytest.mark.parametrize(
    ("answers", "chosen"),
    [
        (["{'A': []}", "{'B': []}", "{'B':[]}"], 1),
        (["{'A': []}", "{'B': []}"], 0),
        (["no", "no", "{'B': []}"], 2),
        (["no", "neither"], 0),
        (["only"], 0),
    ],
)
def test_the_first_answer_of_the_most_frequent_meaning_is_chosen(answers: list[str], chosen: int) -> None:
    assert majority(answers, PLANS) == chosen


@pytest.mark.parametrize(
    ("answers", "chosen"),
    [(["yes", "no", " no\n"], 1), (['["a"]', 'So:\n["b"]', '["b"]'], 1), (["yes", "no"], 0)],
)
def test_answers_to_questions_are_no_json(answers: list[str], chosen: int) -> None:
    assert majority(answers, Ability("world_model")) == chosen


def test_plans_that_are_no_json_mean_nothing() -> None:
    assert [meaning("no", each) for each in FOUR] == [None] * 4
