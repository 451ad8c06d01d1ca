"""Patterns: what an abstract goal asks for, of objects by their class or by all that they are good for.

Their text is what files of decisions have: ``ON(washing_machine)`` for a state,
``ONTOP({GRABBABLE, MOVABLE}, washing_machine)`` for a relation, ``do TOUCH`` for an action.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TypeAlias

from eai.errors import InputError

_DO = "do "
_ATOM = re.compile(r"(?P<predicate>[^\s(){},]+)\((?P<kinds>.*)\)")
_KIND = re.compile(r"\s*(?:\{(?P<properties>[^{}]*)\}|(?P<name>[^\s(){},]+))\s*(?:,|$)")


@dataclass(frozen=True, slots=True)
class Kind:
    """Objects of a class, or those that have exactly some properties.

    Attributes:
        name: the class; empty if it is properties that count.
        properties: what the objects are good for, in the order in which they are written; two kinds with the
            same ones are one.
    """

    name: str = ""
    properties: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Kind) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[str, frozenset[str]]:
        return self.name, frozenset(self.properties)

    def __str__(self) -> str:
        return self.name or "{" + ", ".join(self.properties) + "}"


@dataclass(frozen=True, slots=True)
class Pattern:
    """A state of one kind of object, a relation of two, or an action.

    Attributes:
        name: of the predicate or action.
        kinds: of what it is said; of an action nothing.
    """

    name: str
    kinds: tuple[Kind, ...] = ()

    @property
    def is_action(self) -> bool:
        """Whether something is to be done."""
        return not self.kinds

    def __str__(self) -> str:
        return _DO + self.name if self.is_action else f"{self.name}({', '.join(map(str, self.kinds))})"


Entry: TypeAlias = tuple[Pattern, ...]
"""What an abstract goal asks for: one of these patterns."""


def read_pattern(text: str) -> Pattern:
    """The pattern that a text is.

    Raises:
        InputError: it is none.
    """
    if text.startswith(_DO) and text.removeprefix(_DO).strip():
        return Pattern(text.removeprefix(_DO).strip())
    atom = _ATOM.fullmatch(text.strip())
    kinds = [] if atom is None else _kinds(atom["kinds"])
    if atom is None or not 1 <= len(kinds) <= 2:
        raise InputError(
            f"{text!r}: expected a pattern such as ON(lamp), ONTOP({{GRABBABLE, MOVABLE}}, table) or do TOUCH"
        )
    return Pattern(atom["predicate"], tuple(kinds))


def _kinds(text: str) -> list[Kind]:
    """The kinds between the brackets; none if they are not written as kinds are."""
    found, place = [], 0
    while place < len(text):
        match = _KIND.match(text, place)
        if match is None:
            return []
        words = match["properties"]
        found.append(
            Kind(match["name"])
            if words is None
            else Kind(properties=tuple(filter(None, (word.strip() for word in words.split(",")))))
        )
        place = match.end()
    return found
