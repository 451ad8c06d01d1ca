"""The question of an episode explains how to give commands, and the harness reads them so."""

from __future__ import annotations

from typing import Any

import pytest

from agents.switches import DOMAIN, SWITCHES
from eai.abilities.verdict import Unreadable
from eai.agents.play import EpisodeFactory, read_episode
from eai.agents.setting import ACTING, AgentSetting
from eai.agents.tools import list_tool_names_texts_and_schemas
from eai.benchmarks.suite import open_suite

TASK = open_suite(SWITCHES, ACTING).tasks["both"]
BY_TEXT = "Write one command a message, on its last line: an action, LOOK or DONE."
BY_TOOLS = (
    "You act by calls of tools, one at a time: act takes an action, look stands for LOOK, done for DONE."
)


@pytest.mark.parametrize(
    ("harness", "how"), [("text", BY_TEXT), ("react", BY_TOOLS), ("my_agents:brief", BY_TOOLS)]
)
def test_the_question_ends_with_instructions_for_commands(harness: str, how: str) -> None:
    arena = EpisodeFactory(SWITCHES, AgentSetting(harness=harness))
    assert (
        arena.make_prompt(TASK).user
        == f"{arena.begin_episode(TASK).write_manual_and_first_observation()}\n\n{how}"
    )
    assert arena.make_prompt_with_pictures(TASK) == arena.make_prompt(TASK)


def test_a_short_question_has_the_rules_and_facts_alone_neither() -> None:
    questions = {
        name: EpisodeFactory(SWITCHES, AgentSetting(prompts=name)).make_prompt(TASK).user
        for name in ("eai", "short", "facts")
    }
    plain, short, facts = questions.values()
    assert len(facts) < len(short) < len(plain)
    assert [text.startswith("Goals:\n") for text in questions.values()] == [False, False, True]
    heads = [f"{operator.name}(" for operator in SWITCHES.domain.operators]
    assert all(head in short for head in heads)
    assert not any(head in facts for head in heads)


@pytest.mark.parametrize("feedback", ["facts", "changes"])
@pytest.mark.parametrize("command", [5, None, ["PRESS", "lamp"], {1: b"x"}])
def test_a_command_that_is_no_text_is_played_as_json(
    feedback: str, command: Any, caplog: pytest.LogCaptureFixture
) -> None:
    game = EpisodeFactory(SWITCHES, AgentSetting(feedback=feedback)).begin_episode(TASK)
    assert game.play_command(command).startswith("Failed (")
    assert game.act(command).observation.startswith("Failed (")
    assert not caplog.records
    assert not isinstance(read_episode(game.write_as_json_text("stopped")), Unreadable)


def test_the_tools_that_a_question_names_are_those_of_the_harness() -> None:
    names = [name for name, _, _ in list_tool_names_texts_and_schemas(DOMAIN)]
    assert names == ["act", "look", "done"]
    assert [name for name in names if f" {name} " in BY_TOOLS] == names
    assert not any(f" {name} " in BY_TEXT for name in names)
