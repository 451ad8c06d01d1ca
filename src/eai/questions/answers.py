"""Answers to questions: how they are read, and how right they are. Both are pure functions of a text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from eai.abilities.json_text import find_json
from eai.abilities.verdict import Confusion
from eai.questions.question import Accept, Form, Question

_THINKING = re.compile(r"<think>.*?</think>", re.DOTALL)
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
    if found is None:
        missed = min(len(wanted), 1) if question.accept is Accept.ANY else len(wanted)
        return _Graded(False, Confusion(0, 0, missed), readable=False)
    parts, repairs = found
    given = set(map(_plain, parts))
    right = len(given & wanted)
    if question.accept is Accept.ANY:
        exact = right == len(given) == 1
        missed = 0 if right else 1
    else:
        exact = given == wanted
        missed = len(wanted) - right
    return _Graded(exact, Confusion(right, len(given) - right, missed), repairs=repairs)


def gold_text(question: Question) -> str:
    """A right answer, as a model would write it."""
    named = question.answer[:1] if question.accept is Accept.ANY else question.answer
    return _written(question.form, named)


def _written(form: Form, parts: Sequence[str]) -> str:
    if form is not Form.OPEN:
        return parts[0]
    return "[" + ", ".join([f'"{part}"' for part in parts]) + "]"


def _read(form: Form, text: str) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """The parts of an answer and the repairs it took; None if it is none."""
    if form is Form.OPEN:
        return find_json(text, _strings)
    rest = _THINKING.sub("", text).strip()
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


def _plain(text: str) -> str:
    """A part of an answer without spaces, in small letters."""
    return _SPACE.sub("", text).casefold()
