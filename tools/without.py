"""Tests the package without extensions, as if nobody had written them.

    python tools/without.py                             each extension in turn, then all of them
    python tools/without.py reference -- -m "not sweep"  one of them, with options of pytest
    python tools/without.py all                         all of them

The repository is copied without the folders of the extension: its code, its tests, its page. All modules of
the copy are imported, and all its tests are run but those of pages that tell of all extensions.
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
OF_ALL = (
    "tests/test_commands_page.py",
    "tests/test_gallery.py",
    "tests/test_glossary.py",
    "tests/test_readme.py",
    "tests/test_study.py",
    "tests/test_tutorials.py",
    "tests/test_without.py",
)
"""Tests of pages that tell of all extensions, and of this program."""

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
"""Imports all modules but those that run at once; a library that is not installed is no failure."""


def copy_without(names: Sequence[str], target: Path) -> None:
    """Copy the repository without the folders of some extensions."""
    ignored = shutil.ignore_patterns("__pycache__", ".venv", "build")
    for path in ROOT.iterdir():
        if path.name in COPIED:
            shutil.copytree(path, target / path.name, ignore=ignored)
        elif path.is_file():
            shutil.copy(path, target / path.name)
    for name in names:
        for above in (EXTENSIONS, Path("tests", "extensions"), Path("docs", "extensions")):
            shutil.rmtree(target / above / name, ignore_errors=True)


def package_without(names: Sequence[str], target: Path) -> Path:
    """Copy the package alone without some extensions; returns its folder."""
    package = target / "eai"
    shutil.copytree(ROOT / "src" / "eai", package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in names:
        shutil.rmtree(package / "extensions" / name)
    return package


def imports_of(package: Path) -> subprocess.CompletedProcess[str]:
    """Import all modules in a copy of the package."""
    environment = {**os.environ, "PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", IMPORT_ALL]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


def _works_without(names: Sequence[str], options: Sequence[str]) -> bool:
    with TemporaryDirectory() as folder:
        target = Path(folder)
        copy_without(names, target)
        imports = imports_of(target / "src" / "eai")
        print(f"without {', '.join(names)}: {imports.stderr or 'all is imported'}", flush=True)
        ignored = [f"--ignore={path}" for path in OF_ALL]
        command = [sys.executable, "-m", "pytest", "-q", *ignored, *options]
        environment = {**os.environ, "PYTHONPATH": str(target / "src")}
        tests = subprocess.run(command, cwd=target, check=False, env=environment)
        return not imports.returncode and not tests.returncode


def main(names: Sequence[str], options: Sequence[str]) -> int:
    """Return exit status 1 if anything that is left fails without one of the extensions."""
    failed = [name for name in names if not _works_without(NAMES if name == ALL else (name,), options)]
    print(f"without {', '.join(failed)} something fails" if failed else "all that is left works")
    return bool(failed)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", default=(*NAMES, ALL), choices=(*NAMES, ALL), metavar="NAME")
    separator = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    sys.exit(main(parser.parse_args(sys.argv[1:separator]).names, sys.argv[separator + 1 :]))
