from __future__ import annotations

from pathlib import Path

from cli.test_extras import must_name_the_extra, place
from eai.base.store import DataPackStore

SHARED = (place,)
"""The fixture of a folder with files that commands read."""


def test_a_missing_extra_is_one_line_that_names_it(place: Path, data_store: DataPackStore) -> None:
    must_name_the_extra("export croissant --out out", "croissant", place)
