"""Two models that were asked the same questions, or some of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from eai.questions.comparison import compare_questions
from eai.questions.question import Form, Kind, Question
from eai.questions.records import QuestionRun
from eai.questions.results import score


def asked(number: int, kind: Kind) -> Question:
    return Question.model_validate(
        {
            "id": f"q{number}",
            "domain": "d",
            "task": f"t{number // 2}",
            "title": "t",
            "kind": kind,
            "form": Form.YES_NO,
            "depth": 1,
            "options": 2,
            "prompt": f"{number}?",
            "answer": ("yes",),
        }
    )


STATE = [asked(n, Kind.STATE) for n in range(4)]
FORWARD = [asked(n, Kind.FORWARD) for n in range(4, 6)]
LANDMARKS = [asked(6, Kind.LANDMARKS)]


def run(questions: Sequence[Question], answers: Mapping[int, str]) -> QuestionRun:
    given = {f"q{number}": answer for number, answer in answers.items()}
    return QuestionRun("me", "0" * 64, tuple(score(questions, given)))


def test_what_both_were_asked_is_compared_by_kind_and_in_all() -> None:
    first = run([*STATE, *FORWARD], {0: "yes", 1: "yes", 2: "no", 4: "no"})
    second = run([*FORWARD, *STATE[1:], *LANDMARKS], {1: "yes", 2: "yes", 3: "no", 4: "yes", 6: "yes"})
    found = compare_questions(first, second)
    assert [each.metric for each in found.differences] == [Kind.FORWARD.value, Kind.STATE.value, "all"]
    rates = [
        [(rate.numerator, rate.denominator) for rate in (each.first, each.second)]
        for each in found.differences
    ]
    assert rates == [[(0, 2), (1, 2)], [(1, 3), (2, 3)], [(1, 5), (3, 5)]]
    assert (found.tasks, found.names) == (5, 3)
    assert sorted(found.differing) == ["q2", "q4"]
    assert (found.only_in_first, found.only_in_second) == (("q0",), ("q6",))
