"""World-model questions as values, and the file that holds them: JSON lines, one question a line.

How an answer is read, and how right it is, are pure functions of a text.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from eai.abilities.answer_text import AnswerForm, holds_strings, read_json
from eai.abilities.reasoning import split_reasoning
from eai.abilities.verdict import Confusion, Unreadable
from eai.base.errors import InputError
from eai.base.files import number_lines, read_content
from eai.tasks.options import misfit


class Kind(str, Enum):
    """The kind of question.

    ``forward``: what holds after an action. ``backward``: which single action makes a fact true. ``inverse``:
    which action led from one state to another. ``state``: what holds after several actions.
    ``applicability``: which actions are possible. ``why_not``: which requirements of an action are not met.
    ``counterfactual``: what becomes of a plan that is changed, or begins otherwise. ``validation``: where a
    plan fails, and why. ``justification``: which steps of a plan are not needed. ``reachability``: what can
    become true by some actions. ``next_action``: how a shortest plan begins. ``landmarks``: which actions
    are in every plan.
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


class Form(str, Enum):
    """How an answer is given: yes or no, the letter of a choice, or a list of what is asked for."""

    YES_NO = "yes_no"
    CHOICE = "choice"
    OPEN = "open"


Accept: TypeAlias = Literal["all", "any"]
"""Whether an answer has to name all of the gold answers, or any one of them."""


class Question(BaseModel):
    """A question with its gold answer.

    Attributes:
        id: known by this in answers; unique in a file.
        version: of the format.
        domain: the benchmark whose world it is about.
        task: the id of the task whose world it is about.
        title: what near copies of this task share.
        kind: what is asked about.
        form: how an answer is given.
        depth: how many actions there are to think of: those that the question names one after the other, or
            those of a shortest plan.
        options: how many answers there are to choose from; 0 where there are none.
        prompt: what a model is asked.
        answer: the gold answers, each a text: ``yes``, a letter, facts, actions, numbers.
        accept: whether all of them are wanted, or any one.
        shortcuts: how much of it each shortcut gets right, by name: 1, 0, or a part where it guesses. Empty
            in open form.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, title="Question")

    id: Annotated[str, Field(min_length=1)]
    version: Literal[2] = 2
    domain: str
    task: str
    title: str
    kind: Kind
    form: Form
    depth: Annotated[int, Field(ge=1)]
    options: Annotated[int, Field(ge=0)] = 0
    prompt: Annotated[str, Field(min_length=1)]
    answer: tuple[str, ...]
    accept: Accept = "all"
    shortcuts: Mapping[str, Annotated[float, Field(ge=0, le=1)]] = Field(default_factory=dict)


def questions_content(questions: Iterable[Question]) -> bytes:
    """Questions as the content of a file; equal questions give equal bytes."""
    return "".join(f"{question.model_dump_json()}\n" for question in questions).encode()


def read_questions(file: Path) -> tuple[Sequence[Question], str]:
    """The questions of a file in order, and the digest of its content.

    Raises:
        InputError: it cannot be read, has none, or a line is no question; names file, line and field.
    """
    content = read_content(file)
    questions: dict[str, Question] = {}
    for number, line in number_lines(content):
        place = f"{file}: line {number}"
        try:
            question = Question.model_validate_json(line)
        except ValidationError as error:
            raise InputError(f"{place}: {misfit(error, Question.model_fields)}") from error
        if question.id in questions:
            raise InputError(f"{place}: the id {question.id!r} stands there twice")
        questions[question.id] = question
    if not questions:
        raise InputError(f"{file}: expected at least one question")
    return tuple(questions.values()), hashlib.sha256(content).hexdigest()


_SPACE = re.compile(r"\s+")
_WORDS = {Form.YES_NO: re.compile(r"\b(yes|no)\b", re.IGNORECASE), Form.CHOICE: re.compile(r"\b([A-D])\b")}


@dataclass(frozen=True, slots=True)
class _Graded:
    """How right an answer is.

    Attributes:
        exact: whether it is right in all that is asked.
        counts: answers that are right, that are wrong, and that are missed; where any of several is wanted,
            no more than one is missed.
        readable: whether it could be read.
        repairs: the names of the repairs that reading it took.
    """

    exact: bool
    counts: Confusion
    readable: bool = True
    repairs: tuple[str, ...] = ()


def grade(question: Question, text: str) -> _Graded:
    """How right an answer is; one that cannot be read is wrong."""
    wanted = {_plain(each) for each in question.answer}
    found = _read(question.form, text)
    parts, repairs = found or ((), ())
    given = set(map(_plain, parts))
    right, asks_one = len(given & wanted), question.accept == "any"
    missed = (min(1, len(wanted)) if asks_one else len(wanted)) - right
    exact = right == len(given) == 1 if asks_one else given == wanted
    counts = Confusion(right, len(given) - right, max(0, missed))
    return _Graded(exact and found is not None, counts, found is not None, repairs)


def gold_text(question: Question) -> str:
    """A right answer, as a model would write it."""
    parts = question.answer[:1] if question.accept == "any" else question.answer
    if question.form is not Form.OPEN:
        return parts[0]
    return "[" + ", ".join([f'"{part}"' for part in parts]) + "]"


def _read(form: Form, text: str) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """The parts of an answer and the repairs it took; None if it is none."""
    if form is Form.OPEN:
        reading = read_json(text, _LIST)
        return None if isinstance(reading, Unreadable) else (reading.value, reading.repairs)
    rest = split_reasoning(text)[0].strip()
    found = {word.casefold() for word in _WORDS[form].findall(rest)}
    if len(found) != 1:
        return None
    (word,) = found
    alone = rest.strip(" .*`\"'()[]").casefold() == word
    return (word,), () if alone else ("prose",)


def _strings(value: object) -> tuple[str, ...] | None:
    if isinstance(value, list) and all(isinstance(part, str | int) for part in value):
        return tuple(map(str, value))
    return None


_LIST: AnswerForm[tuple[str, ...]] = AnswerForm("list of names", _strings, is_part=holds_strings)


def _plain(text: str) -> str:
    """A part of an answer without spaces, in small letters."""
    return _SPACE.sub("", text).casefold()
