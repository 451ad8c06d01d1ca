"""Read episodes in ALFWorld: lines of ReAct and Reflexion, and JSON of AgentBench.

ReAct prints ``Act 1: ...`` and ``Obs 1: ...``. Reflexion writes ``> ...`` and the reply, after a prompt with
examples. AgentBench writes an episode as JSON in each line. The game replies "Nothing happens." to every
impossible command, so only a replay in the user's game proves the kind of an error.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from pydantic import BaseModel

from eai.abilities.verdict import ErrorReport
from eai.agents.command import CommandNotation
from eai.base.errors import InputError
from eai.base.files import decode_text, number_lines, parse_json
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.extensions.logs.readers import LogReader, validate
from eai.extensions.logs.replay import replay_steps
from eai.logic.traversal import find_object_names
from eai.tasks.task import Task
from eai.world.fault import FaultKind

_ROOM, _TASK, _PROMPT = "You are in the middle of a room", "Your task is to: ", "Interact with a household"
_NAME = re.compile(r"(Environment #\d+):(?: Success)?|\S+/trial_\S+")
_VERDICT = re.compile(r"(?:STATUS:|\d+ r|Result: Task) (\S+).*")
_WON, _PARAMETERS_START = ("OK", "True", "1", "Success!"), ("FAIL", "False", "0")
_RULE = re.compile(r"#{5,}|-{5,}|-= Welcome.*")
_ACT = re.compile(r"(?:Act (\d+):|>) ?(.*)")
_REPLY = re.compile(r"Obs (\d+): ?(.*)")
_THOUGHT = re.compile(r"think\s*:", re.IGNORECASE)
_REJECTED = re.compile(r"nothing happen(?:s|ed)\b", re.IGNORECASE)
_PUT = re.compile(r"put (.+) in/on (.+)|move (.+) to (.+)", re.IGNORECASE)
_WITHOUT_EFFECT = ("inventory", "help", "look")

_MAX_TURNS = 49
"""Maximum number of turns, thoughts included, in the programs of ReAct and Reflexion."""


_ENDINGS = {
    "agent context limit": EpisodeEndReason.STOPPED,
    "agent invalid action": EpisodeEndReason.TOO_MANY_ERRORS,
    "task limit reached": EpisodeEndReason.OUT_OF_STEPS,
}
_NOT_GRADED = ("agent validation failed", "cancelled", "unknown", "task error")
"""Statuses of AgentBench without a verdict."""


class _AgentBenchTurn(BaseModel):
    round: int
    output: str
    action: str
    observation: str


class _AgentBenchResult(BaseModel):
    log: tuple[_AgentBenchTurn, ...] = ()
    init_prompt: str = ""
    result: bool


class _AgentBenchOutput(BaseModel):
    status: str
    result: _AgentBenchResult


class _AgentBenchEpisode(BaseModel):
    index: int | str
    output: _AgentBenchOutput


def _is_alfworld_log(content: bytes) -> bool:
    if content.lstrip()[:1] == b"{":
        return re.match(rb'\s*\{\s*"index"\s*:', content) is not None and b'"output"' in content
    return _ROOM.encode() in content and re.search(rb"^(?:> |Act \d+: )", content, re.MULTILINE) is not None


def _read_episodes(path: Path, content: bytes) -> list[LoggedEpisode]:
    if content.lstrip()[:1] == b"{":
        return [_read_agentbench_episode(path, number, line) for number, line in number_lines(content)]
    return [
        _read_episode_text(path, episode) for episode in _find_episode_texts(path, decode_text(path, content))
    ]


def _read_agentbench_episode(path: Path, number: int, line: bytes) -> LoggedEpisode:
    place = f"{path}, line {number}"
    episode = validate(_AgentBenchEpisode, place, parse_json(path, line, number))
    status, result = episode.output.status, episode.output.result
    if status not in (statuses := (*_ENDINGS, *_NOT_GRADED, "completed")):
        raise InputError(f"{place}: output.status: expected one of {', '.join(statuses)}; found {status!r}")
    if status == "completed" and not result.log:
        raise InputError(f"{place}: output.result.log: expected turns, because output.status is completed")
    for expected, turn in enumerate(result.log, 1):
        if turn.round != expected:
            raise InputError(f"{place}: expected round {expected} in output.result.log, found {turn.round}")
    steps = [_make_step(turn.action, turn.observation) for turn in result.log]
    opening = result.init_prompt.partition("AVAILABLE ACTIONS")[0]
    outcome = EpisodeOutcome.WON if result.result else EpisodeOutcome.GOAL_UNMET
    outcome = EpisodeOutcome.NOT_GRADED if status in _NOT_GRADED else outcome
    ending = EpisodeEndReason.GOAL if result.result else _ENDINGS.get(status, EpisodeEndReason.CANNOT_TELL)
    if ending is EpisodeEndReason.TOO_MANY_ERRORS and _ends_with_equal_replies(result.log):
        ending = EpisodeEndReason.STOPPED
    elif ending is EpisodeEndReason.TOO_MANY_ERRORS:  # the log leaves out a reply without an action
        steps.append(LoggedStep("", False, FaultKind.PARSING))
    return _make_episode(str(episode.index), opening, steps, outcome, ending)


def _ends_with_equal_replies(turns: Sequence[_AgentBenchTurn]) -> bool:
    """Whether AgentBench ended an episode because the last three of at least four replies are equal."""
    return len(turns) > 3 and len({turn.output for turn in turns[-3:]}) == 1


def _make_step(action: str, reply: str) -> LoggedStep:
    return LoggedStep(action.strip(), _REJECTED.match(reply.strip()) is None, None, reply.strip())


def _make_episode(
    name: str, opening: str, steps: Sequence[LoggedStep], outcome: EpisodeOutcome, ending: EpisodeEndReason
) -> LoggedEpisode:
    if outcome is EpisodeOutcome.GOAL_UNMET and not steps:
        outcome = EpisodeOutcome.NOTHING_SUBMITTED
    unknown = ("kinds of errors", "progress", *(["verdict"] if outcome is EpisodeOutcome.CANNOT_TELL else []))
    return LoggedEpisode(name, outcome, ending, tuple(steps), opening=opening, unknown=unknown)


class _EpisodeText(NamedTuple):
    """The name and the numbered lines of one episode in a text log, and the word of its verdict, if any."""

    name: str
    lines: tuple[tuple[int, str], ...]
    verdict: str = ""


def _find_episode_texts(path: Path, text: str) -> Iterator[_EpisodeText]:
    """Yield the parts of a text log that are episodes, without prompts and examples."""
    name, prompt, lines = "", 0, list[tuple[int, str]]()
    for number, line in enumerate(map(str.strip, text.splitlines()), 1):
        named, judged = _NAME.fullmatch(line), _VERDICT.fullmatch(line)
        starts = line.startswith(_ROOM) and not (lines and lines[-1][1].startswith(">"))
        if prompt:
            prompt = 0 if line.startswith("Here is the task") else prompt
        elif named or judged or starts or line.startswith(_PROMPT) or _RULE.fullmatch(line):
            if lines:
                yield _EpisodeText(name, tuple(lines), judged[1] if judged else "")
            name = (named[1] or line) if named else "" if lines else name
            prompt = number if line.startswith(_PROMPT) else 0
            lines = [(number, line)] if starts else []
        elif lines and line:
            lines.append((number, line))
    if prompt:
        raise InputError(f"{path}, line {prompt}: expected a line 'Here is the task' after this prompt")
    if lines:
        yield _EpisodeText(name, tuple(lines))


def _read_episode_text(path: Path, episode: _EpisodeText) -> LoggedEpisode:
    first = next((i for i, (_, line) in enumerate(episode.lines) if _ACT.fullmatch(line)), len(episode.lines))
    opening = "\n".join([line for _, line in episode.lines[:first]])
    if _TASK not in opening:
        raise InputError(
            f"{path}, line {episode.lines[0][0]}: expected '{_TASK.strip()}' before the first action"
        )
    name = episode.name or " ".join(opening.partition(_TASK)[2].split()).rstrip(".")
    turns = _read_turns(path, episode.lines[first:])
    steps = [_make_step(action, reply) for action, reply in turns if not _THOUGHT.match(action)]
    outcome, ending = EpisodeOutcome.CANNOT_TELL, EpisodeEndReason.CANNOT_TELL
    if episode.verdict in _WON:
        outcome, ending = EpisodeOutcome.WON, EpisodeEndReason.GOAL
    elif episode.verdict in _PARAMETERS_START:
        outcome = EpisodeOutcome.GOAL_UNMET
        if episode.verdict == "FAIL" and len(turns) > 1 and turns[-1][0] == turns[-2][0]:
            ending = EpisodeEndReason.STOPPED  # Reflexion ends an episode after a repeated action
        elif len(turns) >= _MAX_TURNS:
            ending = EpisodeEndReason.OUT_OF_STEPS
    elif episode.verdict:
        number = episode.lines[-1][0]
        raise InputError(f"{path}, after line {number}: expected STATUS: OK or FAIL, or a score of 0 or 1")
    return _make_episode(name, opening, steps, outcome, ending)


def _read_turns(path: Path, lines: Sequence[tuple[int, str]]) -> list[tuple[str, str]]:
    """Return pairs of an agent's line and the game's reply.

    Raises:
        InputError: the number of an action or of a reply is not the next number, or a reply is missing.
    """
    turns: list[tuple[str, list[str]]] = []
    counts_turns = False
    for (number, line), (_, before) in zip(lines, [(0, ""), *lines], strict=False):
        action, reply = _ACT.fullmatch(line), _REPLY.fullmatch(line)
        follows_action = _ACT.fullmatch(before) is not None
        if action is not None:
            counts_turns = action[1] is not None
            expected = f"Act {len(turns) + 1}"
            if counts_turns and int(action[1]) != len(turns) + 1:
                raise InputError(f"{path}, line {number}: expected {expected}")
            if follows_action:
                raise InputError(f"{path}, line {number - 1}: expected the game's reply after this action")
            turns.append((action[2].strip(), []))
        elif follows_action and counts_turns and (reply is None or int(reply[1]) != len(turns)):
            raise InputError(
                f"{path}, line {number}: expected Obs {len(turns)}, the reply to Act {len(turns)}"
            )
        else:
            turns[-1][1].append(line if reply is None else reply[2])
    if turns and not turns[-1][1]:
        raise InputError(f"{path}, line {lines[-1][0]}: expected the game's reply after this action")
    return [(action, "\n".join(replies)) for action, replies in turns]


def _add_replay_results(
    episode: LoggedEpisode, tasks: Mapping[str, Task], benchmark: Benchmark
) -> LoggedEpisode:
    """Replay an episode in the game that its name or first observation determines."""
    games = _find_tasks_of_episode(episode, tasks)
    if len(games) != 1:
        return replace(episode, unknown=("the game", *episode.unknown))
    (task,) = games
    commands = [*_translate_steps_to_commands(episode.steps, task, benchmark)]
    told = "\n".join([episode.opening.partition(_TASK)[0], *[step.feedback for step in episode.steps]])
    kinds = {
        name.removesuffix("type")
        for goal in task.goals
        for name in find_object_names(goal.formula)
        if name.endswith("type")
    }
    unseen = tuple(sorted([kind for kind in kinds if not re.search(rf"\b{kind} \d", told)]))
    return replace(replay_steps(episode, commands, task, benchmark), unseen=unseen)


def _find_tasks_of_episode(episode: LoggedEpisode, tasks: Mapping[str, Task]) -> list[Task]:
    """Return the tasks (games) that have the task name of a logged episode.

    If the log does not name the game, return all tasks that fit the episode's first observation.
    """
    name = episode.task.replace("/", ".")
    if "/trial_" in episode.task:
        return [tasks[task_id] for task_id in tasks if task_id.endswith(name)]
    room, _, stated = episode.opening.partition(_TASK)
    instruction = " ".join(stated.split()).rstrip(".")
    places = {f"{kind}_{number}" for kind, number in re.findall(r"\ba (\w+) (\d+)", room)}
    return [
        task
        for task in map(tasks.__getitem__, tasks)
        if task.instruction.rstrip(".") == instruction
        and places == {item.name for item in task.scene.objects if item.category == "receptacle"}
    ]


def _translate_steps_to_commands(
    steps: Sequence[LoggedStep], task: Task, benchmark: Benchmark
) -> Iterator[str | None]:
    """Yield the command of each logged step, in the words of the game in which the log is replayed.

    Old versions of the game read ``put X in/on Y``, and new versions read ``move X to Y`` instead. An empty
    text stands for a command that the log's game could not read. None stands for a step that the replay
    skips, because the step changed nothing. Such a step was accepted, but has no effect. Or it is a put or
    move command that was not accepted, in a log without an accepted one to show the version of its game.
    """
    puts = {step.action[0].lower() for step in steps if step.accepted and _PUT.fullmatch(step.action)}
    notation, objects = CommandNotation(task, benchmark), range(len(task.scene.objects))
    meaning, _ = notation.read_command_and_repairs("put x 1 in/on y 1", objects, may_end_episode=False)
    is_new_game = isinstance(meaning, ErrorReport) and meaning.kind is FaultKind.PARSING
    form = "move {} to {}" if is_new_game else "put {} in/on {}"
    for step in steps:
        put = _PUT.fullmatch(step.action)
        if step.accepted and step.action in _WITHOUT_EFFECT:
            yield None
        elif put is None:
            yield "" if step.action.startswith(">") else step.action
        elif step.action[0].lower() in puts:
            yield form.format(*filter(None, put.groups()))
        else:  # if the log's game accepted the other word, put or move, it could not read this command
            yield "" if puts else None


ALFWORLD = LogReader("ALFWorld", _is_alfworld_log, _read_episodes, _add_replay_results)
