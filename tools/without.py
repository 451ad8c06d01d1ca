"""Tests the package without one of its folders, as if nobody had written it.

    python tools/without.py                             all folders that can be taken out, one after the other
    python tools/without.py reference -- -m "not sweep"  one of them, with options of pytest

For each folder a copy of the repository is made out of which it is taken, with what is about it: commands,
studies, and modules of the reference's protocol that import it. All modules that are left are imported; of
the tests all are run but those that speak of what is gone, by their name, too, or import one that does, and
those of pages that tell of all.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from eai.base.entry_points import entry_points_of

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path("src", "eai")
FOLDERS = (
    "reference",
    *sorted(
        f"{kind}/{path.parent.name}"
        for kind in ("abilities", "households", "studies")
        for path in ROOT.joinpath(PACKAGE, kind).glob("*/__init__.py")
        if path.parent != ROOT / PACKAGE / "abilities" / "notation"
    ),
)
"""Folders that can be taken out."""
STUDIES = entry_points_of("eai.studies")

COPIED = (".ci", ".github", "bench", "board", "docs", "examples", "packages", "src", "tests", "tools")
OF_ALL = (
    "results/test_records_page.py",
    "test_api_page.py",
    "test_commands_page.py",
    "test_glossary.py",
    "test_names.py",
    "test_readme.py",
    "test_study.py",
    "test_tutorials.py",
)
_LISTING = (
    "tests/cli/test_flags.py::test_all_options_are_listed_where_the_documentation_has_them",
    "tests/results/test_data_set.py::test_figures_that_the_paper_does_not_print",
    "tests/run/test_harnesses.py::test_every_suite_is_a_task_that_is_found_by_reading_the_file",
    "tests/run/test_harnesses.py::test_every_suite_is_a_task_of_the_lm_evaluation_harness",
    "tests/run/test_structured.py::test_a_server_is_told_the_words_of_each_task",
    "tests/extensions/annotation/test_annotation.py::test_the_quality_of_annotations_is_told",
)
"""Tests of pages, and of the whole source, that tell of all folders; some among others."""
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
"""Imports all that is left, but what runs at once or needs an extra."""


def copy_without(folder: str, target: Path) -> Path:
    """Copy the repository without a folder of the package; returns the folder of the copied package."""
    for name in COPIED:
        ignored = shutil.ignore_patterns("__pycache__", "*.so", ".venv", "build")
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, target / name, ignore=ignored)
    for path in ROOT.iterdir():
        if path.is_file():
            shutil.copy(path, target / path.name)
    shutil.rmtree(target / PACKAGE)
    return package_without(folder, target / PACKAGE.parent)


def package_without(folder: str, target: Path) -> Path:
    """Copy the package alone without one of its folders, and what is about it; returns its folder there."""
    shutil.copytree(
        ROOT / PACKAGE, target / PACKAGE.name, ignore=shutil.ignore_patterns("__pycache__", "*.so")
    )
    package = target / PACKAGE.name
    shutil.rmtree(package / folder)
    gone = [folder]
    while gone:
        gone = [_removed(path, package) for path in _importers(gone, package)]
    return package


def _importers(gone: Sequence[str], package: Path) -> set[Path]:
    """Commands, studies and modules of the protocol that import one of some folders and modules."""
    names = "|".join(gone).replace("/", r"\.")
    imports = re.compile(rf"^(?:from|import) eai\.(?:{names})\b", re.MULTILINE)
    paths = [path for each in ("cli/*.py", "reference/*.py", "studies/*/*.py") for path in package.glob(each)]
    about = [path for path in paths if imports.search(path.read_text(encoding="utf-8"))]
    return {path.parent if path.parent.parent.name == "studies" else path for path in about}


def _removed(path: Path, package: Path) -> str:
    """Remove a module or a folder of the package; returns what it was called."""
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink()
    return path.relative_to(package).with_suffix("").as_posix()


def gone_from(package: Path) -> list[str]:
    """The folders that are not in a copy of the package."""
    return [folder for folder in FOLDERS if not (package / folder).exists()]


def modules_gone_from(package: Path) -> list[str]:
    """The modules of the protocol that are not in a copy of the package."""
    modules = sorted(ROOT.joinpath(PACKAGE, "reference").glob("*.py"))
    return [f"reference/{each.stem}" for each in modules if not (package / "reference" / each.name).exists()]


def tests_about(folder: str, tests: Path) -> set[Path]:
    """The files of tests that speak of a folder, run a program that does, or import such a test."""
    name = folder.rpartition("/")[2]
    about = re.compile(_words_about(folder), re.IGNORECASE)
    texts = {path: path.read_text(encoding="utf-8") for path in tests.rglob("*.py")}
    programs = [path for path in tests.parent.glob("bench/*.py") if about.search(path.read_text("utf-8"))]
    of_program = re.compile("|".join([r"\b" + re.escape(path.name) for path in programs]) or "(?!)")
    found = {
        path
        for path, text in texts.items()
        if about.search(text) or of_program.search(text) or name in path.parts
    }
    while True:
        modules = {".".join(path.relative_to(tests).with_suffix("").parts) for path in found}
        imported = re.compile(rf"^(?:from|import) (?:{'|'.join(map(re.escape, modules))})\b", re.MULTILINE)
        more = {path for path, text in texts.items() if modules and imported.search(text)} - found
        if not more:
            return found
        found |= more


def _words_about(folder: str) -> str:
    """A pattern of what only speaks of a folder, or a module of the protocol.

    A study is also known by its name, or listed with all.
    """
    kind, _, name = folder.rpartition("/")
    if kind == "reference":
        return rf"\breference(?:\.| import ){name}\b"
    if kind == "studies":
        names = "|".join([name, *(each for each, point in STUDIES.items() if f".{name}." in point.value)])
        listed = r"eai\.studies import registry|test_entry_points import declared"
        return rf"\bstudies(?:\.| import ){name}\b|[\"'](?:{names})[\"']|[\"' ](?:{names})\.[a-z_]+|{listed}"
    if folder == "reference":
        return r"eai\.reference\b|eai-1\.0\.5|of_reference|Protocol\.known"
    return name


def imports_without(package: Path) -> subprocess.CompletedProcess[str]:
    """Import all modules that are left in a copy of the package."""
    environment = {**os.environ, "PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", IMPORT_ALL]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


def main(folders: Sequence[str], options: Sequence[str]) -> int:
    """Exit status 1 if anything that is left fails without one of the folders."""
    failed = [folder for folder in folders if not _works_without(folder, options)]
    print(f"without {', '.join(failed)} something fails" if failed else "all that is left works")
    return bool(failed)


def _works_without(folder: str, options: Sequence[str]) -> bool:
    with TemporaryDirectory() as target:
        package = copy_without(folder, Path(target))
        imports, gone = imports_without(package), gone_from(package)
        print(f"without {' and '.join(gone)}: {imports.stderr or 'all is imported'}", flush=True)
        tests = Path(target, "tests")
        modules = [] if folder == "reference" else modules_gone_from(package)
        about = {path for each in (*gone, *modules) for path in tests_about(each, tests)}
        about |= {path.parent for path in about if path.name == "conftest.py"}
        ignored = [f"--ignore={path}" for path in sorted(about | {tests / name for name in OF_ALL})]
        names = " or ".join(each.rpartition("/")[2] for each in gone)
        kept = [*(f"--deselect={test}" for test in _LISTING), "-k", f"not ({names})"]
        command = [sys.executable, "-m", "pytest", "-q", *ignored, *kept, *options]
        environment = {**os.environ, "PYTHONPATH": str(package.parent)}
        ran = subprocess.run(command, cwd=target, check=False, env=environment)
        return not imports.returncode and not ran.returncode


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folders", nargs="*", default=FOLDERS, metavar="FOLDER")
    separator = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    sys.exit(main(parser.parse_args(sys.argv[1:separator]).folders, sys.argv[separator + 1 :]))
