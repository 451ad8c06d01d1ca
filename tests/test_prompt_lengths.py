"""Tests that the table of prompt lengths on docs/running.md is up to date."""

from __future__ import annotations

from by_path import module_at
from eai.abilities.protocol import Ability

TOOL = module_at("tools/prompt_lengths.py")


def test_the_table_of_prompt_lengths_is_up_to_date() -> None:
    table = TOOL.PAGE.read_text(encoding="utf-8").partition(TOOL.BEGIN)[2].partition(TOOL.END)[0]
    assert len(table.splitlines()) == 2 + 12
    for domain in ("virtualhome", "behavior"):  # two suites stand for all, whose prompts take longer to make
        row = TOOL.row(domain, Ability.GOAL_INTERPRETATION)
        assert row in table, "run: python tools/prompt_lengths.py"
