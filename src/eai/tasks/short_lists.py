"""Shorten lists of facts and objects: facts share a line, and consecutive numbers in names become a range.

``CLEAN(*): floor.2..5, mat.9`` states that five objects are clean: floor.2 to floor.5, and mat.9.
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
"""Explanation of shortened lists, for the agents that read them."""

_MIN_RANGE = 3
"""Minimum number of consecutively numbered names that are written as a range."""

_MAX_RANGE = 100_000
"""Maximum number of names that one range in a list, such as ``cup_1..9``, may stand for."""

_NUMBERED = re.compile(r"([^\s,()]*?)(0|[1-9][0-9]{0,8})")  # `_RANGE` reads the same stems
_RANGE = re.compile(r"([^\s,()]+)\.\.([0-9]{1,9})(?![0-9])")
_FACTS = re.compile(r"^(.*\([^()\n]*)\*([^()\n]*\)): (.+)$", re.MULTILINE)
_THINGS = re.compile(r"^([^\[\n]+)( \[[^\]\n]*\]: .*)$", re.MULTILINE)

FactWriter: TypeAlias = Callable[[str, Sequence[str]], str]
"""Function that returns a fact as text, given the name of its predicate and the names of its objects."""


@lru_cache(1 << 16)
def _split_off_number(name: str) -> tuple[str, int]:
    """Return a name without the number at its end, and this number; -2 if no range can contain the name."""
    match = _NUMBERED.fullmatch(name)
    return (name, -2) if match is None else (match[1], int(match[2]))


def join_names_with_number_ranges(names: Iterable[str]) -> str:
    """Return names as one text, in which three or more names with consecutive numbers become a range."""
    runs: list[list[str]] = []
    for name in names:
        stem, number = _split_off_number(name)
        if runs and _split_off_number(runs[-1][-1]) == (stem, number - 1):
            runs[-1].append(name)
        else:
            runs.append([name])
    return ", ".join([_join_consecutively_numbered_names(run) for run in runs])


def _join_consecutively_numbered_names(names: Sequence[str]) -> str:
    return f"{names[0]}..{_split_off_number(names[-1])[1]}" if len(names) >= _MIN_RANGE else ", ".join(names)


def write_similar_facts_on_one_line(
    facts: Iterable[Fact], object_names: Sequence[str], write_fact: FactWriter
) -> Iterator[str]:
    """Yield facts as lines, and combine similar facts in one line.

    Facts share a line if they differ only in their first object, or else only in their last object.

    Args:
        facts: the facts, grouped by predicate.
        object_names: the names of all objects, by index.
        write_fact: returns a fact as text.
    """
    for predicate, of_predicate in groupby(facts, attrgetter("predicate")):
        by_rest: dict[tuple[int, ...], list[tuple[int, ...]]] = {}
        for fact in of_predicate:
            by_rest.setdefault(fact.arguments[1:], []).append(fact.arguments)
        by_start: dict[tuple[int, ...], list[tuple[int, ...]]] = {}
        for rows in by_rest.values():
            if len(rows) == 1:
                by_start.setdefault(rows[0][:-1], []).append(rows[0])
            else:
                yield _write_facts_differing_in_one_argument(predicate, rows, 0, object_names, write_fact)
        for rows in by_start.values():
            yield _write_facts_differing_in_one_argument(predicate, rows, -1, object_names, write_fact)


def _write_facts_differing_in_one_argument(
    predicate: str,
    argument_rows: Sequence[tuple[int, ...]],
    varying_argument_index: int,
    object_names: Sequence[str],
    write_fact: FactWriter,
) -> str:
    words = [object_names[index] for index in argument_rows[0]]
    if len(argument_rows) == 1:
        return write_fact(predicate, words)
    words[varying_argument_index] = "*"
    varying_names = [object_names[row[varying_argument_index]] for row in argument_rows]
    return f"{write_fact(predicate, words)}: {join_names_with_number_ranges(varying_names)}"


def expand_shortened_lists(observation: str) -> str:
    """Return an observation in full: without ranges, and with one line for each fact and each object."""
    text = _RANGE.sub(_expand_range, observation)
    text = _FACTS.sub(lambda line: _write_line_for_each_name(line[3], line[1], line[2]), text)
    return _THINGS.sub(lambda line: _write_line_for_each_name(line[1], "", line[2]), text)


def _expand_range(match: re.Match[str]) -> str:
    stem, first = _split_off_number(match[1])
    last = int(match[2])
    if first < 0 or last - first >= _MAX_RANGE:
        return match[0]
    return ", ".join([f"{stem}{number}" for number in range(first, last + 1)])


def _write_line_for_each_name(joined_names: str, prefix: str, suffix: str) -> str:
    return "\n".join([f"{prefix}{name}{suffix}" for name in joined_names.split(", ")])
