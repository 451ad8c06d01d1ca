from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.pddl.glossary import PddlNames


@given(st.lists(st.text(max_size=6), unique=True, max_size=20))
def test_every_name_has_its_own_and_is_found_by_it(names: list[str]) -> None:
    table = PddlNames(names)
    written = [table[name] for name in names]
    assert len(set(written)) == len(names)
    assert all(re.fullmatch(r"[a-z][a-z0-9_-]*", each) for each in written)
    assert [table.meant(each) for each in written] == names
    assert list(table.items()) == list(zip(names, written, strict=True))


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("on-table", "on-table"),
        ("HOLDS_RH", "holds_rh"),
        ("sofa.352", "sofa_352"),
        ("not", "x-not"),
        ("", "x-"),
    ],
)
def test_what_is_a_name_already_stays_one(name: str, written: str) -> None:
    assert PddlNames()[name] == written


def test_names_that_would_be_equal_get_numbers() -> None:
    names = PddlNames(["On", "on", "ON"])
    assert [names[name] for name in ("On", "on", "ON")] == ["on", "on-2", "on-3"]
    twin = names.copy()
    assert twin["oN"] == "on-4"
    assert "oN" not in names
    with pytest.raises(KeyError):
        names.meant("off")
