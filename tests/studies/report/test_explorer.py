from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from eai.abilities.explanation import Explanation, GoalReport, StepReport, parse_statement
from eai.results.page import encode_for_script
from eai.results.runs import read_runs
from eai.studies.report.explorer import ExplorerData, ExplorerDomainData, build_explorer_page
from studies.report.samples import HOSTILE, action_run, all_runs, write_runs

BACKGROUND = ExplorerDomainData(
    prompts={"action_sequencing": {"0_1": f"Do this.\n{HOSTILE}", "none": "?"}},
    operators={"open": "(:action open :parameters (?o))"},
)


@pytest.fixture
def data(tmp_path: Path) -> str:
    packed = ExplorerData(lambda domain: BACKGROUND if domain == "virtualhome" else ExplorerDomainData())
    for run in read_runs([write_runs(tmp_path, all_runs())]):
        packed.add_run(run)
    return packed.to_json()


def test_no_text_in_the_data_can_end_the_script_element(data: str) -> None:
    assert not set("<>&") & set(data)
    assert data.isascii()
    page = build_explorer_page(data)
    assert page.count("</script>") == 2
    assert page.count("owned") == data.count("owned") > 0


def test_the_page_allows_only_its_own_style_and_program(data: str) -> None:
    page = build_explorer_page(data)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy is not None
    assert "default-src 'none'" in policy[1]
    assert "unsafe" not in policy[1]
    for tag, rule in (("style", "style-src"), ("script", "script-src")):
        (text,) = re.findall(f"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{rule} 'sha256-{digest}'" in policy[1]
    assert not re.search(r"(?:src|href)=|https?://|url\(", page.replace(data, ""))


def test_each_text_is_stored_once_and_each_answer_is_present(data: str) -> None:
    content = json.loads(data)
    assert len(set(content["texts"])) == len(content["texts"])
    answers = [answer for run in content["runs"] for answer in run["answers"]]
    assert len(answers) == 12 * 3 + 4 + 5 + 3
    first = content["runs"][0]
    assert (first["protocol"], first["ability"]) == ("strict", "goal_interpretation")
    assert len(content["steps"]) == 4
    assert HOSTILE in content["texts"]


def test_only_prompts_of_answered_tasks_are_stored(data: str) -> None:
    content = json.loads(data)
    assert list(content["prompts"]) == ["virtualhome/action_sequencing"]
    lines = content["prompts"]["virtualhome/action_sequencing"]["0_1"]
    assert content["texts"][lines[0]] == "Do this."
    assert set(content["prompts"]["virtualhome/action_sequencing"]) == {"0_1"}


def test_a_missed_goal_shows_the_facts_that_hold_instead(tmp_path: Path) -> None:
    steps = (StepReport("PUT(a, b)", "executed", added=("INSIDE(a, b)",), call=parse_statement("PUT(a, b)")),)
    goals = (GoalReport("relation", "ONTOP(a, b)", False), GoalReport("state", "ON(a)", True))
    answer = replace(action_run()[0], explanation=Explanation(steps=steps, goals=goals))
    packed = ExplorerData()
    for run in read_runs([write_runs(tmp_path, [[answer]])]):
        packed.add_run(run)
    content = json.loads(packed.to_json())
    (row,) = content["runs"][0]["answers"]
    missed, met = row["G"]
    said = [content["texts"][number] for number in (missed[1], *missed[3:])]
    assert said == ["ONTOP(a, b)", "got INSIDE(a, b)"]
    assert len(met) == 3


def test_script_text_is_json() -> None:
    assert json.loads(encode_for_script({"a": HOSTILE})) == {"a": HOSTILE}
