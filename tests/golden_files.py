"""Golden files: output of an earlier version, which equal input must reproduce byte for byte."""

from __future__ import annotations

import os
from pathlib import Path


def assert_golden(path: Path, lines: list[str]) -> None:
    """Assert that output equals a golden file; ``WRITE_GOLDEN=1 pytest TEST`` writes the file again."""
    text = "".join([f"{line}\n" for line in lines])
    if os.environ.get("WRITE_GOLDEN"):
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8"), f"if this is meant, WRITE_GOLDEN=1 pytest writes {path}"
