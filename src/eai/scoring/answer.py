"""Answers of a model with what they took, before anything is made of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from eai.abilities.verdict import Json

Number = TypeVar("Number", int, float)


@dataclass(frozen=True, slots=True)
class Usage:
    """What an answer took.

    Attributes:
        input_tokens: tokens of the question, those read from a provider's cache included.
        output_tokens: tokens of reasoning and answer.
        reasoning_tokens: tokens of reasoning alone, where the provider counts them.
        cost: dollars, where prices were given.
    """

    input_tokens: int = 0
    output_tokens: int = 0
    reasoning_tokens: int | None = None
    cost: float | None = None

    def __add__(self, other: Usage) -> Usage:
        """Both together."""
        return Usage(
            self.input_tokens + other.input_tokens,
            self.output_tokens + other.output_tokens,
            _sum(self.reasoning_tokens, other.reasoning_tokens),
            _sum(self.cost, other.cost),
        )

    def to_json(self) -> dict[str, Json]:
        """The usage as journals, records and summaries have it."""
        return {
            "input_tokens": self.input_tokens,
            "output_tokens": self.output_tokens,
            "reasoning_tokens": self.reasoning_tokens,
            "cost": self.cost,
        }


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


def _sum(one: Number | None, other: Number | None) -> Number | None:
    """The sum of what is known, or None."""
    if one is None or other is None:
        return other if one is None else one
    return one + other
