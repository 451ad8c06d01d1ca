"""Logs of other projects in `eai score` and `eai explain`, and in the explorer."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from browsing import needs_browser, open_explorer
from command_line import Command
from eai.base import entry_points
from eai.extensions.logs.episode import (
    CANNOT_TELL,
    EpisodeEndReason,
    EpisodeOutcome,
    LoggedEpisode,
    LoggedStep,
)
from eai.extensions.logs.explorer import describe_episode, make_explorer_page
from eai.extensions.logs.study import _COLORS
from eai.world.fault import FaultKind
from extensions.logs.test_alfworld_runs import AT_FRIDGE, NAME, NO, OPEN, PLAN, PUT, as_react
from extensions.logs.test_study import written

HOSTILE = "</script><b>bold</b>"
STEPS = (
    LoggedStep("open box", True, None, "The box is open.", 0.0),
    LoggedStep("shake box", None, None, "The box rattles.", 0.0),
    LoggedStep("take cup", False, None, HOSTILE, 0.5),
    LoggedStep("take lid", False, FaultKind.MISSING_STEP, "You are far away.", 0.5),
)
LOST = LoggedEpisode(
    *("lost", EpisodeOutcome.GOAL_UNMET, EpisodeEndReason.BY_AGENT, STEPS, "a", "hard"),
    unknown=("seconds",),
    words=HOSTILE,
    format="made",
)
WON = LoggedEpisode("won", EpisodeOutcome.WON, EpisodeEndReason.GOAL, STEPS[:1], format="made")
GRADERS = "nothing scored: outcomes are verdicts of the grader in each log"


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of EAI v2 with a lost and a won episode."""
    return written(tmp_path, "run.json", sweep=0, sweep_twice=1)


@pytest.fixture
def trajectories(tmp_path: Path) -> Path:
    """Return a log of ALFWorld with a rejected action in its first episode, and a won second episode."""
    turns = [AT_FRIDGE, ("take apple 2 from fridge 1", NO), OPEN]
    path = tmp_path / "react.txt"
    lost, won = "1 r 0 rs [0] cnts [1] sum(rs)/sum(cnts) 0.0", "2 r 1 rs [0] cnts [1] sum(rs)/sum(cnts) 0.5"
    path.write_text(as_react(turns, lost) + as_react([*PLAN, PUT], won, name="cool-Egg/trial_2"))
    return path


def test_scoring_a_log_shows_what_its_grader_said_and_writes_nothing(eai: Command, log: Path) -> None:
    printed = eai("score", log)
    assert printed.status == 0, printed.err
    assert f"{log}: EAI v2, 2 episodes; not in the log: errors of steps (2)" in printed.out
    assert GRADERS in printed.out
    assert [path.name for path in log.parent.iterdir()] == ["run.json"]
    (value,) = json.loads(eai("score", log, "--json").out)
    assert value["outcomes"] == {"goal unmet": 1, "won": 1}


def test_scoring_a_log_into_a_folder_writes_tables_and_an_explorer_but_no_records(
    eai: Command, log: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert f"written to {out}; open {out / 'explorer.html'}" in eai("score", log, "--out", out).out
    assert {path.name for path in out.iterdir()} >= {"episodes.csv", "outcomes.csv", "explorer.html"}
    assert not [path for path in out.rglob("*") if path.name in ("records.jsonl", "summary.json")]
    assert "expected a folder with records.jsonl" in eai("report", out).err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--protocol", "strict"], "--protocol: {log} is a log with its own score"),
        (["--no-explanations"], "--explanations: {log} is a log with its own score"),
        (["{folder}"], "{folder}: expected a folder with <model>_outputs.json files, found none"),
        (["{other}"], "{log}: give --domain and --ability"),
        (["--domain", "virtualhome"], "{log}: give --domain and --ability"),
    ],
)
def test_scoring_a_log_refuses_what_is_about_answers(
    eai: Command, log: Path, tmp_path: Path, arguments: list[str], message: str
) -> None:
    folder, other = tmp_path / "empty", tmp_path / "m_outputs.json"
    folder.mkdir()
    other.write_text("[]")
    names = {"log": log, "folder": folder, "other": other}
    refused = eai("score", log, *[argument.format(**names) for argument in arguments])
    assert (refused.status, refused.out) == (2, "")
    assert refused.err.startswith(f"eai: {message.format(**names)}")


@pytest.mark.parametrize("command", ["score", "explain"])
def test_a_damaged_log_is_refused_with_the_place(eai: Command, log: Path, command: str) -> None:
    log.write_bytes(log.read_bytes()[:-9])
    refused = eai(command, log)
    assert (refused.status, refused.out) == (2, "")
    assert refused.err.startswith(f"eai: {log}, line 1, column ")


@pytest.mark.parametrize(
    ("command", "message"),
    [("score", "give --domain and --ability"), ("explain", "expected a record of a scored answer")],
)
def test_without_a_reader_the_file_is_refused_as_no_file_of_ours(
    eai: Command, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, message: str
) -> None:
    foreign = tmp_path / "foreign.json"
    foreign.write_text("{}")
    assert message in eai(command, foreign).err
    read = entry_points._read_entry_points_of_group
    monkeypatch.setattr(
        *(entry_points, "_read_entry_points_of_group"),
        lambda group: {} if group == "eai.offers" else read(group),
    )
    assert message in eai(command, log).err


def test_our_own_log_of_inspect_is_no_log_of_another_project(eai: Command, tmp_path: Path) -> None:
    inspect_logs = pytest.importorskip("extensions.logs.test_inspect_logs", reason="needs the extra run")
    from inspect_ai.log import read_eval_log, write_eval_log

    path = inspect_logs.write(tmp_path, inspect_logs.sample([inspect_logs.OPENED], 1))
    assert GRADERS in eai("score", path).out
    own = read_eval_log(str(path))
    own.eval.metadata = {"domain": "virtualhome", "ability": "acting"}
    write_eval_log(own, str(path))
    assert eai("score", path).err.startswith(f"eai: {path}: give --domain and --ability")


def test_explaining_a_log_lists_its_episodes_and_says_what_it_took(eai: Command, trajectories: Path) -> None:
    printed = eai("explain", trajectories).out.splitlines()
    assert [" ".join(line.split()) for line in printed] == [
        NAME,
        "goal unmet; first error: action 2, cannot tell which kind",
        "cool-Egg/trial_2",
        "won; first error: none",
        "2 episodes",
        f"{trajectories}: ALFWorld, 2 episodes; not in the log: kinds of errors (2), progress (2)",
    ]
    assert "2 episodes, of which 1 are shown" in eai("explain", trajectories, "--limit", 1).out


def test_explaining_an_episode_shows_each_action_and_what_cannot_be_told(
    eai: Command, trajectories: Path
) -> None:
    printed = [line.strip() for line in eai("explain", trajectories, "cool-Apple").out.splitlines()]
    assert printed[:2] == [NAME, "ALFWorld log, agent not named"]
    assert printed[4:6] == ["2 ✗ take apple 2 from fridge 1", f"cannot tell which kind: {NO}"]
    assert printed[8:] == [
        "first error: action 2, cannot tell which kind",
        "goal conditions met: cannot tell",
        "end: cannot tell",
        "not in the log: kinds of errors, progress",
        f"last message: {OPEN[1]}",
        "outcome: goal unmet, by the log's own grader",
        f"{trajectories}: ALFWorld, 2 episodes; not in the log: kinds of errors (2), progress (2)",
    ]


def test_episodes_are_chosen_by_task_outcome_agent_and_kind(eai: Command, log: Path) -> None:
    def explain(*arguments: object) -> list[str]:
        return [episode["task"] for episode in json.loads(eai("explain", log, *arguments, "--json").out)]

    assert explain() == ["sweep", "sweep_twice"]
    assert explain("sweep") == ["sweep"]
    assert explain("sweep_") == ["sweep_twice"]
    assert explain("--failed") == ["sweep"]
    assert explain("--model", "agent") == ["sweep", "sweep_twice"]
    assert explain("--model", "other") == []
    assert explain("--kind", "missing_step") == []
    assert "no such episode" in eai("explain", log, "--kind", "missing_step").out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sweeep"], "no episode of task sweeep; did you mean sweep?"),
        (["--film", "film.gif"], "--film: expected records of eai, found a log"),
    ],
)
def test_explaining_a_log_refuses_a_wrong_request(
    eai: Command, log: Path, arguments: list[str], message: str
) -> None:
    refused = eai("explain", log, *arguments)
    assert (refused.status, refused.out) == (2, "")
    assert message in refused.err


@pytest.mark.parametrize(
    ("episode", "lines"),
    [
        (
            LOST,
            [
                "first error: action 3, cannot tell which kind",
                "goal conditions met: at best 50 % after action 3, at the end cannot tell",
                "end: by the agent",
                "not in the log: seconds",
                f"last message: {HOSTILE}",
            ],
        ),
        (replace(WON, progress=0.999), ["first error: none", "goal conditions met: at best 99.9 %, at the "]),
        (replace(LOST, steps=STEPS[3:]), ["first error: action 1, missing_step"]),
        (replace(LOST, steps=STEPS[:2]), [f"first error: {CANNOT_TELL}"]),
        (replace(LOST, steps=()), [f"first error: {CANNOT_TELL}", f"goal conditions met: {CANNOT_TELL}"]),
    ],
)
def test_what_is_not_known_of_an_episode_is_said(episode: LoggedEpisode, lines: list[str]) -> None:
    described = list(describe_episode(episode))
    assert [text[: len(line)] for text, line in zip(described, lines, strict=False)] == lines


@needs_browser
def test_the_explorer_shows_episodes_without_a_rate_and_marks_what_is_not_known(
    page: Any, tmp_path: Path
) -> None:
    explorer = tmp_path / "explorer.html"
    explorer.write_text(make_explorer_page([LOST, WON], _COLORS), encoding="utf-8")
    open_explorer(page, explorer.as_uri())
    assert page.locator(".tally").inner_text() == "2 answers · outcomes in logs of other projects"
    page.get_by_role("option", name="lost").click()
    assert "Made · acting · a · protocol made's own, hard" in page.locator(".heading").inner_text()
    assert page.locator(".verdict-box p").all_inner_texts() == [
        "Goal unmet",
        f"Cannot tell which kind at step 3: {HOSTILE}",
        "goal conditions met: at best 50 % after action 3, at the end cannot tell",
        *("end: by the agent", "not in the log: seconds", f"last message: {HOSTILE}"),
    ]
    assert page.locator(".step .mark").all_inner_texts() == ["✓", "?", "✗", "✗"]
    assert page.locator(".step .verdict").all_inner_texts() == [
        *("cannot tell", "cannot tell which kind", "missing step"),
    ]
    assert page.locator(".step .earlier").all_inner_texts() == [
        "0 % of the goal's conditions hold",
        "50 % of the goal's conditions hold",
    ]
    color = "getComputedStyle(document.querySelector('.stack .of-won')).getPropertyValue('--c')"
    assert page.evaluate(color).strip() == _COLORS[EpisodeOutcome.WON]
    page.get_by_role("option", name="won").click()
    assert "agent not named" in page.locator(".heading").inner_text()
