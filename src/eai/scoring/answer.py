"""Answers of a model with what they took, before anything is made of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from eai.abilities.record import Usage
from eai.abilities.verdict import Json


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer of a model.

    Attributes:
        task_id: the data set's id.
        epoch: which of several answers to the task it is, from 1 on.
        request_sha256: digest of all that decides the answer: model, prompt, parameters.
        prompt_sha256: digest of the prompt alone.
        text: the answer without reasoning.
        reasoning: what the model thought before it, or empty.
        stop_reason: why it ended, as Inspect says it: ``stop``, ``max_tokens``, ...
        repairs: names of what was done to the text to separate or complete the answer.
        usage: what it took.
        attempt: in which attempt at the task it was given, from 1 on.
    """

    task_id: str
    epoch: int
    request_sha256: str
    prompt_sha256: str
    text: str
    reasoning: str
    stop_reason: str
    repairs: tuple[str, ...]
    usage: Usage
    attempt: int = 1

    @property
    def truncated(self) -> bool:
        """Whether a limit of length cut it off."""
        return self.stop_reason in ("max_tokens", "model_length")

    def to_json(self) -> dict[str, Json]:
        """The answer as a line of the journal has it."""
        fields: dict[str, Json] = {name: getattr(self, name) for name in self.__slots__}
        return {**fields, "usage": self.usage.to_json()}


Place: TypeAlias = tuple[str, int]
"""Id of the task, and epoch."""
