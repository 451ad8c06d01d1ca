"""Commands recognize an ability with several turns by its declaration, not by its name."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from agents.switches import SWITCHES
from by_path import TESTS
from eai.agents.declaration import ACTING
from eai.agents.play import EpisodeFactory, StoredEpisode, read_episode
from eai.agents.setting import AgentSetting
from eai.tasks.source import Source
from processes import eai

SUITE = ("--domain", "lamps:lamps", "--ability", "walking")


@pytest.fixture
def distribution(tmp_path: Path) -> dict[str, str]:
    """Return the environment variables of a process in which the second ability is installed."""
    info = tmp_path / "site" / "walking-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: walking\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[eai.abilities]\nwalking = agents.walking:WALKING\n")
    folders = (info.parent, TESTS, TESTS.parent / "examples" / "lamps")
    return {"PYTHONPATH": os.pathsep.join([*map(str, folders), os.environ.get("PYTHONPATH", "")])}


def test_another_ability_that_takes_turns_is_played_scored_and_reported(
    tmp_path: Path, distribution: dict[str, str]
) -> None:
    runs = tmp_path / "runs"
    run = eai(
        "run", "--model", "eai/explorer", *SUITE, "--with", "agent.view=task", "--out", runs, **distribution
    )
    assert run.status == 0, run.err
    (answers,) = (runs / "lamps" / "walking").rglob("*_outputs.json")
    episodes = [read_episode(answer["llm_output"]) for answer in json.loads(answers.read_text())]
    for episode in episodes:
        assert isinstance(episode, StoredEpisode)
        assert episode.rules is not None
        assert (episode.rules.view, bool(episode.turns)) == ("task", True)
    again = eai("score", answers, *SUITE, "--out", tmp_path / "again", "--json", **distribution)
    assert again.status == 0, again.err
    (record, *_) = map(json.loads, (tmp_path / "again" / "records.jsonl").read_text().splitlines())
    assert (record["ability"], record["success"]) == ("walking", True)
    report = eai("report", runs, "--out", tmp_path / "report", **distribution)
    assert report.status == 0, report.err
    assert "### Experiments: walking, lamps" in (tmp_path / "report" / "report.md").read_text()


def test_an_episode_names_its_harness_and_rules_and_an_empty_answer_names_none() -> None:
    play = EpisodeFactory(SWITCHES, AgentSetting(harness="text", budget=4)).begin_episode(
        SWITCHES.tasks(Source())["both"]
    )
    play.play_command("LOOK")
    made = ACTING.read_episode_settings(play.write_as_json_text("stopped"))
    assert made is not None
    assert (made.harness, made.rules) == ("text", "budget-4.0")
    assert ACTING.read_episode_settings("") is None
