"""Test the package without extensions, as if nobody had written them.

    python tools/without.py                             each extension in turn, then all of them
    python tools/without.py reference -- -m "not sweep"  one of them, with options of pytest
    python tools/without.py all                         all of them

The program copies the repository without the folders of the extension: code, tests and page. It imports all
modules of the copy and runs its tests, except tests of pages and tools that list files of all extensions.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[1]
EXTENSIONS = Path("src", "eai", "extensions")
NAMES = tuple(sorted(path.parent.name for path in ROOT.joinpath(EXTENSIONS).glob("*/__init__.py")))
ALL = "all"

COPIED = (".ci", ".github", "bench", "board", "docs", "examples", "packages", "src", "tests", "tools")
TESTS_OF_ALL = (
    "tests/test_commands_page.py",
    "tests/test_gallery.py",
    "tests/test_glossary.py",
    "tests/test_mutants.py",
    "tests/test_names_in_docs.py",
    "tests/test_plain_english.py",
    "tests/test_readme.py",
    "tests/test_study.py",
    "tests/test_tutorials.py",
    "tests/test_without.py",
)
"""Tests of this program, and tests of pages and tools that list files of all extensions."""

IMPORT_ALL = """
import importlib, pathlib, sys
import eai
root = pathlib.Path(eai.__file__).parent
for path in sorted(root.rglob("*.py")):
    parts = ("eai", *path.relative_to(root).with_suffix("").parts)
    if parts[-1] in ("__main__", "metadata_backend"):
        continue
    try:
        importlib.import_module(".".join(parts).removesuffix(".__init__"))
    except ImportError as error:
        if (error.name or "").startswith("eai"):
            raise
print(root)
"""
"""Program that imports all modules, except modules that run at import. A missing library is no failure."""


def copy_without(names: Sequence[str], target: Path) -> None:
    """Copy the repository without the folders of some extensions."""
    ignored = shutil.ignore_patterns("__pycache__", ".venv", "build")
    for path in ROOT.iterdir():
        if path.name in COPIED:
            shutil.copytree(path, target / path.name, ignore=ignored)
        elif path.is_file():
            shutil.copy(path, target / path.name)
    for name in names:
        for parent in (EXTENSIONS, Path("tests", "extensions"), Path("docs", "extensions")):
            shutil.rmtree(target / parent / name, ignore_errors=True)


def package_without(names: Sequence[str], target: Path) -> Path:
    """Copy the package without some extensions and return the folder of the copy."""
    package = target / "eai"
    shutil.copytree(ROOT / "src" / "eai", package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in names:
        shutil.rmtree(package / "extensions" / name)
    return package


def import_all(package: Path) -> subprocess.CompletedProcess[str]:
    """Import all modules of a copied package in a process of its own and return the finished process."""
    environment = {**os.environ, "PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", IMPORT_ALL]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


def _works_without(names: Sequence[str], options: Sequence[str]) -> bool:
    with TemporaryDirectory() as folder:
        target = Path(folder)
        copy_without(names, target)
        imports = import_all(target / "src" / "eai")
        print(f"without {', '.join(names)}: {imports.stderr or 'all modules can be imported'}", flush=True)
        ignored = [f"--ignore={path}" for path in TESTS_OF_ALL]
        command = [sys.executable, "-m", "pytest", "-q", *ignored, *options]
        environment = {**os.environ, "PYTHONPATH": str(target / "src")}
        tests = subprocess.run(command, cwd=target, check=False, env=environment)
        return not imports.returncode and not tests.returncode


def main(names: Sequence[str], options: Sequence[str]) -> int:
    """Return 1 if an import or a test fails without one of the extensions, else 0."""
    failed = [name for name in names if not _works_without(NAMES if name == ALL else (name,), options)]
    print(
        f"an import or a test fails without {', '.join(failed)}" if failed else "all imports and tests pass"
    )
    return bool(failed)


def parse_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the names of extensions, all if none is given, and the options of pytest after ``--``."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", choices=(*NAMES, ALL), metavar="NAME")
    separator = arguments.index("--") if "--" in arguments else len(arguments)
    names = arguments[:separator] or [*NAMES, ALL]  # argparse would look for a default list among the choices
    return parser.parse_args(names).names, [*arguments[separator + 1 :]]


if __name__ == "__main__":
    sys.exit(main(*parse_arguments(sys.argv[1:])))
