"""Protocols are found by name, and the package does without those that are taken out of it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

import eai
from eai.abilities.protocol import (
    BUILT_IN,
    GROUP,
    PROTOCOLS,
    PROTOCOLS_BUILT_IN,
    Ability,
    Protocol,
    registered_protocols,
)
from eai.benchmark import protocols
from eai.benchmark.suite import open_suite
from eai.data import entry_points
from eai.errors import InputError

SOURCE = Path(eai.__file__).parent
METADATA = SOURCE.parents[1] / "pyproject.toml"


def declared(group: str) -> dict[str, str]:
    """The entry points of a group that the package declares."""
    tomllib: Any = pytest.importorskip("tomllib" if sys.version_info >= (3, 11) else "tomli")
    if not METADATA.is_file():
        pytest.skip("the package is installed, not a source tree")
    return dict(tomllib.loads(METADATA.read_text(encoding="utf-8"))["project"]["entry-points"][group])


@pytest.mark.parametrize(("group", "built_in"), [(GROUP, BUILT_IN), (PROTOCOLS, PROTOCOLS_BUILT_IN)])
def test_what_is_built_in_is_what_the_package_declares(group: str, built_in: dict[str, str]) -> None:
    assert declared(group) == built_in


def test_protocols_are_found_by_name() -> None:
    assert [*registered_protocols()] == ["eai-1.0.5"]
    assert isinstance(protocols.implementation_of("eai-1.0.5"), protocols.Implementation)
    assert protocols.implementation_of("eai-1.0.6") is None


def test_another_distribution_adds_one(monkeypatch: pytest.MonkeyPatch) -> None:
    theirs = EntryPoint("theirs", "theirs.rules:RULES", PROTOCOLS)
    gone = EntryPoint("gone", "eai.no_such_package.rules:RULES", PROTOCOLS)
    monkeypatch.setattr(entry_points, "entry_points", lambda group: [theirs, gone])
    found = entry_points.entry_points_of(PROTOCOLS, PROTOCOLS_BUILT_IN)
    assert list(found) == ["eai-1.0.5", "theirs"]


def test_a_benchmark_that_a_protocol_does_not_score_is_refused() -> None:
    with pytest.raises(InputError, match=r"virtualhome-rules is not scored under eai-1\.0\.5"):
        open_suite("rules:virtualhome", Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5"))


@pytest.fixture(scope="module")
def without_the_reference(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a copy of the package out of which the reference's protocol is taken."""
    folder = tmp_path_factory.mktemp("without")
    left_out = shutil.ignore_patterns("reference", "__pycache__", "*.so")
    shutil.copytree(SOURCE, folder / "eai", ignore=left_out)
    return folder


def run(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "200"}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, env=environment)


IMPORT_ALL = """
import eai, importlib, pathlib
root = pathlib.Path(eai.__file__).parent
for path in sorted(root.rglob("*.py")):
    parts = ("eai", *path.relative_to(root).with_suffix("").parts)
    if parts[1] not in ("run", "envs", "__main__"):  # which need what not everybody installs
        importlib.import_module(".".join(parts).removesuffix(".__init__"))
print(root)
"""


def test_the_package_imports_without_the_reference(without_the_reference: Path) -> None:
    done = run(without_the_reference, IMPORT_ALL)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.strip() == str(without_the_reference / "eai")


@pytest.mark.parametrize("command", ["score", "run"])
def test_help_lists_the_protocols_that_are_left(command: str, without_the_reference: Path) -> None:
    asked = f"import sys; sys.argv = ['eai', {command!r}, '--help']; from eai.cli import main; main()"
    left, whole = run(without_the_reference, asked), run(SOURCE.parent, asked)
    assert left.returncode == whole.returncode == 0, left.stderr
    assert "eai-1.0.5" in whole.stdout
    assert "eai-1.0.5" not in left.stdout
    assert "strict" in left.stdout


def test_a_protocol_that_is_not_there_is_refused_in_a_line(without_the_reference: Path) -> None:
    asked = "import eai; eai.open('virtualhome', 'action_sequencing', 'eai-1.0.5')"
    error = run(without_the_reference, asked).stderr.splitlines()[-1]
    assert error.endswith("InputError: protocol eai-1.0.5 is not installed: expected one of strict")
