"""Two models on the same questions, by kind; questions about one task are alike and count together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from eai.abilities.share import of_all
from eai.errors import InputError
from eai.questions.question import Kind
from eai.questions.records import QuestionRun, read_question_runs
from eai.results.certainty import Case, Cases
from eai.results.comparison import Comparison, difference

ALL = "all"
"""What questions of all kinds together are called."""


class QuestionPair(NamedTuple):
    """Two runs on the same questions."""

    first: QuestionRun
    second: QuestionRun


def question_pairs(first: Sequence[Path], second: Sequence[Path]) -> list[QuestionPair]:
    """The runs in files of records that were asked the same questions, be it with the rules or without.

    Raises:
        InputError: a file cannot be read, or several on one side were asked the same questions.
    """
    before, after = _by_questions(first), _by_questions(second)
    same = [QuestionPair(before[digest], after[digest]) for digest in before if digest in after]
    return same or [QuestionPair(a, b) for a in before.values() for b in after.values() if _agree(a, b)]


def _agree(one: QuestionRun, other: QuestionRun) -> bool:
    """Whether the questions that both were asked, by their ids, are the same but for their prompts."""
    questions = {result.question.id: result.question for result in one.results}
    shared = [r.question for r in other.results if r.question.id in questions]
    return bool(shared) and all(each == questions[each.id] for each in shared)


def _by_questions(paths: Sequence[Path]) -> dict[str, QuestionRun]:
    found: dict[str, QuestionRun] = {}
    for run in read_question_runs(paths):
        if run.questions_sha256 in found:
            both = f"{found[run.questions_sha256].model} and {run.model}"
            raise InputError(f"expected one run for the same questions, found {both}")
        found[run.questions_sha256] = run
    return found


def compare_questions(first: QuestionRun, second: QuestionRun) -> Comparison:
    """Compare what two models make of the questions that both were asked, by kind and in all.

    The units are the tasks that questions are about; as if questions were independent is beside it.
    """
    before, after = ({r.question.id: r for r in run.results} for run in (first, second))
    shared = [question_id for question_id in before if question_id in after]
    kinds = {question_id: before[question_id].question.kind for question_id in shared}

    def cases(run: QuestionRun, kind: Kind | None) -> Cases:
        return [
            Case(r.question.id, r.question.task, of_all(r.graded.exact))
            for r in run.results
            if r.question.id in kinds and kind in (None, r.question.kind)
        ]

    asked = [kind for kind in Kind if kind in kinds.values()]
    return Comparison(
        tuple(
            difference(
                ALL if kind is None else kind.value, cases(first, kind), cases(second, kind), yes_no=True
            )
            for kind in (*asked, None)
        ),
        len(shared),
        len({before[question_id].question.task for question_id in shared}),
        tuple(i for i in shared if before[i].graded.exact != after[i].graded.exact),
        tuple(i for i in before if i not in after),
        tuple(i for i in after if i not in before),
    )
