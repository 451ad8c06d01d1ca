"""Read logs of Inspect whose samples act by the tools ``act``, ``look`` and ``done``, as tasks of `eai` do.

Replies of `eai` state the kind of an error. Replies of other tasks prove nothing, so a replay decides.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from eai.agents.tools import ACT, END, read_tool_call
from eai.base.errors import InputError, require_extra
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import Ending, EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.extensions.logs.readers import LogReader
from eai.extensions.logs.replay import replay_steps
from eai.tasks.source import Source
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.run.tasks import InspectLog, InspectSample

_ZIP_NAMES, _JSON_KEYS = (b"header.json", b"_journal/"), (b'"eval"', b'"samples"', b'"version"')
_FAILED = re.compile(r"(?:Failed|.*: failed) \(([^)]*)\)")
_DONE, _SLIPPED, _NOT_NEEDED = ": done.", ": nothing happened.", ": not needed: "
_ENDINGS = {"time": Ending.OUT_OF_TIME, "working": Ending.OUT_OF_TIME, "operator": Ending.STOPPED}
_VALUES = {"C": True, "I": False, True: True, False: False}


def _recognize(content: bytes) -> bool:
    if content.startswith(b"PK\x03\x04"):
        return any(name in content for name in _ZIP_NAMES)
    return content.lstrip()[:1] == b"{" and all(key in content for key in _JSON_KEYS)


def _read(path: Path, content: bytes) -> list[LoggedEpisode]:
    with require_extra("run", "logs of Inspect need"):
        from eai.run.tasks import read_inspect_log
    log = read_inspect_log(path)
    return [_read_sample(path, log, sample) for sample in log.samples or ()]


def _read_sample(path: Path, log: InspectLog, sample: InspectSample) -> LoggedEpisode:
    calls = [*_read_calls(sample)]
    steps = [_make_step(command, reply, failed) for name, command, reply, failed in calls if name == ACT]
    if all(step.action == ACT for step in steps):
        place = f"{path}, sample {sample.id}, epoch {sample.epoch}"
        raise InputError(f"{place}: expected calls of {ACT} with an action and objects, found none")
    ending = Ending.BY_AGENT if any(name == END for name, *_ in calls) else Ending.CANNOT_TELL
    if sample.limit is not None:
        ending = _ENDINGS.get(sample.limit.type, Ending.OUT_OF_STEPS)
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
        words=" ".join(sample.messages[-1].text.split()),
        unknown=("progress", *([] if told and known else ["kinds of errors"])),
    )


def _read_calls(sample: InspectSample) -> Iterator[tuple[str, str, str, bool]]:
    """Yield the name of each tool call, its command, its reply, and whether the tool failed.

    The command is empty if the arguments are invalid. Calls of other tools are left out.
    """
    replies = {message.tool_call_id: message for message in sample.messages if message.role == "tool"}
    for message in sample.messages:
        for call in (message.tool_calls or ()) if message.role == "assistant" else ():
            reply = replies.get(call.id)
            text = "" if reply is None else reply.text
            failed = reply is not None and reply.error is not None
            if call.function == END:
                yield END, "", text, failed
            elif call.function == ACT:
                command = ""
                with suppress(InputError):
                    command = read_tool_call(ACT, call.arguments) if call.parse_error is None else ""
                yield ACT, command, text, failed


def _make_step(command: str, reply: str, failed: bool) -> LoggedStep:
    line = reply.partition("\n")[0]
    if not command:
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
    values = [score.value for score in (sample.scores or {}).values()]
    if not values or sample.error is not None:
        return EpisodeOutcome.NOT_GRADED
    verdicts = {_read_value(value) for value in values}
    if len(verdicts) > 1 or None in verdicts:
        return EpisodeOutcome.CANNOT_TELL
    return EpisodeOutcome.WON if verdicts == {True} else EpisodeOutcome.GOAL_UNMET


def _read_value(value: object) -> bool | None:
    """Return whether the value of a score means success; None if it is neither success nor failure."""
    if isinstance(value, Mapping):
        value = value.get("success")
    return _VALUES.get(value) if isinstance(value, (str, bool, int, float)) else None


def _replay(episodes: Sequence[LoggedEpisode], benchmark: Benchmark, source: Source) -> list[LoggedEpisode]:
    """Replay episodes in the tasks that have the ids of their samples."""
    tasks = benchmark.tasks(source)
    return [
        replay_steps(
            episode,
            [step.action if step.kind is None else None for step in episode.steps],
            tasks[episode.task],
            benchmark,
        )
        if episode.task in tasks
        else episode
        for episode in episodes
    ]


INSPECT = LogReader("Inspect", _recognize, _read, _replay)
