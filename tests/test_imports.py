"""Tests of the direction of imports, and of the cost of importing.

`LAYERS` is the rule: a module may import from its own folder and from the rows above its own, never from a
row below. An extension may import from all rows, but from no other extension, and no other module imports an
extension. A folder or top-level module that is not in `LAYERS` is a violation: add it there. The root package
loads modules on first use, so that importing a part of the package stays cheap.
"""

from __future__ import annotations

import ast
import importlib.util
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import eai
from by_path import ROOT
from eai.base.files import parse_toml

SOURCE = Path(eai.__file__).parent

LAYERS = (
    "base",
    "logic",
    "world",
    "planning",
    "pddl",
    "tasks",
    "abilities",
    "benchmarks",
    "results",
    "agents",
    "studies",
    "run",
    "cli",
)
EXTENSIONS = "extensions"
ENTRY = "__main__"
FACES = ("", ENTRY)
"""Modules that load others on first use; see the test of importing the public names."""
ONLY_IMPORTERS = {
    "gymnasium": "agents",
    "inspect_ai": "run",
    "mcp": "agents",
    "mujoco": "extensions.scenes",
    "ray": "extensions.distributed",
}
OF_EXTRAS = frozenset({*ONLY_IMPORTERS.values(), "extensions.harbor"})
"""Folders that load an optional library, directly or through another folder."""


def folder_of(module: str) -> str:
    """Return the folder or top-level module of a module, "" for the root. An extension is a folder."""
    parts = module.split(".")[1:]
    return ".".join(parts[: 2 if parts[:1] == [EXTENSIONS] else 1])


def modules(root: Path) -> Iterator[tuple[str, Path]]:
    """Yield every module below a package's folder by dotted name, in a stable order."""
    for path in sorted(root.rglob("*.py")):
        names = path.relative_to(root.parent).with_suffix("").parts
        yield ".".join(names[:-1] if names[-1] == "__init__" else names), path


def imported(module: str, path: Path) -> Iterator[tuple[int, str]]:
    """Yield line and absolute name of all imports of a module, early or late (`from a import b` is `a.b`)."""
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.Import(names=names):
                yield from ((node.lineno, name.name) for name in names)
            case ast.ImportFrom(module=source, names=names, level=level):
                base = "." * level + (source or "")
                absolute = importlib.util.resolve_name(base, package) if level else base
                yield from ((node.lineno, f"{absolute}.{name.name}") for name in names)


def offence(importer: str, target: str, folders: frozenset[str]) -> str | None:
    """Return why a module must not import a target, or None if it may."""
    library = target.partition(".")[0]
    here, there = folder_of(importer), folder_of(target)
    if ONLY_IMPORTERS.get(library, here) != here:
        return f"only {ONLY_IMPORTERS[library]} imports {library}"
    if library != importer.partition(".")[0] or here in (
        "",
        ENTRY,
    ):  # the root package may import any folder
        return None
    if here == there or there not in folders:  # its own folder, or a name that the root itself defines
        return None
    if there.startswith(f"{EXTENSIONS}."):
        return f"{there} is found by its entry points, {here} must not import it"
    if here.startswith(f"{EXTENSIONS}.") or not {here, there} <= {*LAYERS}:
        return None
    return None if LAYERS.index(there) < LAYERS.index(here) else f"{here} must not import {there}"


def offences(root: Path) -> list[str]:
    """List all violations of the rule below a package's folder, as `file:line: why`."""
    of_package = list(modules(root))
    folders = frozenset(folder_of(module) for module, _ in of_package) - {"", EXTENSIONS}
    homeless = [
        f"{root.name}/{folder.replace('.', '/')}: has no place in LAYERS"
        for folder in sorted(folders - {*LAYERS, ENTRY})
        if not folder.startswith(f"{EXTENSIONS}.")
    ]
    return homeless + [
        f"{path.relative_to(root.parent).as_posix()}:{line}: {why}"
        for module, path in of_package
        for line, target in imported(module, path)
        if (why := offence(module, target, folders))
    ]


def test_imports_go_one_way() -> None:
    assert offences(SOURCE) == []


def write_package(root: Path, files: dict[str, str]) -> Path:
    """Write a package with these files, an empty folder for each name in `LAYERS`, and an extension."""
    empty = {f"{folder}/__init__.py": "" for folder in (*LAYERS, EXTENSIONS, f"{EXTENSIONS}/reference")}
    for name, text in ({"__init__.py": ""} | empty | files).items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root


@pytest.mark.parametrize(
    ("place", "text", "found"),
    [
        ("logic/bad.py", "import eai.world", "eai/logic/bad.py:1: logic must not import world"),
        ("logic/bad.py", "from eai import world", "eai/logic/bad.py:1: logic must not import world"),
        ("logic/bad.py", "from ..world import state", "eai/logic/bad.py:1: logic must not import world"),
        ("logic/bad.py", "\nfrom .. import world", "eai/logic/bad.py:2: logic must not import world"),
        ("logic/bad.py", "def f():\n    import eai.cli", "eai/logic/bad.py:2: logic must not import cli"),
        (
            "logic/__init__.py",
            "from ..world import x",
            "eai/logic/__init__.py:1: logic must not import world",
        ),
        ("planning/bad.py", "from eai.pddl import x", "eai/planning/bad.py:1: planning must not import pddl"),
        ("results/bad.py", "import eai.studies", "eai/results/bad.py:1: results must not import studies"),
        ("world/bad.py", "from inspect_ai import Task", "eai/world/bad.py:1: only run imports inspect_ai"),
        ("run/bad.py", "import gymnasium.spaces", "eai/run/bad.py:1: only agents imports gymnasium"),
        ("agents/bad.py", "import eai.run", "eai/agents/bad.py:1: agents must not import run"),
        ("studies/bad.py", "import eai.run", "eai/studies/bad.py:1: studies must not import run"),
        (
            "cli/bad.py",
            "def f():\n    from eai.extensions.reference import protocol",
            "eai/cli/bad.py:2: extensions.reference is found by its entry points, cli must not import it",
        ),
        (
            "extensions/other.py",
            "from eai.extensions.reference import protocol",
            "eai/extensions/other.py:1: extensions.reference is found by its entry points, "
            "extensions.other must not import it",
        ),
        ("kitchen.py", "", "eai/kitchen: has no place in LAYERS"),
    ],
)
def test_checker_finds(tmp_path: Path, place: str, text: str, found: str) -> None:
    assert offences(write_package(tmp_path / "eai", {place: text})) == [found]


@pytest.mark.parametrize(
    ("place", "text"),
    [
        ("world/good.py", "from eai.logic import formula\nfrom . import other\nimport json"),
        ("studies/good.py", "from eai.results import rate"),
        ("run/good.py", "import inspect_ai"),
        ("agents/good.py", "import gymnasium\nfrom eai.benchmarks import registry"),
        ("cli/good.py", "from eai import __version__, run, world"),
    ],
)
def test_checker_lets_pass(tmp_path: Path, place: str, text: str) -> None:
    assert offences(write_package(tmp_path / "eai", {place: text})) == []


def test_packages_say_what_they_are() -> None:
    silent = [
        name
        for name, path in modules(SOURCE)
        if path.name == "__init__.py" and not ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert silent == []


@pytest.mark.parametrize(
    "name", sorted(path.parent.name for path in SOURCE.glob(f"{EXTENSIONS}/*/__init__.py"))
)
def test_an_extension_names_its_entry_points_its_extra_and_its_page(name: str) -> None:
    declared = parse_toml((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    text = ast.get_docstring(ast.parse((SOURCE / EXTENSIONS / name / "__init__.py").read_text("utf-8"))) or ""
    points = {
        point: value
        for group in declared["entry-points"].values()
        for point, value in group.items()
        if value.startswith(f"eai.{EXTENSIONS}.{name}.")
    }
    assert points
    assert [point for point in points if f"`{point}`" not in text] == []
    extra = re.search(r"^Extra: (?:none|`([a-z]+)`)", text, re.MULTILINE)
    assert extra is not None
    assert extra[1] is None or extra[1] in declared["optional-dependencies"]
    page = re.search(r"^Page: (\S+)\.$", text, re.MULTILINE)
    assert page is not None
    assert page[1].startswith(f"docs/{EXTENSIONS}/{name}/")
    assert (ROOT / page[1]).is_file()


def test_the_public_face_loads_nothing_until_it_is_asked() -> None:
    code = "import sys, eai; print([name for name in sys.modules if name.startswith('eai.')])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_the_public_face_has_what_it_names() -> None:
    assert set(eai.__all__) == {*eai._PLACES, "open"}
    assert [name for name in eai.__all__ if not getattr(eai, name).__doc__] == []


def test_types_are_shipped() -> None:
    assert (SOURCE / "py.typed").is_file()


def import_report(folder: Path, names: list[str]) -> list[str]:
    """Return what some modules of a package's folder do when they are imported (see `import_watch.py`)."""
    command = [sys.executable, str(Path(__file__).with_name("import_watch.py")), str(folder), *names]
    environment = {
        "PYTHONPATH": str(folder.parent),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYDANTIC_DISABLE_PLUGINS": "__all__",  # plugins would be searched on disk
    }
    result = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


def test_importing_does_no_work_and_loads_nothing_slow() -> None:
    names = [name for name, _ in modules(SOURCE) if folder_of(name) not in OF_EXTRAS]
    assert import_report(SOURCE, names) == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("from pathlib import Path\nPath(__file__).read_text()", "work.py:2: open"),
        ("import os\nos.listdir('.')", "work.py:2: os.listdir"),
        ("import matplotlib", "loaded matplotlib"),
    ],
)
def test_report_finds(tmp_path: Path, text: str, found: str) -> None:
    report = import_report(write_package(tmp_path / "eai", {"work.py": text}), ["eai.work"])
    assert [line.rpartition("/")[2] for line in report] == [found]
