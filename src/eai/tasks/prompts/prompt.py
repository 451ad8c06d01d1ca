"""Prompts as Python values, and the files in which data sets publish prompts.

A model may have stated wrong goals for a task, or perceived a wrong scene. Its question is then about the
believed task: the task with these goals or this scene. Our own prompts are rendered from the believed task.
In a published prompt, only the section with the goals is replaced. The objects and the initial state in it
are those of the true task, so published prompts cannot describe another scene.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias, TypeVar

from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from eai.base.errors import InputError
from eai.base.files import read_content
from eai.tasks.options import describe_validation_error
from eai.tasks.task import Task

Shape = TypeVar("Shape")


PromptSet: TypeAlias = Literal["official", "eai", "eai-brief", "eai-careful", "short", "facts"]
"""The name of a set of prompts: the prompts published with the data set, or one of our own sets.

``eai``, ``eai-brief``, ``eai-careful`` and ``short`` state the same rules and facts. ``eai-brief`` has few
words and no example, ``eai-careful`` adds a list of questions to think through, and ``short`` has rules in
short notation and facts in short lists. ``facts`` has only the goals and facts of a task, without rules and
instructions.
"""

VARIANTS: Sequence[PromptSet] = ("eai-brief", "eai-careful", "short", "facts")
"""Names of the sets of our prompts other than ``eai``."""


class Image(NamedTuple):
    """A picture: the content of its file and its media type, such as ``image/png``."""

    media_type: str
    data: bytes

    @property
    def data_url(self) -> str:
        """The picture's content as a data URL."""
        return f"data:{self.media_type};base64,{b64encode(self.data).decode()}"


@dataclass(frozen=True, slots=True)
class Prompt:
    """A question to a model.

    Attributes:
        user: the text of the question.
        system: the system message, or None.
        stop: texts at which the paper's runs cut answers off. The answer does not include them.
        turns: the conversation after the question, as pairs of an answer by the model and the reply to it.
            The model answers the last reply.
        images: the pictures that the model sees before the question.
    """

    user: str
    system: str | None = None
    stop: tuple[str, ...] = ()
    turns: tuple[tuple[str, str], ...] = ()
    images: tuple[Image, ...] = ()

    @property
    def sha256(self) -> str:
        """SHA-256 digest of all messages to the model, joined by NUL characters.

        The digest of a picture takes the place of the picture.
        """
        texts = [text for turn in self.turns for text in turn]
        texts += [hashlib.sha256(image.data).hexdigest() for image in self.images]
        messages = [self.user, *texts] if self.system is None else [self.system, self.user, *texts]
        return hashlib.sha256("\0".join(messages).encode("utf-8", "surrogatepass")).hexdigest()


class _ZlibCompressedPromptMapping(Mapping[str, Prompt]):
    """A mapping from ids of tasks to prompts that holds the texts compressed.

    Prompts of one benchmark and one kind of question differ in few words. Compressed with the first prompt as
    dictionary, a prompt takes a twentieth of the memory.

    Args:
        prompts: pairs of a task's id and its prompt, in order.
    """

    def __init__(self, prompts: Iterable[tuple[str, Prompt]]) -> None:
        self._dictionary = b""
        self._packed: dict[str, tuple[bytes, Prompt]] = {}
        for task_id, prompt in prompts:
            text = prompt.user.encode("utf-8", "surrogatepass")
            self._dictionary = self._dictionary or text
            packer = zlib.compressobj(zdict=self._dictionary)
            self._packed[task_id] = packer.compress(text) + packer.flush(), replace(prompt, user="")

    def __getitem__(self, task_id: str) -> Prompt:
        packed, prompt = self._packed[task_id]
        text = zlib.decompressobj(zdict=self._dictionary).decompress(packed)
        return replace(prompt, user=text.decode("utf-8", "surrogatepass"))

    def __iter__(self) -> Iterator[str]:
        return iter(self._packed)

    def __len__(self) -> int:
        return len(self._packed)


def make_memory_saving_prompt_mapping(prompts: Iterable[tuple[str, Prompt]]) -> Mapping[str, Prompt]:
    """Return a mapping from task ids to prompts that takes little memory, given pairs of id and prompt."""
    return _ZlibCompressedPromptMapping(prompts)


def read_prompt_file(path: Path) -> dict[str, str]:
    """Return a mapping from identifiers to the prompts in a file with the format of the paper's package.

    Raises:
        InputError: the file cannot be read, or does not have this format.
    """
    rows = _read_json_file(path, TypeAdapter(list[_PromptFileRow]), 'a list of {"identifier", "llm_prompt"}')
    return {row["identifier"]: row["llm_prompt"] for row in rows}


def read_system_message_file(path: Path) -> str:
    """Return the system message in a JSON file ``{"system_prompt": ...}``.

    Raises:
        InputError: the file cannot be read, or does not have this format.
    """
    return _read_json_file(path, TypeAdapter(_SystemMessage), '{"system_prompt"}')["system_prompt"]


class _PromptFileRow(TypedDict):
    identifier: str
    llm_prompt: str


class _SystemMessage(TypedDict):
    system_prompt: str


def _read_json_file(path: Path, adapter: TypeAdapter[Shape], expected_content: str) -> Shape:
    try:
        return adapter.validate_json(read_content(path))
    except ValidationError as error:
        raise InputError(
            f"{path}: expected {expected_content} ({describe_validation_error(error, whole='the file')})"
        ) from error


@dataclass(frozen=True, slots=True)
class PromptFiles:
    """The prompts for one ability (kind of question) and one benchmark, in the data set's file format.

    Attributes:
        prompts: content of the file of prompts.
        system: content of the file with the system message, or None if the prompts have no system message.
    """

    prompts: bytes
    system: bytes | None

    @staticmethod
    def from_prompts(prompts: Mapping[str, Prompt]) -> PromptFiles:
        """Return prompts as the contents of files in the format of the data set.

        All prompts must have the same system message.
        """
        rows = [{"identifier": task_id, "llm_prompt": prompt.user} for task_id, prompt in prompts.items()]
        system = next((prompt.system for prompt in prompts.values()), None)
        settings = None if system is None else json.dumps({"system_prompt": system}, indent=4).encode()
        return PromptFiles(json.dumps(rows, indent=4).encode(), settings)

    def rewrite_questions(self, rewrite_question: Callable[[str, str], str]) -> PromptFiles:
        """Return the files with corrected questions.

        Args:
            rewrite_question: returns the corrected question, given a prompt's identifier and its question.
        """
        rows = json.loads(self.prompts)
        for row in rows:
            row["llm_prompt"] = rewrite_question(row["identifier"], row["llm_prompt"])
        return replace(self, prompts=json.dumps(rows, indent=4).encode())

    def read_prompts(self, find_task_id: Callable[[str], str | None]) -> dict[str, Prompt]:
        """Return a mapping from task ids to prompts, in the order of the file.

        ``find_task_id`` returns the task id for a prompt's identifier, or None to keep the identifier.
        """
        settings = {} if self.system is None else json.loads(self.system)
        system, stop = settings.get("system_prompt"), tuple(settings.get("stop_sequences", ()))
        rows = [(row["identifier"], row["llm_prompt"]) for row in json.loads(self.prompts)]
        return {find_task_id(name) or name: Prompt(question, system, stop) for name, question in rows}


INITIAL_PLACEHOLDER = "$initial"
"""Placeholder in questions that stands for the facts of the initial state."""


@dataclass(frozen=True, slots=True)
class BelievedTask:
    """The goals or the scene of a task as a model understands them, which may be wrong.

    Attributes:
        task: the task with the believed goals, or with the scene that the model perceived.
        answer: the model's answer to goal interpretation that states these goals, word for word; empty if the
            goals come from no answer.
        initial: the description of the initial state, in which ``$initial`` stands for its facts.
        images: the pictures that the model sees before the question.
        subgoals: subgoals that the question lists below the goals, in order.
    """

    task: Task
    answer: str = ""
    initial: str = INITIAL_PLACEHOLDER
    images: tuple[Image, ...] = ()
    subgoals: tuple[str, ...] = ()

    def with_goals_of(self, other: BelievedTask) -> BelievedTask:
        """Return this task with the goals of ``other``, and the answer and subgoals that ``other`` has."""
        task, answer = replace(self.task, goals=other.task.goals), other.answer or self.answer
        return replace(self, task=task, answer=answer, subgoals=other.subgoals or self.subgoals)


@dataclass(frozen=True, slots=True)
class GoalSection:
    """The section of published prompts that states the goals of the task.

    Attributes:
        before: the text that stands before the section. Its last occurrence counts, because examples have
            goals, too.
        after: the text that stands after the section.
        write: function that returns the text of the section. It gets the task with the goals that a model
            believes, which may be wrong.
    """

    before: str
    after: str
    write: Callable[[BelievedTask], str]

    def replace_goals_in_question(self, question: str, belief: BelievedTask) -> str:
        """Return a question with the goals of ``belief`` in this section, in place of the task's goals.

        These are goals as a model understands them, such as the goals in its answer to goal interpretation.

        Raises:
            InputError: the question does not have this section of goals.
        """
        start = question.rfind(self.before) + len(self.before)
        end = question.find(self.after, start)
        if start < len(self.before) or end < 0:
            raise InputError(
                f"the prompt has no section of goals between {self.before!r} and {self.after!r}, so a "
                "model's goals cannot be written there; add the section, or use our prompts (prompts.set=eai)"
            )
        return question[:start] + self.write(belief) + question[end:]
