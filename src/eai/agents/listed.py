"""Short lists of facts and objects: names that share a line, and ranges of numbered names.

``CLEAN(*): floor.2..5, mat.9`` states that five objects are clean.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import groupby
from operator import attrgetter
from typing import TypeAlias

from eai.world.state import Fact

HOW_TO_READ = (
    "A line p(*, c): a, b says p(a, c) and p(b, c); a_2..4 stands for a_2, a_3 and a_4. Actions name single"
    " objects."
)
"""Explanation of these lists for agents."""

_LEAST = 3
"""Minimum number of names in a range."""

_MAX_RANGE = 100_000
"""Maximum number of names in a range that is spelled out."""

_NUMBERED = re.compile(r"(.*?)(0|[1-9][0-9]{0,8})", re.DOTALL)
_RANGE = re.compile(r"([^\s,()]+)\.\.([0-9]{1,9})(?![0-9])")
_FACTS = re.compile(r"^(.*\([^()\n]*)\*([^()\n]*\)): (.+)$", re.MULTILINE)
_THINGS = re.compile(r"^([^\[\n]+)( \[[^\]\n]*\]: .*)$", re.MULTILINE)

Write: TypeAlias = Callable[[str, Sequence[str]], str]
"""Writes a sentence that states a predicate of objects with these names."""


@lru_cache(1 << 16)
def _split(name: str) -> tuple[str, int]:
    """Return a name without its number, and the number, or -2 if the name has no number."""
    found = _NUMBERED.fullmatch(name)
    return (name, -2) if found is None else (found[1], int(found[2]))


def in_short(names: Iterable[str]) -> str:
    """Return a list of names, in which names with consecutive numbers become a range."""
    runs: list[list[str]] = []
    for name in names:
        stem, number = _split(name)
        if runs and _split(runs[-1][-1]) == (stem, number - 1):
            runs[-1].append(name)
        else:
            runs.append([name])
    return ", ".join([_run(run) for run in runs])


def _run(names: Sequence[str]) -> str:
    return f"{names[0]}..{_split(names[-1])[1]}" if len(names) >= _LEAST else ", ".join(names)


def facts_in_short(facts: Iterable[Fact], names: Sequence[str], write: Write) -> Iterator[str]:
    """Yield facts as lines; facts that differ only in their first or only in their last object share a line.

    Args:
        facts: the facts, those of a predicate one after the other.
        names: the names of all objects, by index.
        write: writes a fact.
    """
    for predicate, of_predicate in groupby(facts, attrgetter("predicate")):
        by_rest: dict[tuple[int, ...], list[tuple[int, ...]]] = {}
        for fact in of_predicate:
            by_rest.setdefault(fact.arguments[1:], []).append(fact.arguments)
        by_start: dict[tuple[int, ...], list[tuple[int, ...]]] = {}
        for found in by_rest.values():
            if len(found) == 1:
                by_start.setdefault(found[0][:-1], []).append(found[0])
            else:
                yield _line(predicate, found, 0, names, write)
        for found in by_start.values():
            yield _line(predicate, found, -1, names, write)


def _line(
    predicate: str, found: Sequence[tuple[int, ...]], place: int, names: Sequence[str], write: Write
) -> str:
    words = [names[index] for index in found[0]]
    if len(found) == 1:
        return write(predicate, words)
    words[place] = "*"
    return f"{write(predicate, words)}: {in_short([names[each[place]] for each in found])}"


def spelled_out(text: str) -> str:
    """Return an observation with a line for each fact and each object, and without ranges."""
    text = _RANGE.sub(_each_of_range, text)
    text = _FACTS.sub(lambda line: _each(line[3], line[1], line[2]), text)
    return _THINGS.sub(lambda line: _each(line[1], "", line[2]), text)


def _each_of_range(found: re.Match[str]) -> str:
    stem, first = _split(found[1])
    last = int(found[2])
    if first < 0 or last - first >= _MAX_RANGE:
        return found[0]
    return ", ".join([f"{stem}{number}" for number in range(first, last + 1)])


def _each(names: str, before: str, after: str) -> str:
    return "\n".join([f"{before}{name}{after}" for name in names.split(", ")])
