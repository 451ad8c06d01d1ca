from __future__ import annotations

import pytest

from eai.abilities.explanation import parse_statement
from eai.results.lines import WrongGoalReason
from eai.results.task_book import TaskLookup
from eai.tasks.source import Source
from studies.lamps import lamp_task, lamps


@pytest.mark.parametrize(
    ("atom", "reason"),
    [
        ("at(robot, knife)", "initial"),
        ("at(robot, lamp_1)", "intermediate"),
        ("not lit(lamp_2)", "intermediate"),
        ("at(robot, lamp_2)", "final"),
        ("trimmed(lamp_1)", "final"),
        ("near(lamp_1, lamp_2)", "other"),
        ("lit(lamp_9)", "other"),
        ("bright(lamp_1)", "unknown"),
        ("JUMP", "unknown"),
        ("GO", "procedural"),
        ("LIGHT", "other"),
    ],
)
def test_wrong_goals_are_followed_along_the_annotated_plan(atom: str, reason: WrongGoalReason) -> None:
    assert TaskLookup(lamps(), Source()).reason(lamp_task().id, parse_statement(atom)) == reason
