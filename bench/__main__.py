"""List the programs that measure or compare, or run one: `python -m bench [NAME [options]]`.

The programs are the modules of this folder and of tests/differential that have a function `main`.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TESTS = ROOT / "tests"
FOLDERS = {"bench": ROOT / "bench", "differential": TESTS / "differential"}


def main() -> None:
    """Run the named program with the other arguments of the command line."""
    words = sys.argv[1:]
    if not words or words[0] in ("-h", "--help"):
        print(format_program_list())
        return
    modules = find_program_modules()
    if words[0] not in modules:
        sys.exit(f"bench: no program {words[0]!r}; `python -m bench` lists the programs")
    sys.path.insert(0, str(TESTS))
    sys.argv = [f"python -m bench {words[0]}", *words[1:]]
    sys.exit(import_module(modules[words[0]]).main())


def find_program_modules() -> Mapping[str, str]:
    """Return the module of each program, by program name in alphabetical order."""
    modules = {
        path.stem: f"{package}.{path.stem}"
        for package, folder in FOLDERS.items()
        for path in folder.glob("*.py")
        if not path.stem.startswith("_") and _is_program(path)
    }
    return dict(sorted(modules.items()))


def format_program_list() -> str:
    """Return a line for each program: its name and the first line of its docstring."""
    lines = ["python -m bench NAME [options]", ""]
    for name, module in find_program_modules().items():
        package, _, file = module.partition(".")
        text = ast.get_docstring(ast.parse((FOLDERS[package] / f"{file}.py").read_text(encoding="utf-8")))
        lines.append(f"  {name:24}{(text or '').partition(chr(10))[0]}")
    return "\n".join(lines)


def _is_program(path: Path) -> bool:
    body = ast.parse(path.read_text(encoding="utf-8")).body
    names = [node.name for node in body if isinstance(node, ast.FunctionDef)]
    return "main" in names and not path.stem.endswith("_child")


if __name__ == "__main__":
    main()
