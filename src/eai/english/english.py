"""How the tasks of a benchmark are put into English, and what nobody would ask for in it."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from importlib.resources import files
from typing import ClassVar

from pydantic import ConfigDict, TypeAdapter

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

FILE = "english.toml"


@dataclass(frozen=True, slots=True)
class English:
    """The words of a benchmark; a text that says nothing of a predicate or category leaves it to its name.

    Attributes:
        says: sentences that say that a predicate holds, by its name: in the singular, the second word a verb
            of which the plural is known, as in ``{x} is on top of {y}``. The first is the usual one; all mean
            the same, and no sentence of another predicate.
        asks: requests that it be so, by its name, as in ``put {x} on top of {y}``.
        denies: requests that it be not so.
        nouns: what an object of a category is called, in the singular, as in ``pair of jeans``.
        odd: what nobody would ask for by itself, though it occurs: ``predicate category ...``, in which ``*``
            and ``[...]`` stand for anything as in names of files.
        sound: what is not odd after all.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    says: Mapping[str, Sequence[str]] = field(default_factory=dict)
    asks: Mapping[str, Sequence[str]] = field(default_factory=dict)
    denies: Mapping[str, Sequence[str]] = field(default_factory=dict)
    nouns: Mapping[str, str] = field(default_factory=dict)
    odd: Sequence[str] = ()
    sound: Sequence[str] = ()

    def is_odd(self, predicate: str, categories: Sequence[str]) -> bool:
        """Whether nobody would ask that a predicate hold of objects of these categories."""
        told = " ".join((predicate, *categories))
        return any(fnmatchcase(told, each) for each in self.odd) and not any(
            fnmatchcase(told, each) for each in self.sound
        )


PLAIN = English()
"""All words are made of names, and nothing is odd."""


def english_of(package: str) -> English:
    """What the file ``english.toml`` of a package says."""
    text = (files(package) / FILE).read_text(encoding="utf-8")
    return TypeAdapter(English).validate_python(tomllib.loads(text))
