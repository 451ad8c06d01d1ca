"""Hand-made logs in the form of EAI v2's published runs, with labels that were decided before the reader.

A further log is an entry of `LABELLED`: a name, the grader's reward, the exception, and the expected outcome
and ending. The labels follow the record alone. A reward without `deterministic` does not show whether the
replay reproduced the episode, so its outcome is "cannot tell".
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from eai.base.errors import InputError
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.readers import read_log

REPLAYED = {"deterministic": 1, "grader_error": 0, "n_actions": 800, "video_rendered": 1}
TIMEOUT = "AgentTimeoutError"

LABELLED = [
    ("won", {**REPLAYED, "success": 1}, None, EpisodeOutcome.WON, EpisodeEndReason.BY_AGENT),
    (
        "won at the last moment",
        {**REPLAYED, "success": 1},
        TIMEOUT,
        EpisodeOutcome.WON,
        EpisodeEndReason.OUT_OF_TIME,
    ),
    ("unmet", {**REPLAYED, "success": 0}, None, EpisodeOutcome.GOAL_UNMET, EpisodeEndReason.BY_AGENT),
    (
        "unmet, robot service",
        {**REPLAYED, "success": 0, "live_success": 0, "replay_success": 0},
        TIMEOUT,
        EpisodeOutcome.GOAL_UNMET,
        EpisodeEndReason.OUT_OF_TIME,
    ),
    (
        "unmet, without a live verdict",
        {**REPLAYED, "success": 0, "replay_success": 0},
        None,
        EpisodeOutcome.GOAL_UNMET,
        EpisodeEndReason.BY_AGENT,
    ),
    (
        "replay differs",
        {**REPLAYED, "success": 0, "deterministic": 0},
        TIMEOUT,
        EpisodeOutcome.NOT_REPRODUCED,
        EpisodeEndReason.OUT_OF_TIME,
    ),
    (
        "reached only live",
        {**REPLAYED, "success": 0, "live_success": 1, "replay_success": 0},
        None,
        EpisodeOutcome.NOT_REPRODUCED,
        EpisodeEndReason.BY_AGENT,
    ),
    (
        "no trajectory",
        {"grader_error": 0, "missing_trajectory": 1, "success": 0},
        TIMEOUT,
        EpisodeOutcome.NOTHING_SUBMITTED,
        EpisodeEndReason.OUT_OF_TIME,
    ),
    (
        "no action",
        {**REPLAYED, "success": 0, "deterministic": 0, "n_actions": 0},
        None,
        EpisodeOutcome.NOTHING_SUBMITTED,
        EpisodeEndReason.BY_AGENT,
    ),
    (
        "grader failed",
        {"grader_error": 1, "success": 0},
        None,
        EpisodeOutcome.NOT_GRADED,
        EpisodeEndReason.BY_AGENT,
    ),
    ("cancelled", None, "CancelledError", EpisodeOutcome.NOT_GRADED, EpisodeEndReason.STOPPED),
    ("crashed", None, "NonZeroAgentExitCodeError", EpisodeOutcome.NOT_GRADED, EpisodeEndReason.CANNOT_TELL),
    (
        "another benchmark's reward",
        {"success": 0, "n_actions": 12},
        None,
        EpisodeOutcome.CANNOT_TELL,
        EpisodeEndReason.BY_AGENT,
    ),
]


def state_of(reward: Mapping[str, int] | None) -> str:
    if reward is None or (not reward["success"] and reward.get("grader_error")):
        return "error"
    return "success" if reward["success"] else "failed"


def record(reward: Mapping[str, int] | None, exception: str | None, **changed: object) -> dict[str, Any]:
    return {
        "agent_wall_s": 1200,
        "calls": 7,
        "exception": exception,
        "progress": 0.25,
        "reward": reward,
        "state": state_of(reward),
        "tokens": {"cached": 10, "input": 100, "output": 20, "reasoning": 5},
        "trial": "t__1",
        **changed,
    }


def run(tasks: Mapping[str, Mapping[str, object]], **changed: object) -> dict[str, object]:
    return {
        "benchmark": "behavior-1k",
        "label": "A",
        "run": "agent-model-high",
        "tasks": tasks,
        "v": 1,
        **changed,
    }


def trial(reward: Mapping[str, int] | None, exception: str | None, **changed: object) -> dict[str, object]:
    kept = {"exception": exception, "reward": reward, "state": state_of(reward), "agent_wall_s": 1200.5}
    steps = [
        {"k": "say", "t": 1.0, "text": "I look for the apple."},
        {"k": "run", "t": 2.0, "cmd": "ls", "status": "ok"},
        {"k": "say", "t": 9.0, "text": "The gripper slips, and time is short."},
    ]
    totals = {"calls": 7, "failed": 0, "input": 100, "output": 20}
    head = {
        "v": 1,
        "benchmark": "behavior-1k",
        "run": "agent-model-high",
        "task": "boxing",
        "mode": "limited",
    }
    return {
        **head,
        "previous": False,
        **kept,
        "totals": totals,
        "calls": [],
        "steps": steps,
        "robot": [],
        **changed,
    }


def written(folder: Path, value: object, name: str = "log.json") -> Path:
    path = folder / name
    path.write_text(value if isinstance(value, str) else json.dumps(value))
    return path


@pytest.mark.parametrize(
    ("reward", "exception", "outcome", "ending"),
    [case[1:] for case in LABELLED],
    ids=[case[0] for case in LABELLED],
)
@pytest.mark.parametrize("form", ["run", "trial"])
def test_the_record_of_a_trial_decides_its_outcome_and_its_ending(
    tmp_path: Path,
    form: str,
    reward: Mapping[str, int] | None,
    exception: str | None,
    outcome: EpisodeOutcome,
    ending: EpisodeEndReason,
) -> None:
    value = (
        run({"boxing": {"limited": record(reward, exception)}}) if form == "run" else trial(reward, exception)
    )
    (episode,) = read_log(written(tmp_path, value))
    assert (episode.task, episode.setting, episode.agent) == ("boxing", "limited", "agent-model-high")
    assert (episode.outcome, episode.ending) == (outcome, ending)
    assert episode.index_of_first_error is None
    assert (episode.calls, episode.tokens) == (7, 120)


def test_a_run_has_an_episode_for_each_task_and_mode_in_the_order_of_the_file(tmp_path: Path) -> None:
    won, lost = record({**REPLAYED, "success": 1}, None), record(None, "CancelledError")
    log = read_log(written(tmp_path, run({"b": {"limited": lost, "unlimited": won}, "a": {"limited": won}})))
    assert [(e.task, e.setting) for e in log] == [
        ("b", "limited"),
        ("b", "unlimited"),
        ("a", "limited"),
    ]
    assert {episode.format for episode in log} == {"EAI v2"}


def test_a_trial_shows_the_agents_last_words_and_says_that_progress_is_unknown(tmp_path: Path) -> None:
    reward = {**REPLAYED, "success": 0}
    (episode,) = read_log(written(tmp_path, trial(reward, TIMEOUT, previous=True)))
    assert episode.words == "The gripper slips, and time is short."
    assert episode.setting == "limited, replaced"
    assert episode.best_goal_progress is None
    assert "progress" in episode.unknown


def test_a_simulator_error_ends_a_trial_from_outside(tmp_path: Path) -> None:
    reward = {**REPLAYED, "success": 0, "deterministic": 0}
    crash = {"reason": "error", "error": "RuntimeError('physics')"}
    (episode,) = read_log(written(tmp_path, trial(reward, None, ended=crash)))
    assert (episode.outcome, episode.ending) == (EpisodeOutcome.NOT_REPRODUCED, EpisodeEndReason.STOPPED)
    assert episode.words.endswith("time is short. Simulator error: RuntimeError('physics')")
    (episode,) = read_log(written(tmp_path, trial(reward, None, ended={"reason": "timeout"})))
    assert episode.ending is EpisodeEndReason.BY_AGENT


def test_progress_is_the_graders_except_that_nothing_submitted_has_none(tmp_path: Path) -> None:
    missing = {"grader_error": 0, "missing_trajectory": 1, "success": 0}
    modes = {
        "unlimited": record(missing, TIMEOUT, progress=0.0),
        "limited": record({**REPLAYED, "success": 0}, TIMEOUT, progress=0.5),
    }
    nothing, half = read_log(written(tmp_path, run({"boxing": modes})))
    assert nothing.progress is None
    assert half.progress == 0.5
    assert (half.best_goal_progress, half.step_of_best_goal_progress) == (0.5, None)


@pytest.mark.parametrize(
    ("changed", "place"),
    [
        ({"state": "running"}, "tasks.boxing.limited.state"),
        ({"state": "success"}, "tasks.boxing.limited: the state success does not fit the reward"),
        ({"progress": 7}, "tasks.boxing.limited.progress"),
        ({"reward": {"success": 2}}, "tasks.boxing.limited.reward.success"),
        ({"tokens": "many"}, "tasks.boxing.limited.tokens"),
    ],
)
def test_a_damaged_run_is_refused_with_the_place(
    tmp_path: Path, changed: dict[str, object], place: str
) -> None:
    good = record({**REPLAYED, "success": 0}, None)
    path = written(tmp_path, run({"apple": {"limited": good}, "boxing": {"limited": {**good, **changed}}}))
    with pytest.raises(InputError, match=r"log\.json") as caught:
        read_log(path)
    assert place in str(caught.value)


@pytest.mark.parametrize("value", [run({}), run({"boxing": {}}), run({}, v=2), trial(None, None, mode=3)])
def test_a_log_without_trials_or_of_another_version_is_refused(tmp_path: Path, value: object) -> None:
    with pytest.raises(InputError, match=r"log\.json"):
        read_log(written(tmp_path, value))


def test_a_file_that_ends_too_early_is_refused_with_line_and_column(tmp_path: Path) -> None:
    text = json.dumps(run({"boxing": {"limited": record(None, None)}}))[:-30]
    with pytest.raises(InputError, match=r"log\.json, line 1, column \d+: expected JSON"):
        read_log(written(tmp_path, text))


@pytest.mark.parametrize("text", ["", "{}", "[1, 2]", "hello", '{"benchmark": "behavior-1k"}', "\x00\x01"])
def test_a_foreign_file_is_refused_and_the_message_lists_the_known_forms(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match=r"unknown log format; expected one of.*EAI v2"):
        read_log(written(tmp_path, text))


def test_no_episode_of_this_form_has_steps(tmp_path: Path) -> None:
    """Low-level control is not diagnosed: no error of a step is read from it."""
    (episode,) = read_log(written(tmp_path, trial({**REPLAYED, "success": 0}, TIMEOUT)))
    assert isinstance(episode, LoggedEpisode)
    assert episode.steps == ()
    assert episode.actions == 800
    assert "errors of steps" in episode.unknown
