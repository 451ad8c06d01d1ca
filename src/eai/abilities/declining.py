"""Answers that decline a task: they call it impossible, or ask which object is meant."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple

from eai.abilities.answer_text import ANY_VALUE, JsonObject, ParsedAnswer, read_json
from eai.tasks.special import Ambiguous, Impossible

if TYPE_CHECKING:
    from eai.abilities.notation.plans import PlanNotation
    from eai.tasks.task import Task

IMPOSSIBLE, QUESTION = "impossible", "ask"
"""Member of an answer that calls a task impossible, and member of an answer that asks a question."""

ASK, REFUSE = "ASK", "IMPOSSIBLE"
"""Command that asks which object is meant, and command that calls the task impossible."""


class _Declining(NamedTuple):
    """An answer that declines a task.

    Attributes:
        reason: the reason why the task is impossible, or the question.
        is_right: whether it is right to decline.
        notes: the answer in words, and the evidence for or against it.
    """

    reason: str
    is_right: bool
    notes: tuple[str, str]


def read_declining(task: Task, text: str, notation: PlanNotation) -> _Declining | None:
    """Read an answer that declines a task. Returns None for other answers, and if the task allows none."""
    match task.special:
        case Impossible(missing):
            member, said, is_right = IMPOSSIBLE, "said to be impossible", bool(missing)
            evidence = f"missing: {', '.join(missing or ('nothing',))}"
        case Ambiguous(fits):
            member, said, is_right = QUESTION, "asked", len(fits) > 1
            evidence = f"the instruction fits {' and '.join(fits)}"
        case _:
            return None
    reason = reason_of(notation.decode_names(text), member)
    return None if reason is None else _Declining(reason, is_right, (f"{said}: {reason}", evidence))


def right_declining(task: Task, notation: PlanNotation) -> str | None:
    """Return the right answer to a task that is to be declined, or None if a plan is right."""
    match task.special:
        case Impossible(missing) if missing:
            return refusal(notation.encode_names(", ".join(missing)))
        case Ambiguous(fits) if len(fits) > 1:
            return refusal(f"{' or '.join(fits)}?", QUESTION)
    return None


def right_refusal(task: Task, notation: PlanNotation) -> str | None:
    """Return the command that refuses a task with the missing facts, or None if it has a plan."""
    match task.special:
        case Impossible(missing) if missing:
            return notation.encode_names(f"{REFUSE}({', '.join(missing)})")
    return None


def declining_commands(task: Task) -> list[str]:
    """Return the command that declines a task, if there is one."""
    words = {Impossible: REFUSE, Ambiguous: ASK}
    return [word for kind, word in words.items() if isinstance(task.special, kind)]


def refusal(reason: str, how: str = IMPOSSIBLE) -> str:
    """The answer that a task is impossible for a reason, or (`QUESTION`) a question about it."""
    return json.dumps({how: reason})


def reason_of(text: str, how: str = IMPOSSIBLE) -> str | None:
    """Return why a task is impossible, or the question that an answer asks instead of a plan.

    None if the last JSON value of the answer is not an object with this one member.
    """
    reading = read_json(text, ANY_VALUE)
    value = reading.value if isinstance(reading, ParsedAnswer) else None
    members = value.members if isinstance(value, JsonObject) else ()
    reasons = [reason for name, reason in members if name == how and isinstance(reason, str)]
    return reasons[0] if len(members) == 1 and reasons else None


def is_question(command: str) -> bool:
    """Whether a command asks what is meant, with any question, as in ``ASK(which one?)``."""
    return _begins_with(ASK, command)


def refusal_in(command: str) -> str | None:
    """Why a task cannot be done, as in ``IMPOSSIBLE(no stove works)``; None of any other command."""
    if not _begins_with(REFUSE, command):
        return None
    return command.partition(REFUSE)[2].strip().removeprefix("(").removesuffix(")").strip()


def _begins_with(word: str, command: str) -> bool:
    return command.split("(")[0].split(maxsplit=1)[:1] == [word]
