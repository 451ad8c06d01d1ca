"""Attempts: the answers to a task that is tried several times, and the effort that an answer took."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from eai.abilities.explanation import Explanation
from eai.abilities.verdict import PlanVerdict


@dataclass(frozen=True, slots=True)
class Usage:
    """The effort that an answer took. What the provider does not count is None.

    Attributes:
        input_tokens: tokens of the question, those read from a provider's cache included.
        output_tokens: tokens of reasoning and answer.
        reasoning_tokens: tokens of reasoning alone.
        cost: dollars, where prices were given.
        seconds: of waiting for the replies of an episode; other answers are not timed.
    """

    input_tokens: int | None = None
    output_tokens: int | None = None
    reasoning_tokens: int | None = None
    cost: float | None = None
    seconds: float | None = None

    @property
    def tokens(self) -> int | None:
        """Tokens of question and answer, or None if either number is unknown."""
        if self.input_tokens is None or self.output_tokens is None:
            return None
        return self.input_tokens + self.output_tokens

    def __add__(self, other: Usage) -> Usage:
        """Both together; what neither has is not known."""
        sums: dict[str, Any] = {}
        for name in self.__slots__:
            known = [each for each in (getattr(self, name), getattr(other, name)) if each is not None]
            sums[name] = sum(known) if known else None
        return Usage(**sums)


@dataclass(frozen=True, slots=True)
class Attempt:
    """One of several answers to a task, in an experiment that carries them out one after the other.

    Attributes:
        response: the answer as it was scored.
        verdict: what it came to; where the world continues, its goals are those of all attempts so far.
        slipped_at: the first of its steps that slipped, from 0; None if none did.
        goal_held_at: after how many of its steps all goals held for the first time, 0 for at its start; None
            if they never did. It says of a plan that passes through the goal what its end does not.
        prompt_sha256: digest of what was asked, where that is known.
        usage: what the answer took, where that is known.
        answer_repairs: names of what was done to the model's text before it was scored.
        explanation: what became of it in words, where that was asked for.
    """

    response: str
    verdict: PlanVerdict
    slipped_at: int | None = None
    goal_held_at: int | None = None
    prompt_sha256: str | None = None
    usage: Usage | None = None
    answer_repairs: tuple[str, ...] = ()
    explanation: Explanation | None = None
