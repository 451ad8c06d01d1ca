"""A person's way through the form, in a real browser: gold answers come to what `eai/oracle` comes to."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from browsing import needs_browser
from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from suites import SUITES, answer_book, official_prompts

pytestmark = needs_browser


def opened_form(
    eai: Command, page: Any, folder: Path, domain: str, ability: Ability, tasks: list[str]
) -> None:
    file = folder / "form.html"
    options = ("--domain", domain, "--ability", ability.value, "--tasks", ",".join(tasks), "--out", file)
    assert eai("export", "prompts", *options).status == 0
    page.goto(file.as_uri())
    page.get_by_role("button", name="Begin").click()


def saved(page: Any, folder: Path, person: str = "person-1") -> Path:
    page.get_by_role("button", name="Save answers").click()
    page.get_by_label("A name of your choice").fill(person)
    with page.expect_download() as caught:
        page.get_by_role("button", name="Save the file").click()
    file = folder / caught.value.suggested_filename
    caught.value.save_as(file)
    return file


def rates(folder: Path) -> Mapping[str, Any]:
    return dict(json.loads((folder / "summary.json").read_text(encoding="utf-8")))


@pytest.mark.parametrize(("domain", "ability"), SUITES)
def test_gold_answers_come_to_what_the_oracle_comes_to(
    eai: Command, page: Any, data_store: DataPackStore, tmp_path: Path, domain: str, ability: Ability
) -> None:
    book = answer_book(domain, ability, data_store)
    tasks = [[*book][2], [*book][-1]]
    opened_form(eai, page, tmp_path, domain, ability, tasks)
    for number, task_id in enumerate(tasks):
        prompt = official_prompts(domain, ability, data_store)[task_id]
        assert page.locator("#user").evaluate("it => it.textContent") == prompt.user
        assert page.locator("#system").evaluate("it => it.textContent") == (prompt.system or "")
        page.get_by_label("Text of the answer").fill(book[task_id].text)
        if number == 0:
            page.get_by_role("button", name="Next").click()
    file = saved(page, tmp_path)
    rows = json.loads(file.read_text(encoding="utf-8"))
    assert file.name == "person-1_outputs.json"
    assert [(row["identifier"], row["llm_output"]) for row in rows] == [
        (task_id, book[task_id].text) for task_id in tasks
    ]
    oracle = tmp_path / "oracle_outputs.json"
    gold = [{"identifier": task_id, "llm_output": book[task_id].text} for task_id in tasks]
    oracle.write_text(json.dumps(gold), encoding="utf-8")
    for answers in (file, oracle):
        options = ("--domain", domain, "--ability", ability.value, "--planner", "built_in", "--allow-missing")
        assert eai("score", answers, *options, "--out", tmp_path / answers.stem).status == 0
    ours, theirs = (rates(tmp_path / name) for name in ("person-1_outputs", "oracle_outputs"))
    assert any(isinstance(rate, dict) and rate.get("numerator") for rate in ours.values())
    assert {**ours, "model": ""} == {**theirs, "model": ""}
    if domain == "virtualhome" and ability is Ability.ACTION_SEQUENCING:
        compared = eai("compare", tmp_path / "person-1_outputs", tmp_path / "oracle_outputs")
        assert compared.status == 0
        assert "2 tasks" in compared.out


def test_a_table_of_goals_becomes_an_answer(
    eai: Command, page: Any, data_store: DataPackStore, tmp_path: Path
) -> None:
    task = next(iter(official_prompts("behavior", Ability.GOAL_INTERPRETATION, data_store)))
    opened_form(eai, page, tmp_path, "behavior", Ability.GOAL_INTERPRETATION, [task])
    page.get_by_role("button", name="Fill in a table").click()
    states = page.get_by_role("group", name="State goals")
    relations = page.get_by_role("group", name="Relation goals")
    states.get_by_label("state").fill("open")
    states.get_by_label("object", exact=True).fill("jar.n.01_1")
    states.get_by_label("not").check()
    relations.get_by_label("relation").fill("ontop")
    relations.get_by_label("object", exact=True).fill("jar.n.01_1")
    relations.get_by_label("other object").fill("shelf.n.01_1")
    relations.get_by_role("button", name="Another one").click()
    answer = json.loads(page.get_by_label("Text of the answer").input_value())
    assert answer == {
        "node goals": [["not", ["open", "jar.n.01_1"]]],
        "edge goals": [["ontop", "jar.n.01_1", "shelf.n.01_1"]],
    }


def test_a_table_of_operators_becomes_an_answer(
    eai: Command, page: Any, data_store: DataPackStore, tmp_path: Path
) -> None:
    book = answer_book("virtualhome", Ability.TRANSITION_MODELING, data_store)
    task_id = next(iter(book))
    opened_form(eai, page, tmp_path, "virtualhome", Ability.TRANSITION_MODELING, [task_id])
    page.get_by_role("button", name="Fill in a table").click()
    first = book[task_id].parts[0].split()[1]
    page.get_by_label(f"effect of {first}", exact=True).fill("(holds_rh ?char ?obj1)")
    text = json.loads(page.get_by_label("Text of the answer").input_value())["output"]
    assert text.startswith(f"(:action {first}")
    assert ":effect (holds_rh ?char ?obj1)" in text
    assert text.count("(:action") == len(book[task_id].parts)


def test_what_is_not_answered_is_saved_as_such_and_time_is_told(
    eai: Command, page: Any, data_store: DataPackStore, tmp_path: Path
) -> None:
    tasks = list(official_prompts("virtualhome", Ability.ACTION_SEQUENCING, data_store))[:2]
    page.clock.install()
    opened_form(eai, page, tmp_path, "virtualhome", Ability.ACTION_SEQUENCING, tasks)
    page.get_by_label("Text of the answer").fill("no plan <script>")
    assert "not JSON" in page.locator("#remark").inner_text()
    page.clock.run_for(5_000)
    first, second = json.loads(saved(page, tmp_path, "../my name").read_text(encoding="utf-8"))
    assert (first["llm_output"], second["llm_output"], second["seconds"]) == ("no plan <script>", "", 0)
    assert first["seconds"] >= 5
    assert sorted(path.name for path in tmp_path.glob("*_outputs.json")) == ["_my_name_outputs.json"]
    page.get_by_role("button", name="Close").click()
    page.reload()
    page.get_by_role("button", name="Begin").click()
    assert page.get_by_label("Text of the answer").input_value() == "no plan <script>"
    assert page.locator("#jump").evaluate("it => it.selectedOptions[0].textContent") == "1 of 2 ✓"
