"""Tests that only few folders name a household or the default protocol."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import eai

SOURCE = Path(eai.__file__).parent
HOMES = ("benchmarks", "extensions")
"""Folders that may name a household."""

HOUSEHOLD = re.compile(r"virtualhome|\bbehavior\b", re.IGNORECASE)
PROTOCOL = re.compile(r"\bProtocol(\.[A-Z]|\([\"'])")

EXAMPLES = frozenset(
    {
        "__init__.py",
        "cli/console.py",
        "cli/export.py",
        "cli/generate.py",
        "cli/demo.py",
        "cli/run.py",
        "cli/score.py",
        "cli/serve.py",
    }
)
"""Files that name households as examples in help, or in the paper's order."""

DEFAULTS = frozenset({"abilities/protocol.py", "benchmarks/suite.py", "cli/score.py", "cli/run.py"})
"""Files that may name the default protocol."""


def mentions(pattern: re.Pattern[str], allowed: frozenset[str], homes: tuple[str, ...] = HOMES) -> list[str]:
    """List every line outside some folders in which a pattern is found."""
    return [
        f"{place}:{number}: {line.strip()}"
        for path in sorted(SOURCE.rglob("*"))
        if path.suffix in (".py", ".js", ".html")
        and (place := path.relative_to(SOURCE).as_posix()).partition("/")[0] not in homes
        and place not in allowed
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if pattern.search(line)
    ]


def test_households_are_named_at_home_alone() -> None:
    assert mentions(HOUSEHOLD, EXAMPLES) == []


def test_nobody_else_asks_which_protocol_is_in_force() -> None:
    assert mentions(PROTOCOL, DEFAULTS, ("extensions",)) == []


@pytest.mark.parametrize(
    ("pattern", "text"),
    [(HOUSEHOLD, "a task of VirtualHome"), (PROTOCOL, 'suite.protocol is Protocol("strict")')],
)
def test_the_patterns_find_what_they_look_for(pattern: re.Pattern[str], text: str) -> None:
    assert pattern.search(text)


def test_no_docstring_begins_with_what() -> None:
    """The first word of a docstring is a noun, a verb or a number."""
    assert mentions(re.compile(r'^\s*r?"""What\b'), frozenset(), ()) == []
