from __future__ import annotations

import pytest

from eai.abilities.verdict import Confusion
from eai.questions.answers import gold_text, grade
from eai.questions.question import Accept, Form, Kind, Question


def question(
    form: Form, *answer: str, accept: Accept = Accept.ALL, options: int = 0, question_id: str = "q"
) -> Question:
    return Question(
        id=question_id,
        domain="d",
        task="t",
        title="t",
        kind=Kind.STATE,
        form=form,
        depth=1,
        options=options,
        prompt="?",
        answer=answer,
        accept=accept,
    )


YES = question(Form.YES_NO, "yes", options=2)
LETTER = question(Form.CHOICE, "B", options=4)
FACTS = question(Form.OPEN, "at(robot, box)", "not lit(lamp_1)")
NOTHING = question(Form.OPEN)
ANY = question(Form.OPEN, "GO(box)", "GO(ball)", accept=Accept.ANY)


@pytest.mark.parametrize(
    ("asked", "text", "exact", "counts"),
    [
        (YES, "yes", True, (1, 0, 0)),
        (YES, "Yes.", True, (1, 0, 0)),
        (YES, "no", False, (0, 1, 1)),
        (YES, "The answer is yes", True, (1, 0, 0)),
        (YES, "<think>no? no.</think> yes", True, (1, 0, 0)),
        (LETTER, "B", True, (1, 0, 0)),
        (LETTER, "**B.**", True, (1, 0, 0)),
        (LETTER, "C", False, (0, 1, 1)),
        (FACTS, '["not lit(lamp_1)", "at(robot, box)"]', True, (2, 0, 0)),
        (FACTS, '```json\n["not lit( lamp_1 )", "AT(robot,box)"]\n```', True, (2, 0, 0)),
        (FACTS, '["at(robot, box)"]', False, (1, 0, 1)),
        (FACTS, '["at(robot, box)", "lit(lamp_1)"]', False, (1, 1, 1)),
        (FACTS, '["at(robot, box)", "at(robot, box)", "not lit(lamp_1)"]', True, (2, 0, 0)),
        (FACTS, "[]", False, (0, 0, 2)),
        (NOTHING, "[]", True, (0, 0, 0)),
        (NOTHING, '["lit(lamp_1)"]', False, (0, 1, 0)),
        (ANY, '["GO(ball)"]', True, (1, 0, 0)),
        (ANY, '["GO(lamp_1)"]', False, (0, 1, 1)),
        (ANY, '["GO(ball)", "GO(lamp_1)"]', False, (1, 1, 0)),
        (ANY, '["GO(ball)", "GO(box)"]', False, (2, 0, 0)),
        (question(Form.OPEN, "1", "3"), "[1, 3]", True, (2, 0, 0)),
    ],
)
def test_an_answer_is_as_right_as_its_parts(
    asked: Question, text: str, exact: bool, counts: tuple[int, int, int]
) -> None:
    graded = grade(asked, text)
    assert (graded.exact, graded.counts, graded.readable) == (exact, Confusion(*counts), True)


@pytest.mark.parametrize(
    ("asked", "text", "missed"),
    [
        (YES, "", 1),
        (YES, "yes and no", 1),
        (LETTER, "B or C", 1),
        (LETTER, "E", 1),
        (FACTS, "at(robot, box)", 2),
        (FACTS, '{"facts": "at(robot, box)"}', 2),
        (NOTHING, "nothing", 0),
        (ANY, "GO(ball)", 1),
        (FACTS, '[["at", "robot", "box"]]', 2),
    ],
)
def test_what_cannot_be_read_is_wrong_and_repaired_by_no_guess(
    asked: Question, text: str, missed: int
) -> None:
    graded = grade(asked, text)
    assert (graded.exact, graded.counts, graded.readable) == (False, Confusion(0, 0, missed), False)


def test_repairs_are_named() -> None:
    assert grade(YES, "yes").repairs == ()
    assert grade(YES, "It does: yes").repairs == ("prose",)
    assert grade(FACTS, 'So: ["at(robot, box)"]').repairs == ("prose",)


@pytest.mark.parametrize("asked", [YES, LETTER, FACTS, NOTHING, ANY])
def test_the_gold_answer_is_right(asked: Question) -> None:
    assert grade(asked, gold_text(asked)).exact
