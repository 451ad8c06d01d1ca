"""Find docstrings and comments that are hard to read, and fail if a folder has more of them than before.

    python tools/plain_english.py                  check the limit of each folder
    python tools/plain_english.py --list 20        also print the 20 worst texts
    python tools/plain_english.py src/eai/world    print the marked texts of some files or folders
    python tools/plain_english.py --lower          lower limits to today's numbers; none rises

The habits, the limits and the list of clear texts are data: tools/plain_english.toml. The program is a
finder. A marked text can be clear, and an unmarked text can be unclear: a reader decides.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from eai.base.files import read_toml

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "tools" / "plain_english.toml"
CHECKED = ("src/eai", "packages", "bench", "tools", "tests", "examples")
"""Folders whose texts are counted, each folder directly below src/eai and tests by itself."""

MIN_COMMENT_LENGTH = 25
MAX_EXCEPTIONS = 60
SECTION_NAMES = re.compile(r"^\s*(Args|Attributes|Returns|Raises|Yields|Options):\s*$", re.MULTILINE)
CODE = re.compile(r"``[^`]*``|`[^`]*`")
SENTENCE_END = re.compile(r"(?<=[.;:])\s+|\n\s*(?=\w+: )|\n\n")


@dataclass(frozen=True, slots=True)
class Text:
    """A docstring or comment.

    Attributes:
        path: File, relative to the repository, with slashes.
        line: Line of the text, or of the definition that it documents.
        owner: Name of the documented definition; `#` for a comment.
        content: The text.
    """

    path: str
    line: int
    owner: str
    content: str


@dataclass(frozen=True, slots=True)
class Habits:
    """Patterns of sentences that are hard to read, and the texts that are exceptions.

    Attributes:
        strong: Patterns by name; one match marks a text.
        weak: Patterns by name; matches of two patterns in one sentence mark a text.
        exceptions: Reasons why marked texts are clear, by path, owner and beginning of the text.
        limits: Maximum number of marked texts, by folder.
    """

    strong: dict[str, re.Pattern[str]]
    weak: dict[str, re.Pattern[str]]
    exceptions: dict[tuple[str, str, str], str]
    limits: dict[str, int]

    def is_marked(self, text: str) -> bool:
        """Whether a sentence of the text has a strong habit, or two weak habits."""
        return any(
            any(pattern.search(sentence) for pattern in self.strong.values())
            or sum(bool(pattern.search(sentence)) for pattern in self.weak.values()) > 1
            for sentence in split_sentences(text)
        )

    def names_in(self, text: str) -> list[str]:
        """Return the names of all habits in the text."""
        parts = split_sentences(text)
        patterns = {**self.strong, **self.weak}.items()
        return [name for name, pattern in patterns if any(map(pattern.search, parts))]

    def is_exception(self, text: Text) -> bool:
        """Whether the list of exceptions contains the text."""
        content = " ".join(text.content.split())
        return any(
            (path, owner) == (text.path, text.owner) and content.startswith(beginning)
            for path, owner, beginning in self.exceptions
        )


def read_habits(path: Path = DATA) -> Habits:
    """Read habits, exceptions and limits from a TOML file."""
    data = read_toml(path)
    return Habits(
        strong={entry["name"]: re.compile(entry["pattern"]) for entry in data["strong"]},
        weak={entry["name"]: re.compile(entry["pattern"]) for entry in data["weak"]},
        exceptions={
            (entry["path"], entry["owner"], entry["text"]): entry["reason"] for entry in data.get("clear", [])
        },
        limits=data.get("limits", {}),
    )


def split_sentences(text: str) -> list[str]:
    """Split a text into sentences and entries. Code becomes `X`; names of sections are removed."""
    prose = SECTION_NAMES.sub("", CODE.sub("X", text))
    return [" ".join(sentence.split()) for sentence in SENTENCE_END.split(prose) if sentence.strip()]


def find_texts(path: Path) -> Iterator[Text]:
    """Yield the docstrings, attribute docstrings and long comments of a Python file."""
    source = path.read_text(encoding="utf-8")
    name = path.relative_to(ROOT).as_posix()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            if content := ast.get_docstring(node):
                yield Text(name, getattr(node, "lineno", 1), getattr(node, "name", "module"), content)
            for owner, line, content in _find_attribute_docstrings(node.body):
                yield Text(name, line, owner, content)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        comment = token.string
        is_directive = "noqa" in comment or "type:" in comment
        if token.type == tokenize.COMMENT and len(comment) > MIN_COMMENT_LENGTH and not is_directive:
            yield Text(name, token.start[0], "#", comment.lstrip("# "))


def _find_attribute_docstrings(body: Sequence[ast.stmt]) -> Iterator[tuple[str, int, str]]:
    for assignment, statement in pairwise(body):
        match assignment, statement:
            case (
                ast.Assign(targets=[target, *_]) | ast.AnnAssign(target=target),
                ast.Expr(value=ast.Constant(value=str(content))),
            ):
                yield ast.unparse(target), statement.lineno, content


def get_folder(path: str) -> str:
    """Return the folder that the texts of a file are counted in, such as `src/eai/world` or `bench`."""
    parents = path.split("/")[:-1]
    return "/".join(parents[: {"src": 3, "tests": 2}.get(parents[0], 1)])


def find_python_files(folder: Path) -> list[Path]:
    """Return a file, or the Python files below a folder without those of environments."""
    if folder.is_file():
        return [folder]
    return [path for path in sorted(folder.rglob("*.py")) if ".venv" not in path.parts]


def main() -> int:
    """Check the limits, or print marked texts; return 1 if a folder exceeds its limit."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("paths", nargs="*", type=Path, help="print marked texts of files and folders")
    parser.add_argument("--list", type=int, default=0, metavar="N", help="print the N worst texts")
    parser.add_argument("--lower", action="store_true", help="lower limits to today's numbers")
    arguments = parser.parse_args()
    habits = read_habits()
    folders = [path.resolve() for path in arguments.paths] or [ROOT / folder for folder in CHECKED]
    texts = [text for folder in folders for path in find_python_files(folder) for text in find_texts(path)]
    marked = [text for text in texts if habits.is_marked(text.content) and not habits.is_exception(text)]
    _print_worst(marked, habits, len(marked) if arguments.paths else arguments.list)
    if arguments.paths:
        return 0
    counts = Counter(get_folder(text.path) for text in marked)
    totals = Counter(get_folder(text.path) for text in texts)
    if arguments.lower:
        lowest = {folder: min(counts[folder], habits.limits.get(folder, 0)) for folder in sorted(totals)}
        _write_limits(lowest)
        return 0
    print(
        f"{len(marked)} of {len(texts)} docstrings and comments are marked ({len(marked) / len(texts):.1%})"
    )
    above = {folder: counts[folder] for folder in totals if counts[folder] > habits.limits.get(folder, 0)}
    for folder, count in above.items():
        print(
            f"{folder}: {count} marked texts, at most {habits.limits.get(folder, 0)} allowed. "
            f"Rewrite them: python tools/plain_english.py {folder}",
            file=sys.stderr,
        )
    return 1 if above else 0


def _print_worst(marked: Sequence[Text], habits: Habits, number: int) -> None:
    def density(text: Text) -> float:
        return len(habits.names_in(text.content)) / (1 + len(text.content) / 200)

    for text in sorted(marked, key=density, reverse=True)[:number]:
        print(f"{text.path}:{text.line} {text.owner}: {' '.join(text.content.split())}")
        print(f"    {', '.join(habits.names_in(text.content))}")


def _write_limits(counts: dict[str, int]) -> None:
    head, _, _ = DATA.read_text(encoding="utf-8").partition("[limits]\n")
    lines = [f'"{folder}" = {count}\n' for folder, count in counts.items()]
    DATA.write_text(f"{head}[limits]\n{''.join(lines)}", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
