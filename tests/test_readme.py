"""Tests that the snippets of the documentation run and print the shown output, and that its links exist.

The ```python blocks of a page run in order in one namespace, in an empty folder. If a ```text block follows
with only blank lines between, the block must print exactly its text.
"""

from __future__ import annotations

import contextlib
import io
import re
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "bench").glob("*.md")])
BLOCK = re.compile(
    r"^```python\n(?P<code>.*?)^```$(?:\n\s*^```text\n(?P<printed>.*?)^```$)?", re.MULTILINE | re.DOTALL
)
LINK = re.compile(r"\]\((?!https?:|mailto:|#)(?P<target>[^)#\s]+)")
ANCHOR = re.compile(r"\]\((?!https?:)(?P<target>[^)#\s]*)#(?P<heading>[^)\s]+)\)")
HEADING = re.compile(r"^#+ (?P<title>.+)$", re.MULTILINE)
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())


@dataclass(frozen=True, slots=True)
class Snippet:
    """A block of code on a page.

    Attributes:
        line: Line of the page on which the code starts, counted from 1.
        code: The code.
        printed: Output that the page shows, or None if it shows none.
    """

    line: int
    code: str
    printed: str | None


def snippets(page: str) -> list[Snippet]:
    """Return the Python blocks of a Markdown page."""
    return [
        Snippet(page.count("\n", 0, match.start("code")) + 1, match["code"], match["printed"])
        for match in BLOCK.finditer(page)
    ]


def run(page: Path) -> None:
    """Run a page's snippets. An assertion names the line of a snippet with other output than the page's."""
    namespace: dict[str, object] = {"__name__": "__main__"}
    for snippet in snippets(page.read_text(encoding="utf-8")):
        # Blank lines before the code make a traceback show the line of the page.
        code = compile("\n" * (snippet.line - 1) + snippet.code, str(page), "exec")
        with contextlib.redirect_stdout(io.StringIO()) as output:
            exec(code, namespace)  # noqa: S102 - our own documentation
        if snippet.printed is not None:
            assert output.getvalue() == snippet.printed, f"{page.name}:{snippet.line}"


def dead_links(page: Path) -> list[str]:
    """Return the targets of a page's relative links that do not exist."""
    targets = [match["target"] for match in LINK.finditer(page.read_text(encoding="utf-8"))]
    return [target for target in targets if not (page.parent / target).exists()]


def dead_anchors(page: Path) -> list[str]:
    """Return the headings that a page links to and that do not exist."""
    found = ANCHOR.finditer(page.read_text(encoding="utf-8"))
    links = [
        ((page.parent / match["target"] if match["target"] else page), match["heading"]) for match in found
    ]
    return [f"{file.name}#{name}" for file, name in links if file.exists() and name not in anchors(file)]


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings: their words in small letters, joined by hyphens."""
    titles = [match["title"] for match in HEADING.finditer(FENCED.sub("", page.read_text(encoding="utf-8")))]
    return {re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", title).strip().lower()) for title in titles}


@every_page
def test_snippets_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run(page)


@every_page
def test_links_lead_somewhere(page: Path) -> None:
    assert dead_links(page) == []


@every_page
def test_anchors_lead_to_headings(page: Path) -> None:
    assert dead_anchors(page) == []


def test_the_index_leads_to_every_page() -> None:
    index = ROOT / "docs/README.md"
    listed = {
        (index.parent / match["target"]).resolve()
        for match in LINK.finditer(index.read_text(encoding="utf-8"))
    }
    assert [page.name for page in (ROOT / "docs").rglob("*.md") if page not in listed | {index}] == []


PAGE = """\
# Title

```python
x = 1
print(x)
```

```text
1
```

```console
$ not run
```

```python
print(x + 1)
```
"""


def test_blocks_share_names_and_output_belongs_to_the_block_before(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE, encoding="utf-8")
    assert snippets(PAGE) == [Snippet(4, "x = 1\nprint(x)\n", "1\n"), Snippet(17, "print(x + 1)\n", None)]
    run(page)


@pytest.mark.parametrize(
    ("old", "new", "error"),
    [
        ("1\n```\n\n```console", "2\n```\n\n```console", AssertionError),
        ("print(x + 1)", "print(y)", NameError),
        ("x = 1", "x =", SyntaxError),
    ],
)
def test_a_wrong_page_fails(tmp_path: Path, old: str, new: str, error: type[Exception]) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE.replace(old, new), encoding="utf-8")
    with pytest.raises(error):
        run(page)


def test_dead_links_are_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "[a](page.md#x) [b](gone.md) ![c](no/image.png) [d](https://x.org/y) [e](#z)", encoding="utf-8"
    )
    assert dead_links(page) == ["gone.md", "no/image.png"]


def test_dead_anchors_are_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    text = "# Two `words`, here\n[a](#two-words-here) [b](page.md#two) [c](#gone)\n```\n# gone\n```\n"
    page.write_text(text, encoding="utf-8")
    assert dead_anchors(page) == ["page.md#two", "page.md#gone"]
