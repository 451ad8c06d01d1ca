"""World-model questions, the file that holds them (one JSON object per line), and the grading of answers.

A grade depends only on the question and the text of the answer.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator

from eai.abilities.answer_text import AnswerFormat, contains_json_string, read_json
from eai.abilities.reasoning import split_answer_and_reasoning
from eai.abilities.verdict import ConfusionCounts, Unreadable
from eai.base.errors import InputError
from eai.base.files import number_lines, read_content
from eai.tasks.options import describe_validation_error


class QuestionKind(str, Enum):
    """The subject of a question.

    ``forward``: facts after an action. ``backward``: a single action that makes a fact true.
    ``inverse``: the action between two states. ``state``: facts after several actions.
    ``applicability``: possible actions. ``why_not``: unmet requirements of an action.
    ``counterfactual``: outcome of a changed plan. ``validation``: whether, where and why a plan fails.
    ``justification``: unneeded steps of a plan. ``reachability``: facts that actions can make true.
    ``next_action``: first action of a shortest plan. ``landmarks``: actions in every plan.
    """

    FORWARD = "forward"
    BACKWARD = "backward"
    INVERSE = "inverse"
    STATE = "state"
    APPLICABILITY = "applicability"
    WHY_NOT = "why_not"
    COUNTERFACTUAL = "counterfactual"
    VALIDATION = "validation"
    JUSTIFICATION = "justification"
    REACHABILITY = "reachability"
    NEXT_ACTION = "next_action"
    LANDMARKS = "landmarks"


class QuestionForm(str, Enum):
    """The form of an answer: yes or no, the letter of a choice, or (open form) a list of items."""

    YES_NO = "yes_no"
    CHOICE = "choice"
    OPEN = "open"


Accept: TypeAlias = Literal["all", "any"]
"""Whether a right answer names ``all`` gold answers or ``any`` one of them."""


class Question(BaseModel):
    """A question with its gold answer.

    Attributes:
        id: identifier of the question, which is unique in a file and which answers repeat.
        version: version of the file format.
        domain: the benchmark that the question is about.
        task: id of the task that the question is about.
        title: title of the task. Near copies of a task share it.
        kind: the subject of the question.
        form: the form of the answer.
        depth: number of actions to consider: the actions of the question's plan, or of a shortest plan.
        options: number of possible answers to choose from: 2 in yes-no form, 0 in open form.
        prompt: the text that a model receives.
        answer: the gold answers, each a text: ``yes``, a letter, facts, actions, numbers.
        accept: whether an answer must name all gold answers, or only one.
        shortcuts: probability that each shortcut answers the question correctly, by name: 1, 0, or a fraction
            if the shortcut guesses. Empty in open form.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, title="Question")

    id: Annotated[str, Field(min_length=1)]
    version: Literal[2] = 2
    domain: str
    task: str
    title: str
    kind: QuestionKind
    form: QuestionForm
    depth: Annotated[int, Field(ge=1)]
    options: Annotated[int, Field(ge=0)] = 0
    prompt: Annotated[str, Field(min_length=1)]
    answer: tuple[str, ...]
    accept: Accept = "all"
    shortcuts: Mapping[str, Annotated[float, Field(ge=0, le=1)]] = Field(default_factory=dict)

    @field_validator("answer")
    @classmethod
    def _require_one_answer_in_closed_form(
        cls, answer: tuple[str, ...], fields: ValidationInfo
    ) -> tuple[str, ...]:
        form = fields.data.get("form", QuestionForm.OPEN)
        if form is not QuestionForm.OPEN and len(answer) != 1:
            raise ValueError(f"expected one answer to a question of form {form.value}")
        return answer


def questions_to_bytes(questions: Iterable[Question]) -> bytes:
    """Return the content of a question file as bytes. Equal questions give equal bytes."""
    return "".join(f"{question.model_dump_json()}\n" for question in questions).encode()


def read_questions_and_sha256(file: Path) -> tuple[Sequence[Question], str]:
    """Read the questions of a file in order. Return them and the SHA-256 digest of the file.

    Raises:
        InputError: the file cannot be read or is empty, or a line is no question. The message names the file,
            the line and the field.
    """
    content = read_content(file)
    questions: dict[str, Question] = {}
    for number, line in number_lines(content):
        position = f"{file}: line {number}"
        try:
            question = Question.model_validate_json(line)
        except ValidationError as error:
            raise InputError(
                f"{position}: {describe_validation_error(error, Question.model_fields)}"
            ) from error
        if question.id in questions:
            raise InputError(f"{position}: the id {question.id!r} occurs twice; ids must be unique")
        questions[question.id] = question
    if not questions:
        raise InputError(f"{file}: expected at least one question")
    return tuple(questions.values()), hashlib.sha256(content).hexdigest()


_WHITESPACE = re.compile(r"\s+")
_ANSWER_WORDS = {
    QuestionForm.YES_NO: re.compile(r"\b(yes|no)\b", re.IGNORECASE),
    QuestionForm.CHOICE: re.compile(r"\b([A-D])\b"),
}


@dataclass(frozen=True, slots=True)
class _QuestionGrade:
    """The grade of an answer to a question.

    Attributes:
        exact: whether the answer is completely right.
        counts: numbers of right, wrong and missing items of the answer. If one of the gold answers is
            enough, at most one item counts as missing.
        readable: whether the answer could be parsed.
        repairs: names of the repairs that were needed to parse the answer.
    """

    exact: bool
    counts: ConfusionCounts
    readable: bool = True
    repairs: tuple[str, ...] = ()


def grade_answer(question: Question, text: str) -> _QuestionGrade:
    """Grade an answer. An unreadable answer is wrong."""
    wanted = {_normalize_text(answer) for answer in question.answer}
    parsed = _parse_answer_items_and_repair_names(question.form, text)
    items, repairs = parsed or ((), ())
    given = set(map(_normalize_text, items))
    right, asks_one = len(given & wanted), question.accept == "any"
    missed = (min(1, len(wanted)) if asks_one else len(wanted)) - right
    exact = right == len(given) == 1 if asks_one else given == wanted
    counts = ConfusionCounts(right, len(given) - right, max(0, missed))
    return _QuestionGrade(exact and parsed is not None, counts, parsed is not None, repairs)


def format_gold_answer(question: Question) -> str:
    """Return a question's gold answer as the text that a model would write."""
    answers = question.answer[:1] if question.accept == "any" else question.answer
    if question.form is not QuestionForm.OPEN:
        return answers[0]
    return json.dumps(answers, ensure_ascii=False)


def _parse_answer_items_and_repair_names(
    form: QuestionForm, answer: str
) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Return the items of an answer, and the names of the repairs needed to parse it; None if unreadable."""
    if form is QuestionForm.OPEN:
        reading = read_json(answer, _LIST_FORM)
        return None if isinstance(reading, Unreadable) else (reading.value, reading.repairs)
    rest = split_answer_and_reasoning(answer)[0].strip()
    words = {word.casefold() for word in _ANSWER_WORDS[form].findall(rest)}
    if len(words) != 1:
        return None
    (word,) = words
    is_bare_word = rest.strip(" .*`\"'()[]").casefold() == word
    return (word,), () if is_bare_word else ("prose",)


def _parse_strings(value: object) -> tuple[str, ...] | None:
    if isinstance(value, list) and all(isinstance(item, str | int) for item in value):
        return tuple(map(str, value))
    return None


_LIST_FORM: AnswerFormat[tuple[str, ...]] = AnswerFormat(
    "list of names", _parse_strings, is_part=contains_json_string
)


def _normalize_text(text: str) -> str:
    return _WHITESPACE.sub("", text).casefold()
