"""The package works without any one of some folders; `tools/without.py` runs the tests of the rest, too."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import eai
from base.test_entry_points import declared
from by_path import module_at
from eai.abilities.protocol import FOUR
from sweeps import swept

SOURCE = Path(eai.__file__).parent

TOOL = module_at("tools/without.py")
FEW = ("reference", "abilities/transition_modeling", "households/virtualhome", "studies/errors")


@pytest.fixture(scope="module", params=[*FEW, *swept(*(each for each in TOOL.FOLDERS if each not in FEW))])
def without(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """A folder of the package, and where there is a copy of the package without it."""
    folder: str = request.param
    return folder, TOOL.package_without(folder, tmp_path_factory.mktemp("without")).parent


def run(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "200"}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, env=environment)


@cache
def whole(code: str) -> subprocess.CompletedProcess[str]:
    """What comes of it where no folder is gone."""
    return run(SOURCE.parent, code)


def test_all_that_is_left_is_imported(without: tuple[str, Path]) -> None:
    _, place = without
    done = TOOL.imports_without(place / "eai")
    assert (done.returncode, done.stderr, done.stdout.strip()) == (0, "", str(place / "eai"))


def test_benchmarks_and_packs_are_those_that_are_left(without: tuple[str, Path]) -> None:
    folder, place = without
    asked = "import eai; from eai.benchmarks.packs import registered_packs as packs; "
    asked += "print([*eai.registered()], [pack.name for pack in packs()])"
    left = run(place, asked)
    assert (left.returncode, whole(asked).returncode) == (0, 0), left.stderr
    above, _, name = folder.rpartition("/")
    if above != "households":
        assert left.stdout == whole(asked).stdout
        return
    gone = {f"'{name}'", f"'{name.replace('_', '-')}'"}
    counts = [sum(map(found.stdout.count, gone)) for found in (whole(asked), left)]
    assert counts == [2, 0], "its benchmark and its pack"


@pytest.mark.parametrize("command", ["score", "run"])
def test_help_lists_the_protocols_that_are_left(command: str, without: tuple[str, Path]) -> None:
    folder, place = without
    asked = f"import sys; sys.argv = ['eai', {command!r}, '--help']; from eai.cli import main; main()"
    left = run(place, asked)
    assert left.returncode == 0, left.stderr
    assert "strict" in left.stdout
    assert ("eai-1.0.5" in left.stdout) is (folder != "reference")


def test_help_lists_the_abilities_that_are_left(without: tuple[str, Path]) -> None:
    folder, place = without
    asked = "import sys; sys.argv = ['eai', 'score', '--help']; from eai.cli import main; main()"
    left = run(place, asked)
    assert left.returncode == 0, left.stderr
    (line,) = [line for line in left.stdout.splitlines() if "--ability  " in line]
    listed = {ability for ability in FOUR if ability in line}
    assert listed == {ability for ability in FOUR if folder != f"abilities/{ability}"}


def test_help_lists_the_studies_that_are_left(without: tuple[str, Path]) -> None:
    _, place = without
    asked = "import sys; sys.argv = ['eai', 'analyze']; from eai.cli import main; main()"
    left = run(place, asked)
    assert left.returncode == 0, left.stderr
    studies = declared("eai.studies")
    missing = {name for name in studies if f"**{name}**" not in left.stdout}
    gone = [f".{folder.replace('/', '.')}." for folder in TOOL.gone_from(place / "eai")]
    assert missing == {name for name, place in studies.items() if any(each in place for each in gone)}


def test_a_protocol_that_is_not_there_is_refused_in_a_line(without: tuple[str, Path]) -> None:
    folder, place = without
    if folder != "reference":
        pytest.skip("the protocol is there")
    asked = "import eai; eai.open('virtualhome', 'action_sequencing', 'eai-1.0.5')"
    error = run(place, asked).stderr.splitlines()[-1]
    assert error.endswith("InputError: protocol eai-1.0.5 is not installed: expected one of strict")


def test_tests_about_a_folder_are_known_also_by_what_they_import(tmp_path: Path) -> None:
    for name, text in {
        "a": "from eai.benchmarks import behavior",
        "b": "import a",
        "c": "import eai",
    }.items():
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    assert {path.stem for path in TOOL.tests_about("households/behavior", tmp_path)} == {"a", "b"}
