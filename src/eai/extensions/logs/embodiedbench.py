"""Read episodes of EmbodiedBench (EB-ALFRED and EB-Habitat): an episode's steps, its result, or trajectories.

The file of an episode has a step as JSON in each line, the file of a result is one JSON object, and published
trajectories are one list of episodes. The environment gives a reason for each failure. A kind of error is
proven only if the reason fits no other kind.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path

from pydantic import BaseModel, RootModel

from eai.base.errors import InputError
from eai.base.files import number_lines, parse_json
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.extensions.logs.readers import Count, LogReader, Share, validate
from eai.world.fault import FaultKind

_INVALID, _EMPTY_PLAN = -1, -2
"""Values of `action_id` if the first action was not understood, and if the plan has no actions."""

_MAX_STEPS, _MAX_ERRORS = 30, 10
"""Numbers of actions and of failures at which the environments end an episode."""

_FULL_HAND = re.compile(r"Robot is currently holding|cannot pick any object when holding")
_EMPTY_HAND = re.compile(r"not holding any object|when not holding something")
_PICKS, _PLACES = re.compile(r"pick up "), re.compile(r"(?:put down|drop|place) ")
_KINDS = {
    FaultKind.HALLUCINATION: r"instruction not supported|Cannot find .+ to (?:open|close|slice)",
    FaultKind.ADDITIONAL_STEP: r"action failed\. The .+ is already (?:open|closed)"
    r"|\[open_api_failed\].*isOpen=True|\[already_(?:open|closed|on|off)\]",
    FaultKind.AFFORDANCE: r"openable=False|\[not_(?:pickupable|receptacle|openable|toggleable|sliceable)\]",
}
"""Mapping from a kind of error to a regular expression for the stated reasons of failures of this kind."""


class _PlanLine(BaseModel):
    action_id: int | str
    action_description: str
    last_action_success: Share
    reasoning: str | None = None


class _ExecutedStepLogLine(_PlanLine):
    task_success: Share
    task_progress: Share
    env_step: Count
    env_feedback: str
    instruction: str


class _EpisodeResult(BaseModel):
    instruction: str
    task_success: Share
    task_progress: Share
    num_steps: Count
    num_invalid_actions: Count
    empty_plan: Count = 0
    planner_steps: Count | None = None


class _TrajectoryAction(BaseModel):
    action: tuple[int, str]
    action_success: Share
    env_feedback: str | None = None


class _TrajectoryPlan(BaseModel):
    executable_plan: Sequence[_TrajectoryAction] = ()


class _EpisodeTrajectory(BaseModel):
    model_name: str
    eval_set: str
    episode_id: int | str
    instruction: str
    success: Share
    trajectory: Sequence[_TrajectoryPlan]


class _TrajectoryFile(RootModel[Sequence[_EpisodeTrajectory]]):
    pass


def _read_trajectory_file(path: Path, content: bytes) -> list[LoggedEpisode]:
    found = validate(_TrajectoryFile, str(path), parse_json(path, content))
    return [_make_episode_from_trajectory(trajectory) for trajectory in found.root]


def _make_episode_from_trajectory(trajectory: _EpisodeTrajectory) -> LoggedEpisode:
    steps = [
        LoggedStep(done.action[1], bool(done.action_success), None, done.env_feedback or "")
        for plan in trajectory.trajectory
        for done in plan.executable_plan
    ]
    ending = EpisodeEndReason.GOAL if trajectory.success else EpisodeEndReason.CANNOT_TELL
    return LoggedEpisode(
        f"{trajectory.instruction} ({trajectory.episode_id})",
        _find_outcome(ending, len(steps)),
        ending,
        _add_error_kinds(steps),
        agent=trajectory.model_name,
        setting=trajectory.eval_set,
        calls=len(trajectory.trajectory),
        unknown=("progress", *([] if trajectory.success else ["the end"])),
    )


def _read_result(path: Path, content: bytes) -> list[LoggedEpisode]:
    result = validate(_EpisodeResult, str(path), parse_json(path, content))
    ending = _find_ending(
        result.task_success, result.num_invalid_actions, result.num_steps, bool(result.empty_plan)
    )
    # if a reply has no known action, EmbodiedBench writes progress 0 without measuring it
    is_measured = result.task_progress > 0 or ending not in (
        EpisodeEndReason.BY_AGENT,
        EpisodeEndReason.TOO_MANY_ERRORS,
    )
    return [
        LoggedEpisode(
            result.instruction,
            _find_outcome(ending, result.num_steps),
            ending,
            actions=result.num_steps,
            calls=result.planner_steps,
            progress=result.task_progress if is_measured else None,
            unknown=("errors of steps", *([] if is_measured else ["progress"])),
        )
    ]


def _read_step_lines_as_episodes(path: Path, content: bytes) -> list[LoggedEpisode]:
    steps: list[LoggedStep] = []
    done: list[_ExecutedStepLogLine] = []
    is_empty_plan = False
    for number, text in number_lines(content):
        place = f"{path}, line {number}"
        if is_empty_plan:
            raise InputError(f"{place}: expected no line after an empty plan, which ends the episode")
        value = parse_json(path, text, number)
        plan = validate(_PlanLine, place, value)
        is_empty_plan = plan.action_id == _EMPTY_PLAN
        if plan.action_id == _INVALID:
            kind, progress = _find_plan_error(plan.reasoning), steps[-1].progress if steps else None
            steps.append(LoggedStep(plan.action_description, False, kind, "", progress))
        elif not is_empty_plan:
            line = validate(_ExecutedStepLogLine, place, value)
            _check_feedback_and_order_of_step_line(place, line, done)
            done.append(line)
            is_done = bool(line.last_action_success)
            name, feedback = line.action_description, line.env_feedback
            steps.append(LoggedStep(name, is_done, None, feedback, line.task_progress))
    success, count = (done[-1].task_success, done[-1].env_step) if done else (0, 0)
    errors = sum(not step.accepted for step in steps)
    ending = _find_ending(success, errors, count, is_empty_plan)
    is_known = ending is not EpisodeEndReason.CANNOT_TELL
    return [
        LoggedEpisode(
            done[-1].instruction if done else path.stem,
            _find_outcome(ending, len(done)) if is_known else EpisodeOutcome.CANNOT_TELL,
            ending,
            _add_error_kinds(steps),
            progress=done[-1].task_progress if done else None,
            unknown=() if is_known else ("the end",),
        )
    ]


def _check_feedback_and_order_of_step_line(
    file_and_line: str, line: _ExecutedStepLogLine, earlier_lines: Sequence[_ExecutedStepLogLine]
) -> None:
    if bool(line.last_action_success) is line.env_feedback.startswith("Last action is invalid"):
        raise InputError(
            f"{file_and_line}: last_action_success contradicts env_feedback; "
            "expected 0 if and only if env_feedback starts with 'Last action is invalid'"
        )
    last_step = earlier_lines[-1].env_step if earlier_lines else None
    if last_step is not None and line.env_step <= last_step:
        raise InputError(
            f"{file_and_line}: expected env_step greater than {last_step}, found {line.env_step}"
        )


def _find_outcome(ending: EpisodeEndReason, actions: int) -> EpisodeOutcome:
    if ending is EpisodeEndReason.GOAL:
        return EpisodeOutcome.WON
    return EpisodeOutcome.GOAL_UNMET if actions else EpisodeOutcome.NOTHING_SUBMITTED


def _add_error_kinds(steps: Sequence[LoggedStep]) -> tuple[LoggedStep, ...]:
    """Return the steps, each with the kind of error that follows from the feedback of the environment."""
    return tuple([step._replace(kind=_find_error_kind(number, steps)) for number, step in enumerate(steps)])


def _find_plan_error(reply: str | None) -> FaultKind | None:
    """Return the kind of error of a model's reply whose first action was not understood.

    The result is None if the reply does not prove a kind.
    """
    try:
        value = json.loads(reply or "null")
    except (ValueError, RecursionError):  # a reply in <answer> tags need not be JSON
        return None if "<answer>" in (reply or "") else FaultKind.PARSING
    plan = value.get("executable_plan") if isinstance(value, dict) else None
    actions = plan if isinstance(plan, list) else []
    ids = [action.get("action_id") for action in actions if isinstance(action, dict)]
    all_named = len(ids) == len(actions) > 0 and all(isinstance(each, int) for each in ids)
    return FaultKind.HALLUCINATION if all_named else None


def _find_error_kind(step_index: int, steps: Sequence[LoggedStep]) -> FaultKind | None:
    """Return the kind of error of a failed step; None if its feedback leaves the kind uncertain.

    A successful pick shows that the hand was empty before it and full after it. If a later step needs an
    empty or a full hand and fails, the hand had this state at an earlier time: the actions are in wrong
    order. Without a successful pick, a failed place lacks a step. EB-Habitat says that the hand is full also
    if the object does not exist. The object exists if the feedback has "currently holding", or if the same
    action succeeds at another step.
    """
    step = steps[step_index]
    if step.accepted or step.kind is not None:
        return step.kind
    has_held = any(before.accepted and _PICKS.match(before.action) for before in steps[:step_index])
    if _FULL_HAND.search(step.feedback) and _PICKS.match(step.action):
        exists = "currently holding" in step.feedback
        exists = exists or any(other.accepted and other.action == step.action for other in steps)
        return FaultKind.WRONG_ORDER if has_held and exists else None
    if _EMPTY_HAND.search(step.feedback):
        if not _PLACES.match(step.action):
            return None
        return FaultKind.WRONG_ORDER if has_held else FaultKind.MISSING_STEP
    return next((kind for kind, reason in _KINDS.items() if re.search(reason, step.feedback)), None)


def _find_ending(success: float, errors: int, steps: int, is_empty_plan: bool) -> EpisodeEndReason:
    if success:
        return EpisodeEndReason.GOAL
    if is_empty_plan:
        return EpisodeEndReason.BY_AGENT
    if errors >= _MAX_ERRORS:
        return EpisodeEndReason.TOO_MANY_ERRORS
    return EpisodeEndReason.OUT_OF_STEPS if steps >= _MAX_STEPS else EpisodeEndReason.CANNOT_TELL


_FORMS = {
    _read_step_lines_as_episodes: (b'"last_action_success"', b'"action_id"'),
    _read_trajectory_file: (b'"eval_set"', b'"executable_plan"', b'"action_success"'),
    _read_result: (b'"num_invalid_actions"', b'"task_success"', b'"num_steps"'),
}
"""Mapping from each function that reads files to the JSON keys by which its files are recognized."""


def _is_embodiedbench_log(content: bytes) -> bool:
    return any(all(key in content for key in keys) for keys in _FORMS.values())


def _read_episodes(path: Path, content: bytes) -> list[LoggedEpisode]:
    read = next(read for read, keys in _FORMS.items() if all(key in content for key in keys))
    return read(path, content)


EMBODIEDBENCH = LogReader("EmbodiedBench", _is_embodiedbench_log, _read_episodes)
