"""Read and write answers that decline a task: they call it impossible, or ask for the meant object."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple

from eai.abilities.answer_text import ANY_VALUE, JsonObject, ParsedAnswer, read_json
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark

if TYPE_CHECKING:
    from eai.abilities.notation.plans import PlanNotation
    from eai.tasks.task import Task

IMPOSSIBLE, QUESTION = "impossible", "ask"
"""Keys of declining answers: `IMPOSSIBLE` calls the task impossible, `QUESTION` asks for the meant object."""

ASK, REFUSE = "ASK", "IMPOSSIBLE"
"""Commands of agents: `ASK` asks for the meant object, and `REFUSE` calls the task impossible."""


class _AnswerThatDeclinesTask(NamedTuple):
    """An answer that declines a task.

    Attributes:
        reason: the reason in the answer why the task is impossible, or the question in the answer.
        is_right: whether declining the task is right.
        notes: two sentences: the answer in words, and the evidence for or against it.
    """

    reason: str
    is_right: bool
    notes: tuple[str, str]


def read_declining_answer(task: Task, text: str, notation: PlanNotation) -> _AnswerThatDeclinesTask | None:
    """Read an answer that declines a task.

    Return None if the answer does not decline, or if the task allows no declining.
    """
    match task.special:
        case PossiblyImpossibleTaskMark(missing):
            member, said, is_right = IMPOSSIBLE, "said to be impossible", bool(missing)
            evidence = f"missing: {', '.join(missing or ('nothing',))}"
        case AmbiguousTaskMark(fits):
            member, said, is_right = QUESTION, "asked", len(fits) > 1
            evidence = f"the instruction fits {' and '.join(fits)}"
        case _:
            return None
    reason = read_refusal_reason(notation.replace_answer_words_by_domain_names(text), member)
    if reason is None:
        return None
    return _AnswerThatDeclinesTask(reason, is_right, (f"{said}: {reason}", evidence))


def write_expected_declining_answer(task: Task, notation: PlanNotation) -> str | None:
    """Return the answer that rightly declines a task, or None if the right answer is a plan."""
    match task.special:
        case PossiblyImpossibleTaskMark(missing) if missing:
            return write_refusal_answer(notation.replace_domain_names_by_answer_words(", ".join(missing)))
        case AmbiguousTaskMark(fits) if len(fits) > 1:
            return write_refusal_answer(f"{' or '.join(fits)}?", QUESTION)
    return None


def write_agent_command_refusing_task(task: Task, notation: PlanNotation) -> str | None:
    """Return the command that refuses an impossible task, or None if the task is not impossible.

    The command names the facts whose absence makes the task impossible.
    """
    match task.special:
        case PossiblyImpossibleTaskMark(missing) if missing:
            return notation.replace_domain_names_by_answer_words(f"{REFUSE}({', '.join(missing)})")
    return None


def list_agent_commands_declining_task(task: Task) -> list[str]:
    """Return a list with the command that declines a task; an empty list if no answer may decline it."""
    words = {PossiblyImpossibleTaskMark: REFUSE, AmbiguousTaskMark: ASK}
    return [word for kind, word in words.items() if isinstance(task.special, kind)]


def write_refusal_answer(reason: str, json_key: str = IMPOSSIBLE) -> str:
    """Return an answer that calls a task impossible, or an answer that asks for the meant object.

    Args:
        reason: the reason why the task is impossible, or the question.
        json_key: the key of the answer: `IMPOSSIBLE` or `QUESTION`.
    """
    return json.dumps({json_key: reason})


def read_refusal_reason(text: str, json_key: str = IMPOSSIBLE) -> str | None:
    """Return the text of a declining answer: the reason for a refusal, or the question.

    The last JSON value of the answer must be an object with the key as its only key. Otherwise the result is
    None.

    Args:
        text: the answer.
        json_key: the key: `IMPOSSIBLE` or `QUESTION`.
    """
    reading = read_json(text, ANY_VALUE)
    value = reading.value if isinstance(reading, ParsedAnswer) else None
    members = value.members if isinstance(value, JsonObject) else ()
    reasons = [reason for name, reason in members if name == json_key and isinstance(reason, str)]
    return reasons[0] if len(members) == 1 and reasons else None


def is_clarification_question(command: str) -> bool:
    """Whether an agent's command is a question, such as ``ASK(which one?)``."""
    return _begins_with(ASK, command)


def read_reason_from_refusal_command(command: str) -> str | None:
    """Return the reason in a command such as ``IMPOSSIBLE(no stove works)``, or None for another command."""
    if not _begins_with(REFUSE, command):
        return None
    return command.partition(REFUSE)[2].strip().removeprefix("(").removesuffix(")").strip()


def _begins_with(command_word: str, command: str) -> bool:
    return command.split("(")[0].split(maxsplit=1)[:1] == [command_word]
