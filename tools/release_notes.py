"""What is new, from CHANGELOG.md: the part of the newest version, or of what is not released yet.

python tools/release_notes.py --out dist/notes.md
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def newest(changelog: str) -> str:
    """The first part of a changelog, without its heading."""
    parts = re.split(r"^## .*$", changelog, flags=re.MULTILINE)
    if len(parts) < 2 or not parts[1].strip():
        raise SystemExit("CHANGELOG.md: expected a part with what is new")
    return parts[1].strip() + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="where the notes go")
    out = parser.parse_args().out
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(newest((ROOT / "CHANGELOG.md").read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
