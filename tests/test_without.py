"""Tests that the package works without its extensions; `tools/without.py` also runs the other tests."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from by_path import module_at
from eai.abilities.protocol import PAPER_ABILITIES
from sweeps import swept

TOOL = module_at("tools/without.py")


@pytest.mark.parametrize(
    ("arguments", "names"), [([], [*TOOL.NAMES, TOOL.ALL]), ([TOOL.ALL], [TOOL.ALL]), (["board"], ["board"])]
)
def test_all_extensions_are_removed_in_turn_if_none_is_named(arguments: list[str], names: list[str]) -> None:
    assert TOOL.parse_arguments([*arguments, "--", "-n", "2"]) == (names, ["-n", "2"])


@pytest.fixture(
    scope="module",
    params=[TOOL.ALL, "reference", *swept(*(name for name in TOOL.NAMES if name != "reference"))],
)
def gone(request: pytest.FixtureRequest) -> tuple[str, ...]:
    """Return the names of the removed extensions: all, or one."""
    return TOOL.NAMES if request.param == TOOL.ALL else (request.param,)


@pytest.fixture(scope="module")
def folder(gone: tuple[str, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a copy of the package without the extensions."""
    return TOOL.package_without(gone, tmp_path_factory.mktemp("without")).parent


def run(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "200"}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, env=environment)


def printed_by(folder: Path, *arguments: str) -> str:
    """Run a command that must succeed, and return its output."""
    code = f"import sys; sys.argv = ['eai', *{arguments!r}]; from eai.cli import main; main()"
    finished = run(folder, code)
    assert finished.returncode == 0, finished.stderr
    return finished.stdout


def test_all_modules_that_are_left_are_imported(folder: Path) -> None:
    finished = TOOL.import_all(folder / "eai")
    assert (finished.returncode, finished.stderr) == (0, "")
    assert finished.stdout.strip() == str(folder / "eai")


def test_the_commands_that_are_left_are_listed(gone: tuple[str, ...], folder: Path) -> None:
    listed = printed_by(folder, "--help")
    assert "Score answers" in listed
    assert ("Play tasks yourself" in listed) is ("people" not in gone)


@pytest.mark.parametrize("command", ["score", "run"])
def test_help_lists_the_protocols_that_are_left(command: str, gone: tuple[str, ...], folder: Path) -> None:
    listed = printed_by(folder, command, "--help")
    assert "strict" in listed
    assert ("eai-1.0.5" in listed) is ("reference" not in gone)
    assert {ability for ability in PAPER_ABILITIES if ability in listed} == {*PAPER_ABILITIES}


def test_the_studies_that_are_left_are_listed(gone: tuple[str, ...], folder: Path) -> None:
    listed = printed_by(folder, "analyze")
    assert "**errors**" in listed
    assert ("**items**" in listed) is ("adaptive" not in gone)


def test_a_protocol_that_is_gone_is_refused_in_a_line(gone: tuple[str, ...], folder: Path) -> None:
    if "reference" not in gone:
        pytest.skip("the protocol is there")
    error = run(folder, "import eai; eai.open('virtualhome', 'action_sequencing', 'eai-1.0.5')").stderr
    expected = "InputError: protocol eai-1.0.5 is not installed: expected one of strict"
    assert error.splitlines()[-1].endswith(expected)


def test_a_value_that_an_extension_would_know_is_refused_in_a_line(
    gone: tuple[str, ...], folder: Path
) -> None:
    if "alfworld" not in gone:
        pytest.skip("the extension is there")
    error = run(folder, "import eai; eai.find_benchmark('alfworld:games')").stderr
    assert "InputError: alfworld:games: " in error.splitlines()[-1]
