from __future__ import annotations

from pathlib import Path

import pytest

from cli.test_extras import bare, must_name_the_extra, place
from eai.base.store import DataPackStore

SHARED = (place,)
"""The fixture of a folder with files that commands read."""


@pytest.mark.parametrize(
    ("options", "extra"),
    [
        ("--domain behavior --limit 1 --format rendered", "physics"),
        ("--domain virtualhome --tasks 27_2", "plots"),
    ],
)
def test_a_missing_extra_is_one_line_that_names_it(
    options: str, extra: str, place: Path, data_store: DataPackStore
) -> None:
    must_name_the_extra(f"export pictures {options} --out out", extra, place)


def test_diagrams_as_svg_need_no_extra(place: Path, data_store: DataPackStore) -> None:
    outcome = bare("export pictures --domain virtualhome --tasks 27_2 --out out --format svg", place)
    assert (outcome.status, outcome.err) == (0, "")
