"""Tests of the default set: which values of a parameter it has, and how many examples of a property."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import settings

import sweeps
from by_path import ROOT


def marked(values: list[Any]) -> list[tuple[object, bool]]:
    """Return each value, and whether the default set leaves it out."""
    each = [value if hasattr(value, "marks") else pytest.param(value) for value in values]
    return [(one.values, any(mark.name == "sweep" for mark in one.marks)) for one in each]


def test_the_first_value_alone_is_in_the_default_set() -> None:
    assert marked(sweeps.first_of("abc")) == [(("a",), False), (("b",), True), (("c",), True)]
    assert marked(sweeps.swept(("x", 1), ("y", 2))) == [(("x", 1), True), (("y", 2), True)]
    assert marked(list(sweeps.every(8).args[1])) == [((8,), False), ((1,), True)]


@pytest.mark.parametrize(("profile", "expected"), [("few", 30), ("thorough", 100)])
def test_properties_have_more_examples_where_all_is_tested(
    profile: str, expected: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweeps, "settings", lambda: settings.get_profile(profile))
    assert [sweeps.examples(number) for number in (100, 400)] == [expected, 4 * expected]
    assert settings.get_profile(profile).derandomize


def test_ci_runs_what_the_default_set_leaves_out() -> None:
    commands = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "test-all" in commands
    recipe = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert '-m "not sweep"' in recipe
    assert '-m "sweep or not sweep" --hypothesis-profile=thorough' in recipe
