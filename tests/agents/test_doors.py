"""Random plays are the same through gymnasium, Inspect's tools and MCP: bench/random_plays.py in short."""

from __future__ import annotations

from types import ModuleType

import pytest

from by_path import module_at

pytest.importorskip("mcp", reason="no mcp: pip install 'eai-bench[mcp]'")


@pytest.fixture
def bench() -> ModuleType:
    return module_at("bench/random_plays.py")


@pytest.mark.filterwarnings("ignore")  # Inspect's are none of ours
def test_random_plays_are_the_same_through_all_doors(bench: ModuleType) -> None:
    check = bench.Check()
    bench.played(check, "agents.switches:SWITCHES", 60, 20, 20)
    assert check.differences == []
    assert {"gymnasium: observations", "Inspect: verdict", "MCP: won", "success as of a plan"} < {
        *check.counts
    }


@pytest.mark.filterwarnings("ignore")
def test_what_differs_is_found(bench: ModuleType) -> None:
    check = bench.Check()
    bench.ODD = ("OPEN(",)  # no call of a tool makes this one
    bench.played(check, "agents.switches:SWITCHES", 0, 20, 0)
    assert check.differences
