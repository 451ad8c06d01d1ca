from __future__ import annotations

import subprocess
import sys
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from pathlib import Path
from typing import Any

import pytest

import eai
from by_path import ROOT
from eai.abilities.protocol import ABILITY_GROUP, Ability
from eai.base import entry_points as module
from eai.base.errors import InputError
from eai.benchmarks.registry import list_benchmarks

PYPROJECT = ROOT / "pyproject.toml"
GROUPS = ("eai.abilities", "eai.benchmarks", "eai.commands", "eai.packs", "eai.protocols", "eai.studies")


def declared(group: str) -> dict[str, str]:
    """Return the entry points of a group in pyproject.toml."""
    tomllib: Any = pytest.importorskip("tomllib" if sys.version_info >= (3, 11) else "tomli")
    if not PYPROJECT.is_file():
        pytest.skip("the package is installed, not a source tree")
    return dict(tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]["entry-points"][group])


@pytest.mark.parametrize("group", GROUPS)
def test_the_installed_entry_points_equal_those_of_the_source_tree(group: str) -> None:
    installed = entry_points().select(group=group)
    ours = {point.name: point.value for point in installed if point.module.startswith("eai.")}
    assert ours == declared(group), "install the source tree again: pip install -e ."


def test_the_entry_points_of_all_distributions_equal_those_of_importlib() -> None:
    points = [point for group in entry_points().groups for point in entry_points().select(group=group)]
    read = module._read_all_entry_points(tuple(sys.path))
    assert {(point.group, point.name, point.value) for point in points} == {
        (point.group, point.name, point.value) for point in read
    }
    assert {(point.module, point.attr or "") for point in points} == {(p.module, p.attr) for p in read}


def test_comments_spaces_and_extras_are_ignored(tmp_path: Path) -> None:
    file = tmp_path / "entry_points.txt"
    file.write_text("# ours\n[eai.commands]\n; theirs\n\ndata  nap = naps.all : nap [sleep]\n")
    (point,) = module._read_entry_points_file(file)
    assert (point.group, point.name) == ("eai.commands", "data  nap")
    assert (point.module, point.attr) == ("naps.all", "nap")


def test_a_module_that_exits_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "exiting_study.py").write_text("raise SystemExit(0)\n")
    monkeypatch.syspath_prepend(tmp_path)
    message = r"^exiting_study \(entry point mine of eai\.studies\): the import calls sys\.exit\(0\)"
    with pytest.raises(InputError, match=message):
        module.EntryPoint("mine", "exiting_study:STUDY", "eai.studies").load()


def test_abilities_and_benchmarks_are_listed_in_the_order_of_the_paper() -> None:
    paper = ["goal_interpretation", "subgoal_decomposition", "action_sequencing", "transition_modeling"]
    assert [*Ability.list_names()][: len(paper)] == paper
    assert list_benchmarks()[:2] == ("virtualhome", "behavior")


def test_other_entry_points_follow_by_name_and_absent_modules_are_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    points = [
        EntryPoint("theirs", "theirs.rules:RULES", ABILITY_GROUP),
        EntryPoint("absent", "eai.no_such_package.rules:RULES", ABILITY_GROUP),
        EntryPoint("last", "eai.base.errors:InputError", ABILITY_GROUP),
        EntryPoint("added", "theirs.rules:MORE", ABILITY_GROUP),
    ]
    monkeypatch.setattr(module, "_read_all_entry_points", lambda path: EntryPoints(points))
    assert list(module.get_entry_points(ABILITY_GROUP, ("last", "none"))) == ["last", "added", "theirs"]
    assert module.get_entry_point_names(ABILITY_GROUP) == ["absent", "added", "last", "theirs"]
    assert [*Ability.list_names()] == ["absent", "added", "last", "theirs"]


NOT_INSTALLED = """
import sys
sys.path[:] = [sys.argv.pop(1), *(each for each in sys.path if "site-packages" not in each)]
from eai.base.entry_points import get_entry_points
get_entry_points("eai.studies")
"""


def test_the_error_for_a_source_tree_without_metadata_says_what_to_do() -> None:
    source = str(Path(eai.__file__).parents[1])
    command = [sys.executable, "-c", NOT_INSTALLED, source]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    error = done.stderr.splitlines()[-1]
    assert error.startswith(f"{InputError.__module__}.InputError: no entry points of eai.studies: eai is not")
    assert "pip install -e ." in error
