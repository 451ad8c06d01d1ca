"""Write the repository's address into package pages, their links and the citation.

Before that, none of these files links to the repository. tools/site.py reads the address from pyproject.toml.

    python tools/address.py https://HOST/OWNER/NAME
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
URLS = "[project.urls]\n"
_SET = re.compile(r'^(Repository|repository-code)( = |: )".*"\n', re.MULTILINE)
_LINK = re.compile(r"(pattern = '(?P<picture>!?)\\\[.*?replacement = )'.*'")


def set_address(text: str, address: str, below: str = "") -> str:
    """Return the text of a ``pyproject.toml`` with the address of the repository.

    Args:
        text: Text of the file.
        address: Web address of the repository.
        below: Folder of the file in the repository, with a slash at its end; empty for the root.
    """
    text = _SET.sub("", text).replace(URLS, f'{URLS}Repository = "{address}"\n', 1)
    return _LINK.sub(lambda match: f"{match[1]}'{_make_replacement(match['picture'], address, below)}'", text)


def _make_replacement(picture: str, address: str, below: str) -> str:
    kind = "raw" if picture else "blob"
    return rf"{picture}[\1]({address}/{kind}/main/{below}\2)" + (r"\n\n" if picture else "")


def write(root: Path, address: str) -> None:
    """Write the address into all files below the root folder that link to the repository."""
    for file in [root / "pyproject.toml", *sorted(root.glob("packages/*/pyproject.toml"))]:
        below = "" if file.parent == root else f"{file.parent.relative_to(root).as_posix()}/"
        file.write_text(set_address(file.read_text(encoding="utf-8"), address, below), encoding="utf-8")
    citation = root / "CITATION.cff"
    kept = _SET.sub("", citation.read_text(encoding="utf-8"))
    written = kept.replace("license: MIT\n", f'license: MIT\nrepository-code: "{address}"\n', 1)
    citation.write_text(written, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2 or not sys.argv[1].startswith("https://"):
        raise SystemExit(__doc__)
    write(ROOT, sys.argv[1].rstrip("/"))
