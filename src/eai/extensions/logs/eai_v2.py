"""Read runs that the second version of EAI publishes: a run's records, or the log of one trial.

A run is a file ``data/published_runs/BENCHMARK/RUN.json`` of the project's site, and a trial is a file
``RUN/TASK/MODE.json`` beside it. A trial is judged by the grader's record alone. The robot's control is not
diagnosed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from eai.base.errors import InputError
from eai.base.files import parse_json
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.readers import Count, LogReader, Share, validate

_KEYS = (rb'"benchmark"\s*:', rb'"run"\s*:', rb'"(?:tasks"\s*:\s*\{|mode"\s*:)')
"""Regular expressions for JSON keys that a file of EAI v2 has and other JSON files lack."""

_ENDINGS = {
    None: EpisodeEndReason.BY_AGENT,
    "AgentTimeoutError": EpisodeEndReason.OUT_OF_TIME,
    "CancelledError": EpisodeEndReason.STOPPED,
}

_BEHAVIOR = "behavior-1k"
"""Name of the only benchmark whose logs state progress: the share of goal conditions that hold at the end."""

_Flag = Annotated[int, Field(ge=0, le=1)]


class _GraderReward(BaseModel):
    success: _Flag | None = None
    deterministic: _Flag | None = None
    live_success: _Flag | None = None
    replay_success: _Flag | None = None
    missing_trajectory: _Flag = 0
    missing_log: _Flag = 0
    grader_error: _Flag = 0
    n_actions: Count | None = None


class _TokenAndCallCounts(BaseModel):
    input: Count | None = None
    output: Count | None = None
    calls: Count | None = None


class _TrialOutcome(BaseModel):
    state: Literal["success", "failed", "error"]
    exception: str | None
    reward: _GraderReward | None
    agent_wall_s: Annotated[float, Field(ge=0)] | None = None
    progress: Share | None = None


class _TrialRecord(_TrialOutcome):
    calls: Count | None = None
    tokens: _TokenAndCallCounts | None = None


class _PublishedRun(BaseModel):
    v: Literal[1]
    benchmark: str
    run: str
    tasks: Mapping[str, Mapping[str, _TrialRecord]]


class _TrialLogStep(BaseModel):
    k: str
    text: str = ""


class _TrialLog(_TrialOutcome):
    v: Literal[1]
    benchmark: str
    run: str
    task: str
    mode: str
    previous: bool = False
    totals: _TokenAndCallCounts
    steps: tuple[_TrialLogStep, ...]
    ended: Mapping[str, Any] = {}


def _is_eai_v2_file(content: bytes) -> bool:
    return content.lstrip()[:1] == b"{" and all(re.search(key, content) for key in _KEYS)


def _read_episodes(path: Path, content: bytes) -> list[LoggedEpisode]:
    value = parse_json(path, content)
    if not isinstance(value, dict) or "tasks" not in value:
        return [_read_trial(path, validate(_TrialLog, str(path), value))]
    run, episodes = validate(_PublishedRun, str(path), value), list[LoggedEpisode]()
    for task, modes in run.tasks.items():
        for mode, record in modes.items():
            totals = (record.tokens or _TokenAndCallCounts()).model_copy(update={"calls": record.calls})
            place = f"{path}: tasks.{task}.{mode}"
            episodes.append(_make_episode(place, record, totals, run, task, mode))
    return episodes


def _read_trial(path: Path, log: _TrialLog) -> LoggedEpisode:
    setting = f"{log.mode}, replaced" if log.previous else log.mode
    words = next((step.text for step in reversed(log.steps) if step.k == "say"), "")
    episode = _make_episode(str(path), log, log.totals, log, log.task, setting)
    if error := log.ended.get("error"):
        episode = replace(episode, ending=EpisodeEndReason.STOPPED)
        words = f"{words} Simulator error: {error}"
    return replace(episode, words=words or episode.words)


def _make_episode(
    place: str,
    trial: _TrialOutcome,
    totals: _TokenAndCallCounts,
    run: _PublishedRun | _TrialLog,
    task: str,
    setting: str,
) -> LoggedEpisode:
    outcome = _find_outcome(trial.reward)
    expected = {EpisodeOutcome.WON: "success", EpisodeOutcome.NOT_GRADED: "error"}.get(outcome, "failed")
    if trial.state != expected:
        raise InputError(
            f"{place}: the state {trial.state} does not fit the reward; expected the state {expected}"
        )
    ending = _ENDINGS.get(trial.exception, EpisodeEndReason.CANNOT_TELL)
    if trial.exception is None and trial.reward is None:
        ending = EpisodeEndReason.CANNOT_TELL
    progress = trial.progress
    if outcome is EpisodeOutcome.WON:
        progress = 1.0
    elif run.benchmark != _BEHAVIOR or outcome is EpisodeOutcome.NOTHING_SUBMITTED:
        progress = None  # only BEHAVIOR reports a share of goals, which is 0 if nothing was submitted
    counts = [count for count in (totals.input, totals.output) if count is not None]
    return LoggedEpisode(
        agent=run.run,
        task=task,
        setting=setting,
        outcome=outcome,
        ending=ending,
        actions=None if trial.reward is None else trial.reward.n_actions,
        progress=progress,
        seconds=trial.agent_wall_s,
        calls=totals.calls,
        tokens=sum(counts) if counts else None,
        words=trial.exception or "",
        unknown=("errors of steps", *(["progress"] if progress is None else [])),
    )


def _find_outcome(reward: _GraderReward | None) -> EpisodeOutcome:
    if reward is not None and reward.success:
        return EpisodeOutcome.WON
    if reward is None or reward.success is None or reward.grader_error or reward.missing_log:
        return EpisodeOutcome.NOT_GRADED
    if reward.missing_trajectory or reward.n_actions == 0:
        return EpisodeOutcome.NOTHING_SUBMITTED
    if reward.deterministic == 0 or {reward.live_success, reward.replay_success} == {0, 1}:
        return EpisodeOutcome.NOT_REPRODUCED
    return EpisodeOutcome.CANNOT_TELL if reward.deterministic is None else EpisodeOutcome.GOAL_UNMET


EAI_V2 = LogReader("EAI v2", _is_eai_v2_file, _read_episodes)
