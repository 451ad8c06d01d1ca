"""Files of what was made once: equal input, equal bytes, in this version as in the one that wrote them."""

from __future__ import annotations

import os
from pathlib import Path


def assert_golden(path: Path, lines: list[str]) -> None:
    """What was made is what the file has; ``WRITE_GOLDEN=1 pytest TEST`` writes it again."""
    text = "".join([f"{line}\n" for line in lines])
    if os.environ.get("WRITE_GOLDEN"):
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8"), f"if this is meant, WRITE_GOLDEN=1 pytest writes {path}"
