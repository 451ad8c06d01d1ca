"""Read logs of Inspect whose agents call the tools ``act``, ``look`` (observe) and ``done``, as in `eai`.

Replies of the tools of `eai` state the kind of an error. Replies of other tools do not, so errors come
from a replay of the actions in the task of `eai` with the same id.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING

from eai.agents.tools import ACT, END, convert_tool_call_to_command
from eai.base.errors import InputError, require_extra
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.extensions.logs.readers import LogReader
from eai.extensions.logs.replay import replay_steps
from eai.tasks.task import Task
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.run.tasks import InspectLog, InspectSample

_ZIP_NAMES, _JSON_KEYS = (b"header.json", b"_journal/"), (b'"eval"', b'"samples"', b'"version"')
_FAILED = re.compile(r"(?:Failed|.*: failed) \(([^)]*)\)")
_DONE, _SLIPPED, _NOT_NEEDED = ": done.", ": nothing happened.", ": not needed: "
_ENDINGS = {
    "time": EpisodeEndReason.OUT_OF_TIME,
    "working": EpisodeEndReason.OUT_OF_TIME,
    "operator": EpisodeEndReason.STOPPED,
}
_VALUES = {"C": True, "I": False, True: True, False: False}


def _is_inspect_log(content: bytes) -> bool:
    if content.startswith(b"PK\x03\x04"):
        return any(name in content for name in _ZIP_NAMES)
    return content.lstrip()[:1] == b"{" and all(key in content for key in _JSON_KEYS)


def _read_episodes(path: Path, content: bytes) -> list[LoggedEpisode]:
    with require_extra("run", "logs of Inspect need"):
        from eai.run.tasks import read_inspect_log
    log = read_inspect_log(path)
    episodes = [_read_sample(log, sample) for sample in log.samples or ()]
    if all(step.action == ACT for episode in episodes for step in episode.steps):
        raise InputError(f"{path}: expected calls of {ACT} with an action and objects, found none")
    return episodes


def _read_sample(log: InspectLog, sample: InspectSample) -> LoggedEpisode:
    calls = [call for each in sample.messages if each.role == "assistant" for call in each.tool_calls or ()]
    replies = {m.tool_call_id: (m.text, m.error is not None) for m in sample.messages if m.role == "tool"}
    steps = [
        _make_step({} if call.parse_error else call.arguments, *replies.get(call.id, ("", False)))
        for call in calls
        if call.function == ACT
    ]
    ending = (
        EpisodeEndReason.BY_AGENT
        if any(call.function == END for call in calls)
        else EpisodeEndReason.CANNOT_TELL
    )
    if sample.limit is not None:
        ending = _ENDINGS.get(sample.limit.type, EpisodeEndReason.OUT_OF_STEPS)
    usage = [each.total_tokens for each in sample.model_usage.values()]
    told = all(step.kind is not None for step in steps if step.accepted is False)
    known = all(step.accepted is not None for step in steps)
    return LoggedEpisode(
        str(sample.id),
        _find_outcome(sample),
        ending,
        tuple(steps),
        agent=log.eval.model,
        setting=log.eval.task if sample.epoch == 1 else f"{log.eval.task}, epoch {sample.epoch}",
        seconds=sample.total_time,
        calls=sum(message.role == "assistant" for message in sample.messages),
        tokens=sum(usage) if usage else None,
        words=sample.messages[-1].text if sample.messages else "",
        unknown=(
            *("progress", *([] if steps else ["actions"])),
            *([] if told and known else ["kinds of errors"]),
        ),
    )


def _make_step(arguments: Mapping[str, object], reply: str, failed: bool) -> LoggedStep:
    line = reply.partition("\n")[0]
    try:
        command = convert_tool_call_to_command(ACT, arguments)
    except InputError:
        return LoggedStep(ACT, False, FaultKind.PARSING, line)
    if (match := _FAILED.match(line)) is not None:
        name = match[1].replace(" ", "_")
        kind = FaultKind(name) if name in [member.value for member in FaultKind] else None
        return LoggedStep(command, False, kind, line)
    if _NOT_NEEDED in line:
        return LoggedStep(command, False, FaultKind.ADDITIONAL_STEP, line)
    if line.endswith(_SLIPPED):
        return LoggedStep(command, False, FaultKind.SLIP, line)
    accepted = True if line.endswith(_DONE) else False if failed else None
    return LoggedStep(command, accepted, None, line)


def _find_outcome(sample: InspectSample) -> EpisodeOutcome:
    values = [score.value for score in (sample.scores or {}).values() if not _is_unscored(score.value)]
    if not values or sample.error is not None:
        return EpisodeOutcome.NOT_GRADED
    verdicts = {_read_score_value_as_success(value) for value in values}
    if len(verdicts) > 1 or None in verdicts:
        return EpisodeOutcome.CANNOT_TELL
    return EpisodeOutcome.WON if verdicts == {True} else EpisodeOutcome.GOAL_UNMET


def _is_unscored(score_value: object) -> bool:
    """Whether the value of a score is NaN. Inspect writes NaN if there is no score."""
    return isinstance(score_value, float) and isnan(score_value)


def _read_score_value_as_success(value: object) -> bool | None:
    """Return whether the value of a score means success; None if it is neither success nor failure."""
    if isinstance(value, Mapping):
        value = value.get("success")
    return _VALUES.get(value) if isinstance(value, (str, bool, int, float)) else None


def _replay_episode(episode: LoggedEpisode, tasks: Mapping[str, Task], benchmark: Benchmark) -> LoggedEpisode:
    """Replay a logged episode in the task whose id is the id of the log's sample."""
    if episode.task not in tasks or not episode.steps:
        return episode
    commands = [step.action if step.kind is None else None for step in episode.steps]
    return replay_steps(episode, commands, tasks[episode.task], benchmark)


INSPECT = LogReader("Inspect", _is_inspect_log, _read_episodes, _replay_episode)
