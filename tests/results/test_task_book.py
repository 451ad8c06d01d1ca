from __future__ import annotations

import pytest

from eai.abilities.explanation import read_statement
from eai.results.task_book import Reason, TaskBook
from eai.tasks.source import Source
from studies.lamps import lamp_task, lamps


@pytest.mark.parametrize(
    ("atom", "reason"),
    [
        ("at(robot, knife)", Reason.INITIAL),
        ("at(robot, lamp_1)", Reason.INTERMEDIATE),
        ("not lit(lamp_2)", Reason.INTERMEDIATE),
        ("at(robot, lamp_2)", Reason.FINAL),
        ("trimmed(lamp_1)", Reason.FINAL),
        ("near(lamp_1, lamp_2)", Reason.OTHER),
        ("lit(lamp_9)", Reason.OTHER),
        ("bright(lamp_1)", Reason.UNKNOWN),
        ("JUMP", Reason.UNKNOWN),
        ("GO", Reason.PROCEDURAL),
        ("LIGHT", Reason.OTHER),
    ],
)
def test_wrong_goals_are_followed_along_the_annotated_plan(atom: str, reason: Reason) -> None:
    facts = TaskBook(lamps(), Source()).facts_of(lamp_task().id)
    assert facts is not None
    assert facts.reason(read_statement(atom)) is reason
