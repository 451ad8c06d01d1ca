from __future__ import annotations

import base64
import hashlib
import json
import re
import tracemalloc
from dataclasses import replace
from pathlib import Path

import pytest

from eai.abilities.explanation import GoalReport, StepReport, VerdictExplanation, parse_statement
from eai.agents.setting import ACTING
from eai.agents.verdict import EpisodeTurn, EpisodeVerdict
from eai.results.page import encode_for_script
from eai.results.runs import Run, RunKey, read_runs
from eai.studies.report.explorer import DomainDataOfExplorerPage, ExplorerPageData, build_explorer_page
from explorer_pages import read_chunks, read_explorer
from results.verdicts import record
from studies.report.samples import HOSTILE, action_run, all_runs, write_runs

BACKGROUND = DomainDataOfExplorerPage(
    prompts={"action_sequencing": {"0_1": f"Do this.\n{HOSTILE}", "none": "?"}},
    operators={"open": "(:action open :parameters (?o))"},
)


@pytest.fixture
def data(tmp_path: Path) -> ExplorerPageData:
    packed = ExplorerPageData(
        lambda domain: BACKGROUND if domain == "virtualhome" else DomainDataOfExplorerPage()
    )
    for run in read_runs([write_runs(tmp_path, all_runs())]):
        packed.add_run(run)
    return packed


@pytest.fixture
def page(data: ExplorerPageData) -> str:
    return "".join(build_explorer_page(data.format_data_as_base64_lines()))


def test_no_text_in_the_data_can_end_the_script_element(page: str) -> None:
    lines = page.partition('id="data">')[2].partition("</script>")[0]
    assert re.fullmatch("[A-Za-z0-9+/=\n]+", lines)
    assert page.count("</script>") == 2
    assert "owned" not in page


def test_the_page_allows_only_its_own_style_and_program(page: str) -> None:
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy is not None
    assert "default-src 'none'" in policy[1]
    assert "unsafe" not in policy[1]
    for tag, rule in (("style", "style-src"), ("script", "script-src")):
        (text,) = re.findall(f"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{rule} 'sha256-{digest}'" in policy[1]
    assert not re.search(r"(?:src|href)=|https?://|url\(", page)


def test_each_answer_is_present_and_the_index_has_no_details(page: str) -> None:
    content = read_explorer(page)
    answers = [answer for run in content["runs"] for answer in run["answers"]]
    assert len(answers) == 12 * 3 + 4 + 5 + 3
    first = content["runs"][0]
    assert (first["protocol"], first["ability"]) == ("strict", "goal_interpretation")
    assert HOSTILE in [answer["r"] for answer in answers]
    assert "owned" not in json.dumps(read_chunks(page)[-1]["chunks"])


def test_the_data_are_the_same_each_time_they_are_asked_for(data: ExplorerPageData) -> None:
    assert [*data.format_data_as_base64_lines()] == [*data.format_data_as_base64_lines()]


def test_runs_that_share_a_chunk_keep_the_order_of_their_answers(tmp_path: Path) -> None:
    """The runs have different numbers of answers, and more runs than a chunk holds."""
    sizes = {"a": 5, "b": 12, "c": 1, "d": 7, "e": 3}
    runs = [action_run(name)[:size] for name, size in sizes.items()]
    data = ExplorerPageData()
    for run in read_runs([write_runs(tmp_path, [*runs, *all_runs()[3:]])]):
        data.add_run(run)
    content = read_explorer("".join(build_explorer_page(data.format_data_as_base64_lines())))
    named = {run["model"]: run["answers"] for run in content["runs"] if run["model"] in sizes}
    for records in runs:
        answers = named[records[0].model]
        assert [answer["t"] for answer in answers] == [record.task_id for record in records]
        assert [answer["r"] for answer in answers] == [record.response for record in records]
    assert all(len(set(chunk["run"])) <= 4 for chunk in content["chunks"])


def test_memory_grows_by_little_with_the_number_of_runs(tmp_path: Path) -> None:
    (run,) = read_runs([write_runs(tmp_path, [action_run()])])
    data = ExplorerPageData()
    memory = []
    tracemalloc.start()
    for number in range(60):
        answers = tuple(replace(record, response=f"{number} " * 10_000) for record in run.records)
        data.add_run(replace(run, key=run.key._replace(model=str(number)), records=answers))
        if number % 20 == 19:
            memory.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert memory[2] - memory[1] < 20 * 10_000


def test_only_prompts_of_answered_tasks_are_stored(page: str) -> None:
    prompts = read_explorer(page)["prompts"]
    assert prompts == {"virtualhome/action_sequencing": {"0_1": f"Do this.\n{HOSTILE}"}}


def test_a_missed_goal_shows_the_facts_that_hold_instead(tmp_path: Path) -> None:
    steps = (StepReport("PUT(a, b)", "executed", added=("INSIDE(a, b)",), call=parse_statement("PUT(a, b)")),)
    goals = (GoalReport("relation", "ONTOP(a, b)", False), GoalReport("state", "ON(a)", True))
    answer = replace(action_run()[0], explanation=VerdictExplanation(steps=steps, goals=goals))
    packed = ExplorerPageData()
    for run in read_runs([write_runs(tmp_path, [[answer]])]):
        packed.add_run(run)
    content = read_explorer("".join(build_explorer_page(packed.format_data_as_base64_lines())))
    (row,) = content["runs"][0]["answers"]
    missed, met = row["G"]
    assert [missed[1], *missed[3:]] == ["ONTOP(a, b)", "got INSIDE(a, b)"]
    assert len(met) == 3


def test_script_text_is_json() -> None:
    assert json.loads(encode_for_script({"a": HOSTILE})) == {"a": HOSTILE}


def test_thoughts_of_an_episode_are_shown_up_to_its_last_replayed_turn() -> None:
    """A record has fewer turns than the answer if the replay stopped early."""
    response = json.dumps({"turns": [{"said": "look", "thought": "hm"}, {"said": "DONE"}]})
    turn = EpisodeTurn("look", "0" * 64, False, None, False, "0", None)
    verdict = EpisodeVerdict(turns=(turn,))
    episode = record("t", verdict, ability=ACTING, response=response)
    data = ExplorerPageData()
    data.add_run(Run(RunKey(episode.protocol, episode.domain, ACTING, "m"), (episode,)))
    content = read_explorer("".join(build_explorer_page(data.format_data_as_base64_lines())))
    assert content["runs"][0]["answers"][0]["T"] == [["0", "hm"]]
