"""Diagrams of the states of an episode, in the explorer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from agents.switches import SWITCHES
from browsing import needs_browser, open_explorer
from eai.agents.setting import ACTING
from eai.benchmarks.suite import open_suite
from eai.extensions.scenes.course import make_scene_diagrams_after_each_step
from eai.studies.report.explorer import DomainDataOfExplorerPage
from studies.report.test_explorer_browser import link, write_episodes

pytestmark = needs_browser


def test_a_turn_is_shown_with_the_objects_that_it_changed(page: Any, tmp_path: Path) -> None:
    suite = open_suite(SWITCHES, ACTING)
    address = write_episodes(
        tmp_path,
        DomainDataOfExplorerPage(
            find_scenes=lambda record: make_scene_diagrams_after_each_step(record, suite)
        ),
    )
    open_explorer(page, link(address, run="switches/acting/strict/good", task="both", step="3"))
    page.get_by_role("button", name="Next turn").click()
    changed = page.locator(".picture .tile.changed > strong").all_inner_texts()
    assert [text.partition("\n")[0] for text in changed] == ["torch"]
    open_explorer(page, link(address, run="switches/acting/strict/poor", task="both"))
    assert page.locator(".picture .tile").count()
