"""Taking an answer apart: reasoning that stands in its text, and the end that a stop sequence cut off."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

_OPEN, _CLOSE = "<think>", "</think>"


class Parts(NamedTuple):
    """What a model wrote, and what was done to part it.

    Attributes:
        answer: the text without reasoning.
        reasoning: the reasoning without its tags, or empty.
        repairs: names of what was done, in order.
    """

    answer: str
    reasoning: str
    repairs: tuple[str, ...]


def part(text: str) -> Parts:
    """Separate reasoning between ``<think>`` tags.

    The opening tag may be missing, since many chat templates put it into the question. If the closing one is
    missing behind an opening one, all of the text is reasoning and there is no answer.
    """
    reasoning, closed, answer = text.rpartition(_CLOSE)
    if closed:
        return Parts(answer.strip(), reasoning.replace(_OPEN, "", 1).strip(), ("reasoning",))
    if text.lstrip().startswith(_OPEN):
        return Parts("", text.lstrip().removeprefix(_OPEN).strip(), ("reasoning",))
    return Parts(text, "", ())


def complete(parts: Parts, stop: Sequence[str]) -> Parts:
    """Give back the closing brace that a stop sequence took away, as the published answers have it."""
    if "}" not in stop or parts.answer.count("{") <= parts.answer.count("}"):
        return parts
    return parts._replace(answer=parts.answer + "}", repairs=(*parts.repairs, "stop_sequence"))
