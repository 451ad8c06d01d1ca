"""An attempt (one of several answers to a task), and the usage of an answer: its tokens, cost and time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from eai.abilities.explanation import VerdictExplanation
from eai.abilities.verdict import PlanVerdict


@dataclass(frozen=True, slots=True)
class AnswerUsage:
    """Tokens, cost and time of an answer. A number that the provider does not report is None.

    Attributes:
        input_tokens: tokens of the question, including those read from a provider's cache.
        output_tokens: tokens of the model's output, reasoning included.
        reasoning_tokens: tokens of the reasoning in the output.
        cost: cost in dollars, if the provider's prices are known.
        seconds: seconds that a game waited for the model's replies; None for answers outside of games.
    """

    input_tokens: int | None = None
    output_tokens: int | None = None
    reasoning_tokens: int | None = None
    cost: float | None = None
    seconds: float | None = None

    @property
    def tokens(self) -> int | None:
        """Number of tokens of question and answer, or None if either number is unknown."""
        if self.input_tokens is None or self.output_tokens is None:
            return None
        return self.input_tokens + self.output_tokens

    def __add__(self, other: AnswerUsage) -> AnswerUsage:
        """Return the sums of tokens, cost and time. A number that is None in both operands stays None."""
        sums: dict[str, Any] = {}
        for name in self.__slots__:
            numbers = [number for number in (getattr(self, name), getattr(other, name)) if number is not None]
            sums[name] = sum(numbers) if numbers else None
        return AnswerUsage(**sums)


@dataclass(frozen=True, slots=True)
class Attempt:
    """An answer to a task for which a model may give several answers, one after the other.

    Attributes:
        response: the answer as it was scored.
        verdict: the verdict on the answer. If each attempt begins in the state in which the previous attempt
            ended, goals are tested on all attempts so far together.
        slipped_at: number of the first step that slipped (was possible, but had no effect), from 0; None if
            no step slipped.
        goal_held_at: number of steps after which all goals held for the first time, 0 for the start of the
            attempt; None if they never held together. A plan may reach the goal and undo it again.
        prompt_sha256: SHA-256 digest of the question, if known.
        usage: tokens and time of the answer, if known.
        answer_repairs: names of the changes that were made to the model's text before scoring.
        explanation: the verdict in words, if the user asked for such an explanation.
    """

    response: str
    verdict: PlanVerdict
    slipped_at: int | None = None
    goal_held_at: int | None = None
    prompt_sha256: str | None = None
    usage: AnswerUsage | None = None
    answer_repairs: tuple[str, ...] = ()
    explanation: VerdictExplanation | None = None
