"""Protocols are found by name, and the package does without those that are taken out of it."""

from __future__ import annotations

import sys
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import Any

import pytest

import eai
from eai.abilities.protocol import (
    BUILT_IN,
    GROUP,
    PROTOCOLS,
    PROTOCOLS_BUILT_IN,
    Ability,
    Protocol,
    registered_protocols,
)
from eai.benchmark import protocols
from eai.benchmark.suite import open_suite
from eai.data import entry_points
from eai.errors import InputError

SOURCE = Path(eai.__file__).parent
METADATA = SOURCE.parents[1] / "pyproject.toml"


def declared(group: str) -> dict[str, str]:
    """The entry points of a group that the package declares."""
    tomllib: Any = pytest.importorskip("tomllib" if sys.version_info >= (3, 11) else "tomli")
    if not METADATA.is_file():
        pytest.skip("the package is installed, not a source tree")
    return dict(tomllib.loads(METADATA.read_text(encoding="utf-8"))["project"]["entry-points"][group])


@pytest.mark.parametrize(("group", "built_in"), [(GROUP, BUILT_IN), (PROTOCOLS, PROTOCOLS_BUILT_IN)])
def test_what_is_built_in_is_what_the_package_declares(group: str, built_in: dict[str, str]) -> None:
    assert declared(group) == built_in


def test_protocols_are_found_by_name() -> None:
    assert [*registered_protocols()] == ["eai-1.0.5"]
    assert isinstance(protocols.implementation_of("eai-1.0.5"), protocols.Implementation)
    assert protocols.implementation_of("eai-1.0.6") is None


def test_another_distribution_adds_one(monkeypatch: pytest.MonkeyPatch) -> None:
    theirs = EntryPoint("theirs", "theirs.rules:RULES", PROTOCOLS)
    gone = EntryPoint("gone", "eai.no_such_package.rules:RULES", PROTOCOLS)
    monkeypatch.setattr(entry_points, "_installed", lambda path: EntryPoints([theirs, gone]))
    found = entry_points.entry_points_of(PROTOCOLS, PROTOCOLS_BUILT_IN)
    assert list(found) == ["eai-1.0.5", "theirs"]


def test_a_benchmark_that_a_protocol_does_not_score_is_refused() -> None:
    with pytest.raises(InputError, match=r"virtualhome-rules is not scored under eai-1\.0\.5"):
        open_suite("rules:virtualhome", Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5"))
