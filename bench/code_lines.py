"""Count lines of Python per package, without blank lines, comments and docstrings.

    python -m bench code_lines [MODULE ...]

Without MODULE, all packages are counted. With modules, only these modules are counted and all modules of the
package that they import, directly or not. The modules that score a plan:
eai.abilities.action_sequencing.scorer eai.benchmarks.virtualhome.plan_notation
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

_SOURCE = Path(__file__).resolve().parents[1] / "src"
_MODULES = {
    ".".join(path.relative_to(_SOURCE).with_suffix("").parts).removesuffix(".__init__"): path
    for path in _SOURCE.rglob("*.py")
}
_NOTHING = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
_NOTHING |= {tokenize.ENCODING, tokenize.ENDMARKER}


def count_code_lines(text: str) -> int:
    """Return the number of lines that hold a token of code."""
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


def read_from(start: Sequence[str]) -> set[str]:
    """Return the modules and all modules that they import, directly or not. Imports for types count."""
    found: set[str] = set()
    pending = list(start)
    while pending:
        module = pending.pop()
        if module not in found and module in _MODULES:
            found.add(module)
            pending += _find_imported_modules(_MODULES[module])
    return found


def _find_imported_modules(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                part = f"{node.module}.{alias.name}"
                yield part if part in _MODULES else str(node.module)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def main() -> None:
    """Print the number of lines of each package, and the sum."""
    counts: Counter[str] = Counter()
    start = sys.argv[1:]
    for module in read_from(start) if start else _MODULES:
        path = _MODULES[module]
        part = path.relative_to(_SOURCE / "eai").parts
        counts[part[0] if len(part) > 1 else "."] += count_code_lines(path.read_text(encoding="utf-8"))
    for package, count in counts.most_common():
        print(f"{count:7,} {package}")
    print(f"{counts.total():7,} in all")
