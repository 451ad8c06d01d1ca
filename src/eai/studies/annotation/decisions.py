"""Decisions: what people chose as the meaning of each title, in a TOML file that they may also edit by hand.

    without = ["NEXT_TO"]

    [title."Wash clothes"]
    dropped = ["CLOSED(cupboard)"]
    candidates = [
      [
        ["ON(washing_machine)"],
        ["ONTOP({GRABBABLE, MOVABLE, CREAM}, washing_machine)", "ONTOP(soap, washing_machine)"],
      ],
    ]

A candidate is a list of entries, an entry a list of patterns of which one must be met.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

from eai.abilities.options import misfit
from eai.data.files import write_whole
from eai.errors import InputError
from eai.studies.annotation.abstract import Candidate, Title
from eai.studies.annotation.pattern import Entry, Pattern, read_pattern

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@dataclass(frozen=True, slots=True)
class Chosen:
    """What was decided of one title.

    Attributes:
        candidates: in the order in which they are tried.
        dropped: what means nothing.
    """

    candidates: tuple[Candidate, ...] = ()
    dropped: tuple[Pattern, ...] = ()

    @property
    def decided(self) -> frozenset[Pattern]:
        """All patterns that were kept or dropped."""
        entries = [entry for candidate in self.candidates for entry in candidate.entries]
        return frozenset(self.dropped).union(*entries)


@dataclass(frozen=True, slots=True)
class Decisions:
    """All that was decided.

    Attributes:
        without: predicates that are not counted, because they hold of too much.
        titles: by name.
    """

    without: tuple[str, ...] = ()
    titles: Mapping[str, Chosen] = field(default_factory=dict)

    def of(self, title: str) -> Title:
        """The abstract goal of a title; without candidates where nothing was decided."""
        return Title(title, self.titles.get(title, Chosen()).candidates)

    def deciding(self, title: str, chosen: Chosen) -> Decisions:
        """The same with other decisions about one title."""
        return replace(self, titles={**self.titles, title: chosen})


@dataclass(frozen=True, slots=True)
class _Table:
    """A title as a file has it."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    candidates: list[list[list[str]]] = field(default_factory=list)
    dropped: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _File:
    """A file of decisions."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    without: list[str] = field(default_factory=list)
    title: dict[str, _Table] = field(default_factory=dict)


_MEMBERS = ("without", "title", "candidates", "dropped")
"""What a file of decisions may speak of."""


def read_decisions(path: Path) -> Decisions:
    """The decisions in a file; none if there is no such file.

    Raises:
        InputError: it is not one of decisions; the message names the place.
    """
    if not path.exists():
        return Decisions()
    try:
        found = TypeAdapter(_File).validate_python(tomllib.loads(path.read_text(encoding="utf-8")))
    except ValidationError as error:
        raise InputError(f"{path}: {misfit(error, _MEMBERS)}") from error
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: {error}") from error
    titles = {}
    for name, table in found.title.items():
        try:
            candidates = tuple(Candidate(tuple(map(_entry, entries))) for entries in table.candidates)
            titles[name] = Chosen(candidates, tuple(map(read_pattern, table.dropped)))
        except InputError as error:
            raise InputError(f"{path}: title {name!r}: {error}") from error
    return Decisions(tuple(found.without), titles)


def _entry(texts: list[str]) -> Entry:
    patterns = tuple(map(read_pattern, texts))
    if not patterns:
        raise InputError("an entry is empty")
    if len({pattern.is_action for pattern in patterns}) > 1:
        raise InputError(f"{' or '.join(texts)}: an action is no alternative to a state of the world")
    return patterns


def write_decisions(path: Path, decisions: Decisions) -> None:
    """Write the decisions so that the file is whole at every moment: the old one or the new one.

    Raises:
        InputError: it cannot be written.
    """
    write_whole({path: decisions_text(decisions)})


def decisions_text(decisions: Decisions) -> str:
    """The decisions as a file has them, an entry a line."""
    lines = [f"without = {_strings(decisions.without)}"]
    for name, chosen in decisions.titles.items():
        lines += [
            "",
            f"[title.{json.dumps(name)}]",
            f"dropped = {_strings(chosen.dropped)}",
            "candidates = [",
        ]
        for candidate in chosen.candidates:
            lines += ["  [", *(f"    {_strings(entry)}," for entry in candidate.entries), "  ],"]
        lines.append("]")
    return "\n".join(lines) + "\n"


def _strings(values: tuple[Pattern, ...] | tuple[str, ...]) -> str:
    """A list of texts on one line; the strings of JSON are strings of TOML."""
    return json.dumps([str(value) for value in values])
