"""Tests of the tool that makes mutants: its changes, and its list of equivalent mutants."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from by_path import ROOT, module_at


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    return module_at("tools/mutants.py")


def test_code_without_effect_on_results_is_never_changed(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = tmp_path / "src" / "eai" / "sample.py"
    module.parent.mkdir(parents=True)
    module.write_text(
        "@dataclass(frozen=True)\nclass A:\n    b: int | None = 3\n\n"
        "def f(a: int | None) -> int | None:\n    return [i for i in a if i < 2 or i]\n\n"
        "if TYPE_CHECKING:\n    import x\n"
        "pairs = list(zip(a, b, strict=True))\nhappens = rng.random() < 0.5\n"
    )
    monkeypatch.setattr(tool, "ROOT", tmp_path)
    made = {(mutant.line, mutant.change): mutant.text() for mutant in tool.make_mutants(Path("sample.py"))}
    assert sorted(made) == [
        (3, "3 is 4"),
        (6, "2 is 3"),
        (6, "Lt is LtE"),
        (6, "Or is And"),
        (6, "without if i < 2 or i"),
    ]
    assert "b: int | None = 4" in made[3, "3 is 4"]
    assert "i <= 2" in made[6, "Lt is LtE"]


def test_the_tests_of_a_module_are_those_that_may_meet_it_nearest_first(tool: ModuleType) -> None:
    def names(path: str) -> list[list[str]]:
        tests = tool._find_tests_by_distance(Path(path))
        return [[each.relative_to(ROOT / "tests").as_posix() for each in some] for some in tests]

    own, package, elsewhere, last = names("results/tidy.py")
    assert (own, package, last) == (["results/test_tidy.py"], ["results"], ["benchmarks"])
    assert "studies/test_error_leaves.py" in elsewhere
    own, package, *_ = names("abilities/subgoal_decomposition/__init__.py")
    assert (own, package) == ([], ["abilities/subgoal_decomposition"])


def test_every_listed_equivalent_mutant_can_still_be_made(tool: ModuleType) -> None:
    paths = {Path(name.partition(":")[0]) for name in tool.EQUIVALENT}
    assert tool.EQUIVALENT.keys() <= {mutant.name for path in paths for mutant in tool.make_mutants(path)}


def test_tests_that_failed_before_and_quick_tests_come_first(tmp_path: Path) -> None:
    module = module_at("tools/quick_first.py")
    file = tmp_path / "known.json"
    file.write_text(
        '{"took": {"slow": 9, "quick": 0.1, "near/quick": 0.1, "failed": 8}, "failed": {"failed": 9}}'
    )
    names = ["slow", "failed", "new", "quick", "near/quick"]
    assert module.QuickFirst(file, math.inf, ("near/",)).choose(names) == [
        "failed",
        "near/quick",
        "quick",
        "new",
        "slow",
    ]
    assert module.QuickFirst(file, 8.7, ()).choose(names) == ["failed", "quick", "near/quick", "new"]
    assert module.QuickFirst(file, 1, ()).choose(["slow"]) == ["slow"]


def test_a_mutant_is_noticed_where_a_test_fails(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tool runs the tests that fit into the time; sweeps run only for the whole set."""
    module, test = tmp_path / "src" / "eai" / "sample.py", tmp_path / "tests" / "test_sample.py"
    for each in (module, test):
        each.parent.mkdir(parents=True)
    (module.parent / "__init__.py").touch()
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = sweep\n")
    (tmp_path / "conftest.py").write_text(
        "from hypothesis import settings\nsettings.register_profile('thorough', max_examples=9)\n"
    )
    shutil.copytree(ROOT / "tools", tmp_path / "tools")
    module.write_text("near = 1\nfar = 3\n")
    test.write_text(
        "import pytest\nimport eai.sample as s\n\ndef test_near():\n    assert s.near == 1\n\n"
        "@pytest.mark.sweep\ndef test_far():\n    assert s.far == 3\n"
    )
    monkeypatch.setattr(tool, "ROOT", tmp_path)
    monkeypatch.setattr(tool, "_find_tests_by_distance", lambda path: iter([[test], [test], []]))
    shutil.copytree(tmp_path / "src", tmp_path / "copy" / "src")

    near, far = tool.make_mutants(Path("sample.py"))
    default, whole = (tool.Trial(tmp_path / "copy", 9, whole) for whole in (False, True))
    assert [default.is_noticed(each) for each in (near, far)] == [True, False]
    assert whole.is_noticed(far)
