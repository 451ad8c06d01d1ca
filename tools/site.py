"""Build the site of the documentation; a broken link or anchor is an error.

The site contains the repository's pages at the same paths, with each file that they link to. Its navigation
is the list of pages in docs/README.md. A page that is missing in this list is an error too.

    python tools/site.py    # writes build/site/html
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
BUILD = ROOT / "build/site"
LINK = re.compile(r"\]\((?!https?:|mailto:|#)(?P<target>[^)#\s]+)")
NAMED_LINK = re.compile(r"\[(?P<name>[^\]]+)\]\((?!https?:|mailto:|#)(?P<target>[^)#\s]+)\)")
CODE = re.compile(r"`[^`\n]+`")
HEADING = re.compile(r"^## (?P<title>.+)$", re.MULTILINE)
ADDRESS = re.compile(r'^Repository = "(?P<address>[^"]+)"$', re.MULTILINE)
VERSION = re.compile(r'^__version__ = "(?P<version>[^"]+)"$', re.MULTILINE)
ROW = re.compile(r"^\| \[(?P<title>[^\]]+)\]\((?P<page>[^)]+)\) \|", re.MULTILINE)


def main() -> int:
    shutil.rmtree(BUILD, ignore_errors=True)
    copy_pages(ROOT, BUILD / "pages")
    config = BUILD / "mkdocs.yml"
    paths = {"docs_dir": "pages", "site_dir": "html"}
    # JSON is also YAML. The new file inherits all other settings from mkdocs.yml.
    config.write_text(
        json.dumps(
            {"INHERIT": "../../mkdocs.yml", **paths, **make_site_settings(ROOT), "nav": make_navigation(ROOT)}
        ),
        encoding="utf-8",
    )
    return subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", config]
    ).returncode


def make_site_settings(root: Path) -> dict[str, str]:
    """Return the version, and the address of the repository if tools/address.py has written it."""
    (version,) = VERSION.findall((root / "src/eai/__init__.py").read_text(encoding="utf-8"))
    address = ADDRESS.search((root / "pyproject.toml").read_text(encoding="utf-8"))
    return {"copyright": f"eai {version}"} | ({} if address is None else {"repo_url": address["address"]})


def copy_pages(root: Path, pages: Path) -> None:
    """Copy the pages, the site's style files, and each file that the pages link to."""
    styles = sorted((root / "docs/site").glob("*"))
    linked = [root / "README.md", *sorted((root / "docs").rglob("*.md")), *styles]
    copied = set()
    while linked:
        file = linked.pop()
        if file in copied or not file.is_file():
            continue
        copied.add(file)
        target = pages / file.relative_to(root)
        target.parent.mkdir(parents=True, exist_ok=True)
        if file.suffix != ".md":
            shutil.copyfile(file, target)
            continue
        text = file.read_text(encoding="utf-8")
        linked += [(file.parent / link["target"]).resolve() for link in LINK.finditer(text)]
        target.write_text(adapt_links(text, file.parent), encoding="utf-8")


def adapt_links(text: str, folder: Path) -> str:
    """Return a page without links to folders, and with the bars in its code as Python-Markdown reads them."""
    text = NAMED_LINK.sub(lambda link: link["name"] if (folder / link["target"]).is_dir() else link[0], text)
    return CODE.sub(lambda code: code[0].replace(r"\|", "|"), text)


def make_navigation(root: Path) -> list[dict[str, object]]:
    """Return the navigation of the site in mkdocs's form: the pages below each heading of docs/README.md."""
    index = root / "docs/README.md"
    sections: list[dict[str, object]] = [{"Start": "README.md"}, {"Documentation": "docs/README.md"}]
    _, *parts = HEADING.split(index.read_text(encoding="utf-8"))
    for title, text in zip(parts[::2], parts[1::2], strict=True):
        rows = [
            (row["title"].replace("`", ""), (index.parent / row["page"]).resolve())
            for row in ROW.finditer(text)
        ]
        sections.append({title: [{name: page.relative_to(root).as_posix()} for name, page in rows]})
    return sections


if __name__ == "__main__":
    sys.exit(main())
