"""Random plays are the same through all doors: a short run of `python -m bench random_plays`."""

from __future__ import annotations

import pytest

pytest.importorskip("mcp", reason="no mcp: pip install 'eai-bench[mcp]'")

from differential import random_plays


@pytest.mark.filterwarnings("ignore")  # Inspect's are none of ours
def test_random_plays_are_the_same_through_all_doors() -> None:
    check = random_plays.Check()
    random_plays.played(check, "agents.switches:SWITCHES", 60, 20, 20)
    assert check.differences == []
    assert {"gymnasium: observations", "Inspect: verdict", "MCP: won", "success as of a plan"} < {
        *check.counts
    }


@pytest.mark.filterwarnings("ignore")
def test_what_differs_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    check = random_plays.Check()
    monkeypatch.setattr(random_plays, "ODD", ("OPEN(",))  # no call of a tool makes this one
    random_plays.played(check, "agents.switches:SWITCHES", 0, 20, 0)
    assert check.differences
