"""The reference's verdicts on real model answers, read from beside the repository where they are there."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ORACLE = Path(__file__).resolve().parents[2] / "shared" / "oracle"

Oracle = Callable[[str, str, str], Any]
"""(domain, ability, name) -> content of `<domain>/<ability>/<name>.json.gz`."""


def read_oracle(domain: str, ability: str, name: str) -> Any:
    """One file of verdicts; skips the test where the file is not on this machine."""
    path = ORACLE / domain / ability / f"{name}.json.gz"
    if not path.is_file():
        pytest.skip(f"no verdicts of the reference at {path}")
    return json.loads(gzip.decompress(path.read_bytes()))
