"""Gold answers spoilt at random: what the built-in model `eai/noisy` says, and mends where it is told to."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from eai.benchmark.gold_answers import AnswerBook, WrittenAnswer
from eai.prompts.feedback import REASONS


@dataclass(frozen=True, slots=True)
class Noise:
    """How often parts of an answer are spoilt, and the seed of it."""

    rate: float
    seed: str


class Segment(NamedTuple):
    """Parts of a gold answer that belong together, and what stands in their place."""

    gold: tuple[str, ...]
    written: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SpoiltAnswer:
    """A gold answer of which parts are spoilt; what is spoilt can be mended from the front."""

    segments: tuple[Segment, ...]
    join: Callable[[Iterable[str]], str]

    def versions(self) -> Iterator[WrittenAnswer]:
        """The answer as it is, then with one more spoilt segment mended each time, up to the gold answer."""
        segments = list(self.segments)
        yield self._answer(segments)
        for number, (gold, written) in enumerate(segments):
            if gold != written:
                segments[number] = Segment(gold, gold)
                yield self._answer(segments)

    def _answer(self, segments: Iterable[Segment]) -> WrittenAnswer:
        return WrittenAnswer(tuple([part for each in segments for part in each.written]), self.join)


def noisy_answer(book: AnswerBook, task_id: str, noise: Noise) -> WrittenAnswer:
    """A gold answer in which parts are spoilt, each by itself: a pure function of the arguments.

    A spoilt part is dropped, repeated, swapped with the next, or replaced by a part of another task's answer.
    """
    return next(spoil(book, task_id, noise).versions())


def heeding_answer(
    book: AnswerBook, task_id: str, question: str, attempt: int, noise: Noise, heed: float
) -> WrittenAnswer:
    """The answer of a noisy model that mends what it is told of, and nothing else.

    If the question contains its last answer and a reason after it, it mends the first spoilt part of that
    answer with probability ``heed``; otherwise it says the same again.
    """
    versions = list(spoil(book, task_id, noise).versions())
    said = [(question.rfind(version.text), number) for number, version in enumerate(versions)]
    place, last = max(said)
    if attempt == 1 or place < 0:
        return versions[0]
    is_told = REASONS in question[place + len(versions[last].text) :]
    heeds = is_told and _generator(f"{noise.seed} {attempt}", task_id).random() < heed
    return versions[min(last + heeds, len(versions) - 1)]


def spoil(book: AnswerBook, task_id: str, noise: Noise) -> SpoiltAnswer:
    """A gold answer in which parts are spoilt, with what they were."""
    rng = _generator(noise.seed, task_id)
    answer = book.gold(task_id)
    segments: list[Segment] = []
    pending = list(answer.parts)
    while pending:
        part = pending.pop(0)
        if rng.random() >= noise.rate:
            segments.append(Segment((part,), (part,)))
            continue
        match rng.choice(("drop", "repeat", "swap", "replace")):
            case "repeat":
                segments.append(Segment((part,), (part, part)))
            case "swap" if pending:
                other = pending.pop(0)
                segments.append(Segment((part, other), (other, part)))
            case "swap" | "replace":
                foreign = book.gold(rng.choice(book.task_ids)).parts
                segments.append(Segment((part,), (rng.choice(foreign) if foreign else part,)))
            case _:
                segments.append(Segment((part,), ()))
    return SpoiltAnswer(tuple(segments), answer.join)


def _generator(seed: str, task_id: str) -> random.Random:
    return random.Random(hashlib.sha256(f"{seed} {task_id}".encode()).digest())  # noqa: S311 - noise, not secrets
