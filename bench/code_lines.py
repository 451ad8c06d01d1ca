"""How much code there is: lines of Python per package, without blank lines, comments and docstrings.

python bench/code_lines.py [FOLDER]     default: src/eai
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections import Counter
from pathlib import Path

_NOTHING = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
_NOTHING |= {tokenize.ENCODING, tokenize.ENDMARKER}


def code_lines(text: str) -> int:
    """The number of lines that hold a token of code."""
    lines = {
        line
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type not in _NOTHING
        for line in range(token.start[0], token.end[0] + 1)
    }
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            lines -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def main(folder: Path) -> None:
    """Print a line a package, and the sum."""
    counts: Counter[str] = Counter()
    for path in folder.rglob("*.py"):
        part = path.relative_to(folder).parts
        counts[part[0] if len(part) > 1 else "."] += code_lines(path.read_text(encoding="utf-8"))
    for package, count in counts.most_common():
        print(f"{count:7,} {package}")
    print(f"{counts.total():7,} in all")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "src" / "eai")
