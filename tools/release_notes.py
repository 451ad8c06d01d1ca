"""Write release notes: the newest section of CHANGELOG.md.

python tools/release_notes.py --out dist/notes.md
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def read_first_section(changelog: str) -> str:
    """Return the first section of a changelog without its heading."""
    parts = re.split(r"^## .*$", changelog, flags=re.MULTILINE)
    if len(parts) < 2 or not parts[1].strip():
        raise SystemExit("CHANGELOG.md: expected a section with changes below a heading ##")
    return parts[1].strip() + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="file of the notes")
    out = parser.parse_args().out
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(read_first_section((ROOT / "CHANGELOG.md").read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
