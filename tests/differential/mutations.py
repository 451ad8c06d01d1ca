"""Seeded random changes that turn an answer into one that no model would write.

Equal seeds give equal changes.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from typing import TypeAlias, TypeVar

_T = TypeVar("_T")


class Dice:
    """A seeded source of random choices."""

    def __init__(self, seed: str) -> None:
        self._random = random.Random(seed)

    def chance(self, probability: float) -> bool:
        """Return True with this probability."""
        return self._random.random() < probability

    def one(self, values: Sequence[_T]) -> _T:
        """Return a random value."""
        return self._random.choice(values)

    def below(self, end: int) -> int:
        """Return a random number from 0 to below `end`, or 0 if `end` is 0."""
        return self._random.randrange(end) if end > 0 else 0

    def few(self, mean: float) -> int:
        """Return a small random number with this mean."""
        number = 0
        while self.chance(mean / (1 + mean)):
            number += 1
        return number

    def shuffled(self, values: Sequence[_T]) -> list[_T]:
        """Return the values in random order."""
        return self._random.sample(values, len(values))


Change: TypeAlias = Callable[[Dice, str], str]
"""A change of a text."""

JUNK: Sequence[str] = (
    *"{}[]()\"'`,:;.\\/#|<>-_?= \n\t\r0aZ",
    "\u00e9",
    "\u201c",
    "\u2019",
    "\u00a0",
    "\u2028",
    "\u0130",
    "\u00df",
)
"""Characters that are inserted into texts."""

EMPTY = ("", " ", "\n", "null", "[]", "{}", '""', "0", "None", "```json```", "{\n}", "[{}]", "{[]}", "true")
"""Answers without content."""

FENCES = (
    "```json\n{}\n```",
    "```json{}```",
    "```\n{}\n```",
    " ```json\n{}\n```",
    "```JSON\n{}\n```",
    "```json\n{}",
    "{}\n```",
    "`{}`",
    "```json\n{}\n```\nI hope that this helps.",
)
PROSE = (
    "Here is the answer:\n{}",
    "{}\n\nThis plan's steps follow the rules [1].",
    "<think>{{maybe}} [not] this</think>\n{}",
    "[Answer] {}",
    "{{}} {}",
    "{}{}",
    "{} {}",
    '{{"answer": {}}}',
    '{{"output": {}}}',
    "[{}]",
    "{}<|eot_id|>",
    "\ufeff{}",
    "{}}}",
    "{}]",
)


def corrupted(dice: Dice, text: str) -> str:
    """Return a text with one to a few changes."""
    for _ in range(1 + dice.few(0.4)):
        text = dice.one(_CHANGES)(dice, text)
    return text


def slightly_corrupted(dice: Dice, text: str, probability: float) -> str:
    """Return a text, corrupted with some probability."""
    return corrupted(dice, text) if dice.chance(probability) else text


def rearranged(dice: Dice, parts: Sequence[_T], more: Callable[[], _T], mean: float = 1.5) -> list[_T]:
    """Return the parts with random changes: some are dropped, repeated, exchanged, replaced or added."""
    found = list(parts)
    for _ in range(dice.few(mean)):
        place = dice.below(len(found))
        match dice.below(9) if found else 8:
            case 0 | 1:
                del found[place]
            case 2:
                found.insert(place, found[place])
            case 3 | 4:
                other = dice.below(len(found))
                found[place], found[other] = found[other], found[place]
            case 5:
                found[place] = more()
            case 6:
                found = dice.one((found[: place + 1], found[::-1], dice.shuffled(found)))
            case _:
                found.insert(place, more())
    return found


def _template(dice: Dice, text: str, templates: Sequence[str]) -> str:
    template = dice.one(templates)
    filled = template.replace("{{", "\0").replace("}}", "\1").replace("{}", text)
    return filled.replace("\0", "{").replace("\1", "}")


def _fenced(dice: Dice, text: str) -> str:
    return _template(dice, text, FENCES)


def _in_prose(dice: Dice, text: str) -> str:
    return _template(dice, text, PROSE)


def _without_a_character(dice: Dice, text: str) -> str:
    place = dice.below(len(text))
    return text[:place] + text[place + 1 :]


def _without_a_sign(dice: Dice, text: str) -> str:
    """Return a text without one of its structural characters."""
    places = [place for place, sign in enumerate(text) if sign in "{}[]()\",:'"]
    if not places:
        return text
    place = dice.one(places)
    return text[:place] + text[place + 1 :]


def _with_junk(dice: Dice, text: str) -> str:
    place = dice.below(len(text) + 1)
    return text[:place] + dice.one(JUNK) + text[place:]


def _with_another_sign(dice: Dice, text: str) -> str:
    place = dice.below(len(text))
    return text[:place] + dice.one(JUNK) + text[place + 1 :]


def _cut_off(dice: Dice, text: str) -> str:
    place = dice.below(len(text))
    return dice.one((text[:place], text[place:]))


def _without_a_piece(dice: Dice, text: str) -> str:
    place = dice.below(len(text))
    return text[:place] + text[place + 1 + dice.below(20) :]


def _with_a_piece_twice(dice: Dice, text: str) -> str:
    place = dice.below(len(text))
    end = place + 1 + dice.below(30)
    return text[:end] + text[place:end] + text[end:]


def _in_another_case(dice: Dice, text: str) -> str:
    if dice.chance(0.3):
        return dice.one((text.lower(), text.upper()))
    place = dice.below(len(text))
    end = place + 1 + dice.below(10)
    return text[:place] + text[place:end].swapcase() + text[end:]


def _with_other_quotes(dice: Dice, text: str) -> str:
    return text.replace('"', dice.one(("'", "\u201c", '\\"', "`", '""', "")))


def _with_other_blanks(dice: Dice, text: str) -> str:
    return text.replace(" ", dice.one(("", "  ", "\n", "\t", "\u00a0", "\r\n")))


def _with_other_brackets(dice: Dice, text: str) -> str:
    old, new = dice.one(
        (("}", "}}"), ("{", "{{"), ("[", "("), ("]", ")"), ("[", "{"), ("]", "]]"), ("(", "( "))
    )
    return text.replace(old, new)


def _emptied(dice: Dice, text: str) -> str:
    return dice.one(EMPTY)


_CHANGES: tuple[Change, ...] = (
    _fenced,
    _fenced,
    _in_prose,
    _in_prose,
    _without_a_character,
    _without_a_sign,
    _without_a_sign,
    _with_junk,
    _with_junk,
    _with_another_sign,
    _cut_off,
    _without_a_piece,
    _with_a_piece_twice,
    _in_another_case,
    _with_other_quotes,
    _with_other_blanks,
    _with_other_brackets,
    _emptied,
)
