"""Read episodes of EmbodiedBench (EB-ALFRED and EB-Habitat): the steps of an episode, or its result.

The file of an episode has a step as JSON in each line, and the file of a result is one JSON object. The
environment gives a reason for each failure. A kind of error is proven only if the reason fits no other kind.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, Field

from eai.base.errors import InputError
from eai.base.files import number_lines, parse_json
from eai.extensions.logs.episode import Ending, EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.extensions.logs.readers import LogReader, validate
from eai.world.fault import FaultKind

_STEP_KEYS = (b'"last_action_success"', b'"action_id"')
_RESULT_KEYS = (b'"num_invalid_actions"', b'"task_success"', b'"num_steps"')

_INVALID, _EMPTY_PLAN = -1, -2
"""Ids for a plan whose first action was not understood, and for a plan without actions."""

_MAX_STEPS, _MAX_ERRORS = 30, 10
"""Numbers of actions and of failures at which the environments end an episode."""

_FULL_HAND = re.compile(r"Robot is currently holding|cannot pick any object when holding")
_EMPTY_HAND = re.compile(r"not holding any object|when not holding something")
_PICKS, _PLACES = re.compile(r"pick up "), re.compile(r"(?:put down|drop|place) ")
_KINDS = (
    (
        re.compile(r"instruction not supported|Cannot find .+ to (?:open|close|slice)"),
        FaultKind.HALLUCINATION,
    ),
    (
        re.compile(r"action failed\. The .+ is already (?:open|closed)|\[open_api_failed\].*isOpen=True"),
        FaultKind.ADDITIONAL_STEP,
    ),
    (re.compile(r"openable=False"), FaultKind.AFFORDANCE),
)

_OUTCOMES = {Ending.GOAL: EpisodeOutcome.WON, Ending.CANNOT_TELL: EpisodeOutcome.CANNOT_TELL}

_Share = Annotated[float, Field(ge=0, le=1)]
_Count = Annotated[int, Field(ge=0)]


class _PlanLine(BaseModel):
    action_id: int | str
    action_description: str
    last_action_success: _Share
    reasoning: str | None = None


class _StepLine(_PlanLine):
    task_success: _Share
    task_progress: _Share
    env_step: _Count
    env_feedback: str
    instruction: str


class _Result(BaseModel):
    instruction: str
    task_success: _Share
    task_progress: _Share
    num_steps: _Count
    num_invalid_actions: _Count
    empty_plan: _Count = 0
    planner_steps: _Count | None = None


def _recognize(content: bytes) -> bool:
    return any(all(key in content for key in keys) for keys in (_STEP_KEYS, _RESULT_KEYS))


def _read(path: Path, content: bytes) -> list[LoggedEpisode]:
    if all(key in content for key in _STEP_KEYS):
        return [_read_steps(path, content)]
    result = validate(_Result, str(path), parse_json(path, content))
    ending = _find_ending(
        result.task_success, result.num_invalid_actions, result.num_steps, bool(result.empty_plan)
    )
    episode = LoggedEpisode(result.instruction, _OUTCOMES.get(ending, EpisodeOutcome.GOAL_UNMET), ending)
    episode = replace(episode, actions=result.num_steps, calls=result.planner_steps)
    return [replace(episode, progress=result.task_progress, unknown=("errors of steps",))]


def _read_steps(path: Path, content: bytes) -> LoggedEpisode:
    lines: list[_PlanLine] = []
    done: list[_StepLine] = []
    for number, text in number_lines(content):
        place = f"{path}, line {number}"
        if lines and lines[-1].action_id == _EMPTY_PLAN:
            raise InputError(f"{place}: an empty plan ends the episode, so no line can follow")
        value = parse_json(path, text, number)
        line = validate(_PlanLine, place, value)
        if line.action_id not in (_INVALID, _EMPTY_PLAN):
            line = validate(_StepLine, place, value)
            _check_step(place, line, done)
            done.append(line)
        lines.append(line)
    steps: list[LoggedStep] = []
    for line in lines:
        if line.action_id != _EMPTY_PLAN:
            steps.append(_make_step(line, steps))
    last = done[-1] if done else None
    ending = _find_ending(
        last.task_success if last else 0,
        sum(not step.accepted for step in steps),
        last.env_step if last else 0,
        lines[-1].action_id == _EMPTY_PLAN,
    )
    return LoggedEpisode(
        last.instruction if last else path.stem,
        _OUTCOMES.get(ending, EpisodeOutcome.GOAL_UNMET),
        ending,
        tuple(steps),
        progress=last.task_progress if last else None,
        words=steps[-1].feedback if steps else "",
        unknown=() if ending is not Ending.CANNOT_TELL else ("the end",),
    )


def _check_step(place: str, line: _StepLine, done: Sequence[_StepLine]) -> None:
    if bool(line.last_action_success) is line.env_feedback.startswith("Last action is invalid"):
        raise InputError(f"{place}: last_action_success contradicts env_feedback")
    if done and line.env_step <= done[-1].env_step:
        raise InputError(f"{place}: expected env_step above {done[-1].env_step}, found {line.env_step}")


def _make_step(line: _PlanLine, before: Sequence[LoggedStep]) -> LoggedStep:
    if not isinstance(line, _StepLine):
        progress = before[-1].progress if before else None
        return LoggedStep(line.action_description, False, _find_plan_error(line.reasoning), "", progress)
    accepted = bool(line.last_action_success)
    kind = None if accepted else _find_kind(line, before)
    return LoggedStep(line.action_description, accepted, kind, line.env_feedback, line.task_progress)


def _find_plan_error(reply: str | None) -> FaultKind | None:
    """Return the kind of error of a reply whose first action was not understood, or None."""
    try:
        value = json.loads(reply or "null")
    except ValueError:  # a reply <answer>...</answer> is not JSON, and no error
        return None if "<answer>" in (reply or "") else FaultKind.PARSING
    match value:
        case {"executable_plan": [{"action_id": int()}, *_]}:
            return FaultKind.HALLUCINATION
    return None


def _find_kind(line: _StepLine, before: Sequence[LoggedStep]) -> FaultKind | None:
    """Return the kind of error that the reason of a failure proves, or None.

    After a successful pick, the hand has been both empty and full in the episode. So if an action fails
    because the hand is empty or full, the actions are in wrong order.
    """
    has_held = any(step.accepted and _PICKS.match(step.action) for step in before)
    if _FULL_HAND.search(line.env_feedback) and _PICKS.match(line.action_description):
        return FaultKind.WRONG_ORDER if has_held else None
    if _EMPTY_HAND.search(line.env_feedback):
        if not _PLACES.match(line.action_description):
            return None
        return FaultKind.WRONG_ORDER if has_held else FaultKind.MISSING_STEP
    return next((kind for pattern, kind in _KINDS if pattern.search(line.env_feedback)), None)


def _find_ending(success: float, errors: int, steps: int, is_empty_plan: bool) -> Ending:
    if success:
        return Ending.GOAL
    if is_empty_plan:
        return Ending.BY_AGENT
    if errors >= _MAX_ERRORS:
        return Ending.TOO_MANY_ERRORS
    return Ending.OUT_OF_STEPS if steps >= _MAX_STEPS else Ending.CANNOT_TELL


EMBODIEDBENCH = LogReader("EmbodiedBench", _recognize, _read)
