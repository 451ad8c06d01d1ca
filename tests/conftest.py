"""Shared by the tests: the real data set and the reference's verdicts; skipped when absent."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from eai.data.dataset import fetch
from eai.data.store import Store
from eai.errors import DataError

ORACLE = Path(__file__).resolve().parents[2] / "shared" / "oracle"

Oracle = Callable[[str, str, str], Any]
"""(domain, ability, name) -> content of `<domain>/<ability>/<name>.json.gz`."""


@pytest.fixture(scope="session")
def data_store() -> Store:
    """The real data set in the user's default folder, fetched once if it is not there."""
    store = Store()
    try:
        fetch(store)
    except DataError as error:
        pytest.skip(f"the data set cannot be had: {error}")
    return store


@pytest.fixture(scope="session")
def oracle() -> Oracle:
    """Reads one file of the reference's verdicts; skips where the file is not on this machine."""

    def read(domain: str, ability: str, name: str) -> Any:
        path = ORACLE / domain / ability / f"{name}.json.gz"
        if not path.is_file():
            pytest.skip(f"no verdicts of the reference at {path}")
        return json.loads(gzip.decompress(path.read_bytes()))

    return read
