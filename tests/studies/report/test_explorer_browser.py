"""The explorer in a real browser."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlencode, urlparse

import pytest

from agents.switches import SWITCHES, WON
from browsing import needs_browser, open_explorer, wait_for_answer
from eai.abilities.protocol import Ability
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING
from eai.benchmarks.suite import open_suite
from eai.results.batch import Scoring
from eai.results.record import Record
from eai.results.responses import Response
from eai.results.runs import LogSamples, Run, RunKey, read_runs
from eai.studies.report.explorer import (
    DomainDataOfExplorerPage,
    ExplorerPageData,
    ObjectRectangle,
    SceneDiagrams,
    build_explorer_page,
)
from studies.report.samples import HOSTILE, all_runs, write_runs

pytestmark = needs_browser


def course(record: Record) -> SceneDiagrams:
    """A cup that is taken from a box in the third of four steps, of one answer."""
    if (record.task_id, record.ability) != ("1_1", Ability.ACTION_SEQUENCING):
        return ()
    cup, box, me = (ObjectRectangle(name, "object") for name in (HOSTILE, "box.4", "me.65"))
    full = ObjectRectangle("box.4", "object", ["CLOSED"], zones={"INSIDE": [cup]})
    holding = ObjectRectangle(
        "me.65", "agent", lines=["NEXT_TO \N{LEFT RIGHT ARROW} box.4"], zones={"HOLDS_RH": [cup]}
    )
    return [[me, full], [me, full], [me, full], [holding, box], [holding, box]]


ACTIONS = "virtualhome/action_sequencing/strict"


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The explorer of all sample runs, as an address on disk."""
    folder = tmp_path_factory.mktemp("explorer")
    background = DomainDataOfExplorerPage(
        prompts={"action_sequencing": {"11_1": f"Do this. {HOSTILE}"}},
        operators={"open": "(:action open :precondition (and (closed ?o) (can_open ?o)))"},
        instructions={"1_1": "Switch\n it on."},
        find_scenes=course,
    )
    data = ExplorerPageData(
        lambda domain: background if domain == "virtualhome" else DomainDataOfExplorerPage()
    )
    for run in read_runs([write_runs(folder, all_runs())]):
        data.add_run(run)
    page = folder / "explorer.html"
    page.write_text("".join(build_explorer_page(data.format_data_as_base64_lines())), encoding="utf-8")
    return page.as_uri()


def link(address: str, **parts: str) -> str:
    return f"{address}#{urlencode(parts)}"


def tally(page: Any) -> str:
    return str(page.locator(".tally strong").inner_text())


def test_filters_count_and_combine(page: Any, address: str) -> None:
    open_explorer(page, address)
    assert tally(page) == "48 answers"
    page.get_by_role("button", name="Action sequencing").click()
    assert tally(page) == "36 answers"
    page.get_by_role("button", name="Wrong order").first.click()
    assert tally(page) == "12 answers"
    assert page.get_by_role("button", name="Subgoal decomposition").locator(".count").inner_text() == "0"
    page.get_by_role("button", name="Clear all filters").click()
    assert tally(page) == "48 answers"


def test_search_finds_words_in_answers_and_reports_no_match(page: Any, address: str) -> None:
    open_explorer(page, address)
    page.keyboard.press("/")
    page.keyboard.type("answer 10")
    assert tally(page) == "3 answers"
    page.get_by_role("searchbox").fill("no such thing")
    assert "No answer is like that" in page.locator("#rows").inner_text()
    page.keyboard.press("Escape")
    assert page.evaluate("document.activeElement.id") != "search"


COUNT_READ_CHUNKS = """
window.readChunks = 0;
const { DecompressionStream } = window;
window.DecompressionStream = function (format) {
  window.readChunks += 1;
  return new DecompressionStream(format);
};
"""
"""Script that counts the chunks that the page decompresses."""


def test_details_are_read_when_an_answer_of_their_chunk_is_shown(page: Any, address: str) -> None:
    """At first the page reads the index, and details and prompts of the first answer's suite."""
    page.add_init_script(COUNT_READ_CHUNKS)
    open_explorer(page, link(address, run=f"{ACTIONS}/first", task="0_1"))
    assert page.evaluate("window.readChunks") == 3
    page.keyboard.press("j")
    assert page.locator(".heading h2").inner_text() == "name 1"
    page.get_by_role("button", name="side by side").first.click()
    assert page.locator(".side-run").count() == 2
    assert page.evaluate("window.readChunks") == 3
    open_explorer(page, link(address, run="virtualhome/transition_modeling/strict/first", task="0_1"))
    assert page.evaluate("window.readChunks") == 2


def test_only_the_first_search_reads_all_answers(page: Any, address: str) -> None:
    """Operators can be found by clauses that only the data set has."""
    page.add_init_script(COUNT_READ_CHUNKS)
    open_explorer(page, address)
    counts = []
    for words, found in (("can_open", "3 answers"), ("no such thing", "0 answers"), ("(can_", "3 answers")):
        page.get_by_role("searchbox").fill(words)
        page.locator(".tally strong", has_text=found).wait_for()
        wait_for_answer(page)
        counts.append(page.evaluate("window.readChunks"))
    assert counts[0] > 6
    assert counts == [counts[0]] * 3
    open_explorer(page, link(address, q="can_open"))
    assert tally(page) == "3 answers"


def test_a_page_that_cannot_be_read_says_so(browser: Any, address: str, tmp_path: Path) -> None:
    whole = Path(urlparse(address).path).read_text(encoding="utf-8")
    lines = whole.partition('id="data">')[2].partition("</script>")[0].split()
    damaged = tmp_path / "explorer.html"
    damaged.write_text(whole.replace(lines[-1], lines[-1][:400]), encoding="utf-8")
    context = browser.new_context()
    page = context.new_page()
    page.goto(damaged.as_uri())
    alert = page.get_by_role("alert")
    assert "It needs its whole file" in alert.inner_text()
    page.add_init_script("delete window.DecompressionStream")
    page.goto(address)
    assert "DecompressionStream is not defined. It needs" in alert.inner_text()
    context.close()


def test_replay_shows_changes_and_the_failing_check(page: Any, address: str) -> None:
    open_explorer(page, link(address, run=f"{ACTIONS}/first", task="1_1"))
    detail = page.locator("#detail")
    assert "Wrong order at step 4: box.4 is open" in detail.inner_text()
    assert "it would have been possible after step 1" in detail.inner_text()
    assert "prose" in detail.locator(".tags").inner_text()
    assert page.locator(".place").inner_text() == "step 4 of 4"
    state = page.locator(".state")
    assert "ONTOP(cup.3, bed.1)" in state.inner_text()
    page.keyboard.press("p")
    page.keyboard.press("p")
    assert page.locator(".place").inner_text() == "step 2 of 4"
    assert "NEXT_TO(me.65, bed.1)" in state.inner_text()
    assert "cup.3" not in state.inner_text()
    page.get_by_role("button", name="Next step").click()
    assert "HOLDS(me.65, cup.3)" in state.inner_text()
    assert page.locator(".goal-list.met").inner_text().startswith("Reached")
    assert "null" not in detail.inner_text()
    assert "undefined" not in detail.inner_text()


def test_pictures_show_the_state_before_and_after_each_step(page: Any, address: str) -> None:
    """A frame is around what changed; the picture before the first step is the start."""
    open_explorer(page, link(address, run=f"{ACTIONS}/first", task="1_1", step="3"))
    picture = page.locator(".picture")
    assert picture.locator("figcaption").inner_text() == "After step 3, GRAB(cup.3)"
    assert picture.locator(".tile.agent > .zone .tile strong").inner_text().startswith("</script>")
    changed = picture.locator(".tile.changed > strong").all_inner_texts()
    assert [text.partition("\n")[0] for text in changed][::2] == ["me.65", "box.4"]
    page.keyboard.press("p")
    assert picture.locator(".marks").inner_text() == "CLOSED"
    assert picture.locator(".tile.changed").count() == 0
    page.keyboard.press("p")
    page.keyboard.press("p")
    assert page.locator(".place").inner_text() == "the start"
    assert page.get_by_role("button", name="Previous step").is_disabled()
    here = page.url
    open_explorer(page, here)
    assert picture.locator("figcaption").inner_text() == "At the start"
    open_explorer(page, link(address, run=f"{ACTIONS}/first", task="0_1"))
    assert page.locator(".replay").count() == 1
    assert picture.count() == 0


def test_keys_move_through_the_list_and_update_the_address(page: Any, address: str) -> None:
    open_explorer(page, link(address, ability="action_sequencing", model="second"))
    page.keyboard.press("j")
    page.keyboard.press("j")
    page.keyboard.press("k")
    assert page.locator(".heading h2").inner_text() == "name 1"
    assert page.locator(".heading .id").inner_text() == "1_1"
    assert page.locator(".heading .instruction").inner_text() == "Switch it on."
    here = page.url
    assert "task=1_1" in here
    open_explorer(page, here)
    assert page.locator(".heading h2").inner_text() == "name 1"
    assert tally(page) == "12 answers"
    assert page.locator('.row[aria-selected="true"] .task').inner_text() == "name 1\n1_1"


def test_a_link_opens_its_step_and_a_broken_link_opens_the_list(page: Any, address: str) -> None:
    open_explorer(page, link(address, run=f"{ACTIONS}/first", task="1_1", step="2"))
    assert page.locator(".place").inner_text() == "step 2 of 4"
    page.goto(link(address, run="no/such/run", task="1_1", step="99", outcome="nonsense"))
    assert tally(page) == "0 answers"


def test_markup_in_answers_is_shown_as_text(page: Any, address: str) -> None:
    open_explorer(page, link(address, run=f"{ACTIONS}/first", task="11_1"))
    page.locator(".prompt summary").click()
    page.wait_for_timeout(100)
    assert page.title() == "eai explorer"
    assert "</script><script>" in page.locator(".raw pre").inner_text()
    assert "onerror" in page.locator(".prompt pre").inner_text()
    assert page.locator("#detail img, #detail script, #detail style").count() == 0
    assert page.evaluate("document.scripts.length") == 2


def test_two_runs_are_compared_side_by_side(page: Any, address: str) -> None:
    open_explorer(page, address)
    page.get_by_role("button", name="Compare runs").click()
    page.locator('select[data-run="a"]').select_option(
        label="first · strict · action sequencing · VirtualHome"
    )
    page.locator('select[data-run="b"]').select_option(
        label="second · strict · action sequencing · VirtualHome"
    )
    cells = page.locator(".cell strong").all_inner_texts()
    assert cells == ["8", "0", "4", "4", "4", "12"]
    wait_for_answer(page)
    assert page.locator(".row").count() == 8
    assert page.locator(".side-run").count() == 2
    page.get_by_role("button", name="only the second").click()
    assert page.locator(".row .why").first.inner_text() == "wrong order → success"
    here = page.url
    open_explorer(page, here)
    assert page.locator(".row").count() == 4


def test_goals_are_marked_as_found_missed_or_invented(page: Any, address: str) -> None:
    open_explorer(page, link(address, run="virtualhome/goal_interpretation/strict/first", task="0_1"))
    lists = page.locator(".goal-list").all_inner_texts()
    assert [text.split("\n")[0].split()[0] for text in lists] == ["Found", "Missed", "Invented", "Names"]
    assert "OFF(bed)" in lists[2]
    assert "sofaa" in lists[3]


def write_episodes(folder: Path, background: DomainDataOfExplorerPage) -> str:
    """Write the explorer of two agents that play the same task, and return its address."""
    suite = open_suite(SWITCHES, ACTING)
    plays = {name: EpisodeFactory(SWITCHES).begin_episode(suite.tasks["both"]) for name in ("good", "poor")}
    for command in (*WON, "DONE"):
        plays["good"].play_command(command, f"I try {command}. {HOSTILE}")
    for command in ("LOOK", "GO(moon)", *["WAVE"] * 16):
        plays["poor"].play_command(command)
    data = ExplorerPageData(lambda domain: background)
    logs: Mapping[str, LogSamples] = {"good": ({"both": "a.eval"}, {"both": 2}), "poor": ("b.eval", 1)}
    for name, play in plays.items():
        answer = [Response("both", play.write_as_json_text("stopped"))]
        records = tuple(Scoring().score_records(suite, name, answer, explanations=True))
        key = RunKey(suite.protocol, suite.domain, ACTING, name)
        data.add_run(Run(key, records, logs.get(name)))
    page = folder / "explorer.html"
    page.write_text("".join(build_explorer_page(data.format_data_as_base64_lines())), encoding="utf-8")
    return page.as_uri()


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> str:
    return write_episodes(tmp_path_factory.mktemp("episodes"), DomainDataOfExplorerPage())


def test_an_episode_is_replayed_turn_by_turn(page: Any, episodes: str) -> None:
    open_explorer(page, link(episodes, run="switches/acting/strict/good", task="both", step="3"))
    replay = page.locator(".replay")
    assert replay.locator(".place").inner_text() == "turn 3 of 5"
    goals = replay.locator(".goals-then li")
    assert goals.all_text_contents() == ["reached: lit(lamp)", "not reached: lit(torch)"]
    page.get_by_role("button", name="Next turn").click()
    assert goals.all_text_contents() == ["reached: lit(lamp)", "reached: lit(torch)"]
    words = replay.locator(".thought p").first
    assert not words.is_visible()
    replay.get_by_text("What the agent said").first.click()
    assert words.inner_text().startswith("I try PRESS(lamp). </script><script>document.title='owned'")
    viewer = page.get_by_role("link").get_attribute("href")
    assert viewer == "http://127.0.0.1:7575/#/logs/a.eval/samples/sample/both/2/"
    assert not page.locator(".raw pre").is_visible()


def test_faults_and_late_goals_of_an_episode_are_marked(page: Any, episodes: str) -> None:
    open_explorer(page, link(episodes, run="switches/acting/strict/poor", task="both"))
    viewer = page.get_by_role("link").get_attribute("href")
    assert viewer == "http://127.0.0.1:7575/#/logs/b.eval/samples/sample/both/1/"
    failed = page.locator(".step.failed")
    assert failed.locator(".verdict").all_inner_texts() == ["hallucination", "too late"]
    assert "you have not yet seen moon" in failed.first.inner_text()


def test_two_agents_are_replayed_side_by_side(page: Any, episodes: str) -> None:
    runs = {name: f"switches/acting/strict/{run}" for name, run in (("a", "good"), ("b", "poor"))}
    open_explorer(page, link(episodes, **runs, cell="all", task="both", step="2"))
    places = page.locator(".replay .place")
    assert places.all_inner_texts() == ["turn 2 of 5", "turn 2 of 16"]
    page.keyboard.press("n")
    assert places.all_inner_texts() == ["turn 3 of 5", "turn 3 of 16"]
    page.get_by_role("button", name="Next turn").nth(1).click()
    assert places.all_inner_texts() == ["turn 3 of 5", "turn 4 of 16"]


def test_operators_are_shown_beside_those_of_the_data_set(page: Any, address: str) -> None:
    open_explorer(page, link(address, run="virtualhome/transition_modeling/strict/first", task="0_1"))
    gold, written = (page.locator(".definition").nth(i) for i in (0, 1))
    assert gold.locator("mark.missing").inner_text() == "can_open"
    assert written.locator("mark.additional").inner_text() == "near"
    assert "unknown predicate in the precondition" in page.locator(".offences").inner_text()


def test_a_phone_shows_the_list_then_the_answer_without_overflow(browser: Any, address: str) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 844}, color_scheme="dark")
    page = context.new_page()
    open_explorer(page, address)
    wide = "document.documentElement.scrollWidth > document.documentElement.clientWidth"
    assert not page.evaluate(wide)
    assert not page.locator("#detail").is_visible()
    page.locator(".row").first.click()
    assert page.locator("#detail").is_visible()
    assert not page.evaluate(wide)
    assert not page.evaluate(wide.replace("Width", "Height"))
    page.get_by_role("button", name="← Answers").click()
    assert page.locator("#list").is_visible()
    page.get_by_role("button", name="Filters").click()
    assert page.get_by_role("navigation", name="Filters").is_visible()
    context.close()


def test_each_control_has_a_name_and_a_dark_theme_can_be_chosen(page: Any, address: str) -> None:
    open_explorer(page, address)
    nameless = "[...document.querySelectorAll('button, select, input')].filter(e => !e.innerText.trim()"
    nameless += " && !e.getAttribute('aria-label') && !e.closest('label')).length"
    assert page.evaluate(nameless) == 0
    color = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(color)
    page.keyboard.press("t")
    assert page.evaluate(color) != light
    page.keyboard.press("?")
    assert page.get_by_role("dialog", name="Keys").is_visible()
    page.keyboard.press("Escape")
    assert not page.get_by_role("dialog", name="Keys").is_visible()
