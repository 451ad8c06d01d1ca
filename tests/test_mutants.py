"""The tool that makes mutants: what it changes, and that its list of equivalent ones is not out of date."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("mutants_tool", ROOT / "tools" / "mutants.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_what_says_nothing_of_what_is_done_is_left_alone(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = tmp_path / "src" / "eai" / "sample.py"
    module.parent.mkdir(parents=True)
    module.write_text(
        "@dataclass(frozen=True)\nclass A:\n    b: int | None = 3\n\n"
        "def f(a: int | None) -> int | None:\n    return [i for i in a if i < 2 or i]\n\n"
        "pairs = list(zip(a, b, strict=True))\nhappens = rng.random() < 0.5\n"
    )
    monkeypatch.setattr(tool, "ROOT", tmp_path)
    made = {(mutant.line, mutant.change): mutant.text() for mutant in tool.mutants(Path("sample.py"))}
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
        tests = tool._tests_of(Path(path))
        return [[each.relative_to(ROOT / "tests").as_posix() for each in some] for some in tests]

    own, package, elsewhere, last = names("results/attempts.py")
    assert (own, package, last) == (["results/test_attempts.py"], ["results"], ["households"])
    assert "studies/test_replanning.py" in elsewhere
    own, package, *_ = names("abilities/subgoal_decomposition/__init__.py")
    assert (own, package) == ([], ["abilities/subgoal_decomposition"])


def test_what_is_listed_as_meaning_the_same_can_still_be_made(tool: ModuleType) -> None:
    paths = {Path(name.partition(":")[0]) for name in tool.EQUIVALENT}
    assert tool.EQUIVALENT.keys() <= {mutant.name for path in paths for mutant in tool.mutants(path)}
