"""The direction of imports, and what importing may cost.

`LAYERS` is the rule: a module may import from its own package and from the rows above its own, never from
a row below, nor from a sibling in its row except as `ALLOWED_SIBLINGS` says. A package or top-level module
without a place here is an offence: find it one. The root package loads nothing until it is asked, so that
importing any part stays cheap.
"""

from __future__ import annotations

import ast
import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import eai

SOURCE = Path(eai.__file__).parent

LAYERS: tuple[frozenset[str], ...] = tuple(
    frozenset(row.split())
    for row in (
        "errors",
        "data",
        "logic",
        "world",
        "planning",
        "pddl",
        "abilities",
        "prompts",
        "english tasks",
        "benchmark",
        "results",
        "generator households",
        "questions",
        "scoring",
        "bodies",
        "pictures",
        "reference",
        "studies",
        "envs",
        "acting",
        "harbor run report",
        "cli",
        "__main__",
    )
)
ALLOWED_SIBLINGS: frozenset[tuple[str, str]] = frozenset()
IMPORTED_BY_NONE = frozenset({"reference"})
"""Packages that are found by an entry point, so that the rest works without them."""
ONLY_IMPORTER = {"gymnasium": "envs", "inspect_ai": "run", "mcp": "acting", "mujoco": "bodies", "ray": "envs"}
OF_EXTRAS = frozenset({*ONLY_IMPORTER.values(), "acting", "harbor"})
"""Packages that load a library that not everybody installs, be it through another one of them."""


def rank(part: str) -> int | None:
    """The row of `LAYERS` in which a package or top-level module stands, if it stands in one."""
    return next((row for row, parts in enumerate(LAYERS) if part in parts), None)


def part_of(module: str) -> str:
    """The package or module directly below the root to which a module belongs; "" for the root itself."""
    return module.partition(".")[2].partition(".")[0]


def modules(root: Path) -> Iterator[tuple[str, Path]]:
    """Every module below a package's folder by dotted name, in a stable order."""
    for path in sorted(root.rglob("*.py")):
        names = path.relative_to(root.parent).with_suffix("").parts
        yield ".".join(names[:-1] if names[-1] == "__init__" else names), path


def imported(module: str, path: Path) -> Iterator[tuple[int, str]]:
    """Line and absolute name of all that a module imports, early or late (`from a import b` is `a.b`)."""
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.Import(names=names):
                yield from ((node.lineno, name.name) for name in names)
            case ast.ImportFrom(module=source, names=names, level=level):
                base = "." * level + (source or "")
                absolute = importlib.util.resolve_name(base, package) if level else base
                yield from ((node.lineno, f"{absolute}.{name.name}") for name in names)


def offence(importer: str, target: str, parts: frozenset[str]) -> str | None:
    """Why a module must not import a target, or None where it may."""
    library = target.partition(".")[0]
    here, there = part_of(importer), part_of(target)
    if ONLY_IMPORTER.get(library, here) != here:
        return f"only {ONLY_IMPORTER[library]} imports {library}"
    if library != importer.partition(".")[0]:
        return None
    if here == "":  # the public face, which loads what is asked for: see the test of what importing it loads
        return None
    if here == there or there not in parts:  # its own package, or a name that the root itself defines
        return None
    if there in IMPORTED_BY_NONE:
        return f"{there} is found by an entry point, {here} must not import it"
    here_rank, there_rank = rank(here), rank(there)
    if here_rank is None or there_rank is None:
        return None  # reported once, as a part without a place
    if there_rank < here_rank or (here, there) in ALLOWED_SIBLINGS:
        return None
    return f"{here} must not import {there}"


def offences(root: Path) -> list[str]:
    """All that breaks the rule below a package's folder, as `file:line: why`."""
    found = list(modules(root))
    parts = frozenset(part_of(module) for module, _ in found) - {""}
    homeless = [f"{root.name}/{part}: has no place in LAYERS" for part in sorted(parts) if rank(part) is None]
    return homeless + [
        f"{path.relative_to(root.parent).as_posix()}:{line}: {why}"
        for module, path in found
        for line, target in imported(module, path)
        if (why := offence(module, target, parts))
    ]


def test_imports_go_one_way() -> None:
    assert offences(SOURCE) == []


def write_package(root: Path, files: dict[str, str]) -> Path:
    """A package made of files by path, with an empty part of each name in `LAYERS` beside them."""
    empty = {f"{part}/__init__.py": "" for parts in LAYERS for part in parts}
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
        ("run/bad.py", "import gymnasium.spaces", "eai/run/bad.py:1: only envs imports gymnasium"),
        ("envs/bad.py", "import eai.run", "eai/envs/bad.py:1: envs must not import run"),
        ("report/bad.py", "import eai.run", "eai/report/bad.py:1: report must not import run"),
        (
            "cli/bad.py",
            "def f():\n    from eai.extensions.reference import protocol",
            "eai/cli/bad.py:2: reference is found by an entry point, cli must not import it",
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
        ("envs/good.py", "import gymnasium\nfrom eai.benchmarks import registry"),
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
    """What importing some modules of a package's folder did beyond importing (see `import_watch`)."""
    command = [sys.executable, str(Path(__file__).with_name("import_watch.py")), str(folder), *names]
    environment = {
        "PYTHONPATH": str(folder.parent),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYDANTIC_DISABLE_PLUGINS": "__all__",  # or its first model looks for them on disk
    }
    result = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


def test_importing_does_no_work_and_loads_nothing_slow() -> None:
    names = [name for name, _ in modules(SOURCE) if part_of(name) not in OF_EXTRAS]
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
