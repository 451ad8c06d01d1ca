"""Random episodes are equal through all interfaces: a short run of `python -m bench random_plays`."""

from __future__ import annotations

import pytest

pytest.importorskip("mcp", reason="no mcp: pip install 'eai-bench[mcp]'")

from differential import random_plays


@pytest.mark.filterwarnings("ignore")  # Inspect issues warnings of its own
def test_random_plays_are_the_same_through_all_doors() -> None:
    check = random_plays.Check()
    random_plays.played(check, "agents.switches:SWITCHES", 60, 20, 20)
    assert check.differences == []
    assert {"gymnasium: observations", "Inspect: verdict", "MCP: won", "success as of a plan"} < {
        *check.counts
    }


@pytest.mark.filterwarnings("ignore")
def test_a_difference_between_interfaces_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    check = random_plays.Check()
    monkeypatch.setattr(random_plays, "ODD", ("OPEN(",))  # no tool call gives this command
    random_plays.played(check, "agents.switches:SWITCHES", 0, 20, 0)
    assert check.differences
