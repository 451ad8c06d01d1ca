"""Prompts as values, and the file in which the reference exchanges them.

Published prompts are those that come with a data set. A question may be about a task as the one who is asked
believes it to be: with other goals or in another scene. Our own prompts are rendered from the believed task.
In published ones the section that states the goals is another, and all else stays: objects and initial state
are those that belong to the true task. How they tell of a scene is their own way, so that they cannot tell
of another one.
"""

from __future__ import annotations

import hashlib
import json
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias, TypeVar

from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from eai.base.errors import InputError
from eai.base.files import read_content
from eai.tasks.options import describe_misfit
from eai.tasks.task import Task

Shape = TypeVar("Shape")


PromptSet: TypeAlias = Literal["official", "eai", "eai-brief", "eai-careful"]
"""The set of prompts: the data set's, or ours, rendered from a domain's declaration, in three wordings.

All three state the same rules and facts. ``eai-brief`` has few words and no example; ``eai-careful`` lists
questions to go through.
"""

VARIANTS: Sequence[PromptSet] = ("eai-brief", "eai-careful")
"""The other wordings of our prompts, which records and tables name."""


class Image(NamedTuple):
    """A picture as the bytes of its file, with their media type, such as ``image/png``."""

    media_type: str
    data: bytes

    @property
    def url(self) -> str:
        """The picture as an address that has all of it."""
        return f"data:{self.media_type};base64,{b64encode(self.data).decode()}"


@dataclass(frozen=True, slots=True)
class Prompt:
    """A question to a model.

    Attributes:
        user: the question.
        system: the system message, or None.
        stop: the sequences at which the paper's runs cut the answer; what ends with one lacks it.
        turns: what was said after the question, if this is a conversation: each answer of the model and the
            reply to it, of which the last is to be answered.
        images: the pictures that are shown before the question.
    """

    user: str
    system: str | None = None
    stop: tuple[str, ...] = ()
    turns: tuple[tuple[str, str], ...] = ()
    images: tuple[Image, ...] = ()

    @property
    def sha256(self) -> str:
        """Digest of all that the model is shown, with a zero between messages; of pictures their digests."""
        said = [text for turn in self.turns for text in turn]
        said += [hashlib.sha256(image.data).hexdigest() for image in self.images]
        messages = [self.user, *said] if self.system is None else [self.system, self.user, *said]
        return hashlib.sha256("\0".join(messages).encode("utf-8", "surrogatepass")).hexdigest()


def read_prompt_file(path: Path) -> dict[str, str]:
    """The prompts of a file in the reference's shape, by identifier.

    Raises:
        InputError: the file cannot be read, or is not of this shape.
    """
    rows = _read(path, TypeAdapter(list[_PromptRow]), 'a list of {"identifier", "llm_prompt"}')
    return {row["identifier"]: row["llm_prompt"] for row in rows}


def read_system_file(path: Path) -> str:
    """The system message of a file ``{"system_prompt"}``.

    Raises:
        InputError: the file cannot be read, or is not of this shape.
    """
    return _read(path, TypeAdapter(_SystemMessage), '{"system_prompt"}')["system_prompt"]


class _PromptRow(TypedDict):
    identifier: str
    llm_prompt: str


class _SystemMessage(TypedDict):
    system_prompt: str


def _read(path: Path, adapter: TypeAdapter[Shape], shape: str) -> Shape:
    """The content of a JSON file of a shape."""
    try:
        return adapter.validate_json(read_content(path))
    except ValidationError as error:
        raise InputError(f"{path}: expected {shape} ({describe_misfit(error, whole='the file')})") from error


@dataclass(frozen=True, slots=True)
class PromptFiles:
    """The prompts of a suite in the files in which the data set ships them.

    Attributes:
        prompts: content of the file of prompts.
        system: content of the file with the system message, or None where the prompts have none.
    """

    prompts: bytes
    system: bytes | None

    @staticmethod
    def from_prompts(prompts: Mapping[str, Prompt]) -> PromptFiles:
        """Prompts in the shape of such files, of which all have the same system message."""
        rows = [{"identifier": task_id, "llm_prompt": prompt.user} for task_id, prompt in prompts.items()]
        system = next((prompt.system for prompt in prompts.values()), None)
        settings = None if system is None else json.dumps({"system_prompt": system}, indent=4).encode()
        return PromptFiles(json.dumps(rows, indent=4).encode(), settings)

    def correct(self, correct: Callable[[str, str], str]) -> PromptFiles:
        """The same files with other questions.

        Args:
            correct: from an identifier and its question to the question that is asked.
        """
        rows = json.loads(self.prompts)
        for row in rows:
            row["llm_prompt"] = correct(row["identifier"], row["llm_prompt"])
        return replace(self, prompts=json.dumps(rows, indent=4).encode())

    def read_prompts(self, task_id_of: Callable[[str], str | None]) -> dict[str, Prompt]:
        """The prompts by the task that an identifier means, in the order of the file."""
        settings = {} if self.system is None else json.loads(self.system)
        system, stop = settings.get("system_prompt"), tuple(settings.get("stop_sequences", ()))
        rows = [(row["identifier"], row["llm_prompt"]) for row in json.loads(self.prompts)]
        return {task_id_of(name) or name: Prompt(question, system, stop) for name, question in rows}


INITIAL_PLACEHOLDER = "$initial"
"""The place in questions for what holds at the start."""


@dataclass(frozen=True, slots=True)
class Belief:
    """The belief that someone has of a task.

    Attributes:
        task: the task with the believed goals, or the perceived scene, in place of its own.
        answer: the answer to goal interpretation that states the goals, word for word; else empty.
        initial: what a question says of the start; ``$initial`` stands for what holds there.
        images: the pictures that go with a question.
        subgoals: subgoals that a question states below the goals, in order.
    """

    task: Task
    answer: str = ""
    initial: str = INITIAL_PLACEHOLDER
    images: tuple[Image, ...] = ()
    subgoals: tuple[str, ...] = ()

    def adopt_goals(self, other: Belief) -> Belief:
        """Return the belief in this scene with the goals and subgoals of another belief."""
        task, answer = replace(self.task, goals=other.task.goals), other.answer or self.answer
        return replace(self, task=task, answer=answer, subgoals=other.subgoals or self.subgoals)


@dataclass(frozen=True, slots=True)
class GoalSection:
    """Where the published prompts of a suite state the goals of the task, and how.

    Attributes:
        before: what stands before the section; its last occurrence counts, as examples have goals too.
        after: what stands after it.
        write: the section for a belief.
    """

    before: str
    after: str
    write: Callable[[Belief], str]

    def find(self, question: str) -> str:
        """The section of a question.

        Raises:
            InputError: it has none.
        """
        start, end = self._find_range(question)
        return question[start:end]

    def replace(self, question: str, belief: Belief) -> str:
        """The question with the section for a belief in place of its own.

        Raises:
            InputError: it has none.
        """
        start, end = self._find_range(question)
        return question[:start] + self.write(belief) + question[end:]

    def _find_range(self, question: str) -> tuple[int, int]:
        start = question.rfind(self.before) + len(self.before)
        end = question.find(self.after, start)
        if start < len(self.before) or end < 0:
            raise InputError(f"a prompt has no goals between {self.before!r} and {self.after!r}")
        return start, end
