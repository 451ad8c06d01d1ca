"""Hand-made logs in the form of EmbodiedBench's episodes (EB-ALFRED and EB-Habitat), with labels.

A further log is an entry of `LABELLED`: a name, and the actions with success (1 or 0), the reason that the
environment gives for a failure, and the kind that this reason proves. A reason that fits several kinds proves
no kind.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from eai.base.errors import InputError
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.readers import read_log
from eai.world.fault import FaultKind

INSTRUCTION = "Put a clean mug on the desk."
DONE = "Last action executed successfully."
PICK, PUT = ("pick up the Mug", 1, "", None), ("put down the object in hand", 1, "", None)
HOLDS, EMPTY = "Robot is currently holding Mug", "Robot is not holding any object"
FULL = (
    " Robot cannot pick any object when holding something. Please place the object before picking something."
)
NOTHING = " Robot cannot place any object when not holding something. Please pick the object before place it."
FAR = " Robot cannot pick any object that is not near the robot. Navigate to other place to find the object."
SHUT = " Check whether the receptacle is already open or the robot is not near the receptacle."
IN_FRIDGE = "Apple is not visible because it is in Fridge. Go there to pick the object instead."
Action = tuple[str, int, str, FaultKind | None]

LABELLED: list[tuple[str, Sequence[Action]]] = [
    ("hand never held a thing", [("put down the object in hand", 0, EMPTY, FaultKind.MISSING_STEP)]),
    ("dropped too often", [PICK, PUT, ("drop the object in hand", 0, EMPTY, FaultKind.WRONG_ORDER)]),
    ("hand is full", [PICK, ("pick up the Plate", 0, HOLDS, FaultKind.WRONG_ORDER)]),
    ("hand is full, but no pick is logged", [("pick up the Plate", 0, HOLDS, None)]),
    ("a failed pick with an empty hand", [("pick up the Mug", 0, EMPTY, None)]),
    ("hidden in a receptacle", [("pick up the Apple", 0, IN_FRIDGE, None)]),
    (
        "open already",
        [("open the Fridge", 0, "Open action failed. The Fridge is already open", FaultKind.ADDITIONAL_STEP)],
    ),
    (
        "shut already",
        [
            (
                "close the Fridge",
                0,
                "Close action failed. The Fridge is already closed",
                FaultKind.ADDITIONAL_STEP,
            )
        ],
    ),
    ("open, without a reason", [("open the Fridge", 0, "Open action failed.", None)]),
    (
        "no such object",
        [
            (
                "open the Safe",
                0,
                "Cannot find Safe to open. Find the object before opening it",
                FaultKind.HALLUCINATION,
            )
        ],
    ),
    ("nothing to slice", [("slice the Lettuce", 0, "Cannot find Lettuce to slice", FaultKind.HALLUCINATION)]),
    ("no such object, or no switch", [("turn on the Mug", 0, "Cannot find Mug to turn on", None)]),
    (
        "not there, or no thing to pick",
        [("pick up the Mug", 0, "Cannot find Mug to pick up. Find the object", None)],
    ),
    ("no such action", [("dance", 0, "instruction not supported", FaultKind.HALLUCINATION)]),
    (
        "state in the reason",
        [
            (
                "open the Mug",
                0,
                "[open_api_failed] Failed. visible=True, openable=False, isOpen=False.",
                FaultKind.AFFORDANCE,
            )
        ],
    ),
    ("blocked", [("Move forward by 0.25", 0, "Desk is blocking Agent 0 from moving.", None)]),
    (
        "Habitat: full",
        [
            ("pick up the apple", 1, "", None),
            ("pick up the can", 0, FULL, FaultKind.WRONG_ORDER),
            ("place at the sofa", 1, "", None),
            ("pick up the can", 1, "", None),
        ],
    ),
    (
        "Habitat: full, or not there",
        [("pick up the apple", 1, "", None), ("pick up the can", 0, FULL, None)],
    ),
    ("Habitat: empty", [("place at the sofa", 0, NOTHING, FaultKind.MISSING_STEP)]),
    (
        "Habitat: empty again",
        [
            ("pick up the apple", 1, "", None),
            ("place at the sofa", 1, "", None),
            ("place at the sofa", 0, NOTHING, FaultKind.WRONG_ORDER),
        ],
    ),
    ("Habitat: far, or not there", [("pick up the apple", 0, FAR, None)]),
    ("Habitat: open or far", [("open the refrigerator", 0, SHUT, None)]),
]


def steps_of(actions: Sequence[Action], progress: float = 0.0) -> list[dict[str, Any]]:
    return [
        {
            "task_success": 0.0,
            "task_progress": progress,
            "instruction": INSTRUCTION,
            "env_step": number,
            "env_feedback": f"Last action is invalid. {reason}" if not success else DONE,
            "episode_elapsed_seconds": 2.5 * number,
            "last_action_success": float(success),
            "action_id": 7,
            "action_description": action,
            "reasoning": '{"executable_plan": []}',
        }
        for number, (action, success, reason, _) in enumerate(actions, 1)
    ]


def invalid(reasoning: str | None) -> dict[str, Any]:
    return {
        "last_action_success": 0.0,
        "action_id": -1,
        "action_description": "invalid action",
        "reasoning": reasoning,
    }


STOP = {"last_action_success": 0.0, "action_id": -2, "action_description": "empty plan", "reasoning": "{}"}


def read(folder: Path, lines: Sequence[object]) -> LoggedEpisode:
    path = folder / "episode_1_step_2.json"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    (episode,) = read_log(path)
    return episode


@pytest.mark.parametrize("actions", [case[1] for case in LABELLED], ids=[case[0] for case in LABELLED])
def test_the_reason_of_a_failure_proves_a_kind_or_none(tmp_path: Path, actions: Sequence[Action]) -> None:
    episode = read(tmp_path, steps_of(actions))
    assert [step.kind for step in episode.steps] == [kind for *_, kind in actions]
    assert [step.accepted for step in episode.steps] == [bool(success) for _, success, _, _ in actions]
    assert (episode.task, episode.outcome) == (INSTRUCTION, EpisodeOutcome.CANNOT_TELL)


@pytest.mark.parametrize(
    ("reasoning", "kind"),
    [
        ("I would pick the mug", FaultKind.PARSING),
        ("[" * 100_000, FaultKind.PARSING),
        ('{"executable_plan": [{"action_id": 900}]}', FaultKind.HALLUCINATION),
        ('{"executable_plan": [{"action": "mug"}]}', None),
        ('{"executable_plan": [{"action_id": 9}, {"action": "mug"}]}', None),
        ("<think>so</think><answer>900</answer>", None),
        (None, None),
    ],
)
def test_a_plan_that_was_not_understood_is_unreadable_or_names_an_unknown_action(
    tmp_path: Path, reasoning: str | None, kind: FaultKind | None
) -> None:
    episode = read(tmp_path, [*steps_of([PICK], 0.5), invalid(reasoning)])
    assert [(step.accepted, step.kind) for step in episode.steps] == [(True, None), (False, kind)]
    assert episode.index_of_first_error == 1


@pytest.mark.parametrize(
    ("lines", "outcome", "ending"),
    [
        ([{**steps_of([PICK])[0], "task_success": 1.0, "task_progress": 1.0}], "won", "goal reached"),
        ([*steps_of([PICK]), STOP], "goal unmet", "by the agent"),
        (steps_of([PICK] * 30), "goal unmet", "out of steps"),
        (
            [*steps_of([PICK, *[("open the Mug", 0, "", None)] * 4]), *[invalid("no")] * 6],
            "goal unmet",
            "too many errors",
        ),
        (steps_of([PICK, PUT]), "cannot tell", "cannot tell"),
    ],
)
def test_the_end_of_an_episode_follows_from_its_last_lines(
    tmp_path: Path, lines: Sequence[object], outcome: str, ending: str
) -> None:
    episode = read(tmp_path, lines)
    assert (episode.outcome, episode.ending) == (EpisodeOutcome(outcome), EpisodeEndReason(ending))


def test_the_best_moment_is_the_first_step_with_the_largest_progress(tmp_path: Path) -> None:
    lines = steps_of([PICK, PUT, PICK, PUT])
    for line, progress in zip(lines, (0.0, 0.5, 0.5, 0.25), strict=True):
        line["task_progress"] = progress
    episode = read(tmp_path, lines)
    assert (episode.best_goal_progress, episode.step_of_best_goal_progress, episode.progress) == (
        0.5,
        1,
        0.25,
    )


def test_a_file_of_results_has_an_outcome_but_no_steps(tmp_path: Path) -> None:
    result = {"reward": 0.1, "num_invalid_actions": 10, "empty_plan": 0, "instruction": INSTRUCTION}
    result |= {"task_success": 0.0, "task_progress": 0.5, "num_steps": 17, "planner_steps": 9}
    episode = read(tmp_path, [result])
    assert (episode.outcome, episode.ending) == (EpisodeOutcome.GOAL_UNMET, EpisodeEndReason.TOO_MANY_ERRORS)
    assert (episode.steps, episode.actions, episode.best_goal_progress, episode.calls) == ((), 17, 0.5, 9)
    assert episode.unknown == ("errors of steps",)
    episode = read(tmp_path, [{**result, "empty_plan": 1, "num_invalid_actions": 0, "task_progress": 0}])
    assert (episode.outcome, episode.best_goal_progress) == (EpisodeOutcome.GOAL_UNMET, None)
    assert episode.unknown == ("errors of steps", "progress")


def trajectory(actions: Sequence[Action], success: float, number: int = 1, **changed: object) -> object:
    """Return an episode in the form of the published trajectories, with one plan for each action."""
    plans = [
        {
            "language_plan": "1. I act.",
            "executable_plan": [
                {"step_id": step, "action": [7, action], "action_success": done, "env_feedback": reason}
            ],
        }
        for step, (action, done, reason, _) in enumerate(actions, 1)
    ]
    empty = {"language_plan": "", "executable_plan": []}
    names = {"model_name": "a", "eval_set": "base", "episode_id": number, "instruction": INSTRUCTION}
    return {**names, "input": "Act.", "success": success, "trajectory": [*plans, empty], **changed}


def read_trajectories(folder: Path, *trajectories: object) -> tuple[LoggedEpisode, ...]:
    path = folder / "dataset.json"
    path.write_text(json.dumps(trajectories))
    return read_log(path)


def test_published_trajectories_are_one_list_with_the_verdict_of_each_episode(tmp_path: Path) -> None:
    lost, won, idle = read_trajectories(
        *(tmp_path, trajectory([PICK, ("pick up the Plate", 0, HOLDS, None)], 0.0)),
        *(trajectory([PICK, PUT], 1.0, 2), trajectory([], 0.0, 3)),
    )
    assert (lost.task, lost.agent, lost.setting) == (f"{INSTRUCTION} (1)", "a", "base")
    assert [step.kind for step in lost.steps] == [None, FaultKind.WRONG_ORDER]
    assert (lost.outcome, lost.ending, lost.calls) == (
        EpisodeOutcome.GOAL_UNMET,
        EpisodeEndReason.CANNOT_TELL,
        3,
    )
    assert (won.outcome, won.ending, won.words) == (EpisodeOutcome.WON, EpisodeEndReason.GOAL, "")
    assert (lost.unknown, won.unknown) == (("progress", "the end"), ("progress",))
    assert idle.outcome is EpisodeOutcome.NOTHING_SUBMITTED


def test_published_low_level_actions_are_refused_with_the_place(tmp_path: Path) -> None:
    plan = {"executable_plan": [{"action": [1, 2, 3, 4, 5, 6, 1], "action_success": 1.0}]}
    with pytest.raises(InputError, match=r"0\.trajectory\.0\.executable_plan\.0\.action"):
        read_trajectories(tmp_path, trajectory([], 0.0, trajectory=[plan]))


GOOD = steps_of([PICK, PUT])


@pytest.mark.parametrize(
    ("lines", "place"),
    [
        ([GOOD[0], {**GOOD[1], "task_progress": 3}], "line 2: task_progress"),
        (
            [GOOD[0], {**GOOD[1], "last_action_success": 0.0}],
            "line 2: last_action_success contradicts env_feedback",
        ),
        ([GOOD[1], GOOD[0]], "line 2: expected env_step greater than 2"),
        (
            [GOOD[0], {k: v for k, v in GOOD[1].items() if k != "task_success"}],
            "line 2: task_success: is missing",
        ),
        ([GOOD[0], [1]], "line 2"),
        ([STOP, GOOD[0]], "line 2: expected no line after an empty plan"),
    ],
)
def test_a_damaged_log_is_refused_with_the_place(tmp_path: Path, lines: Sequence[object], place: str) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, lines)
    assert place in str(caught.value)


def test_a_log_that_ends_within_a_line_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log"
    path.write_text("\n".join(map(json.dumps, GOOD))[:-20])
    with pytest.raises(InputError, match=r"line 2, column \d+: expected JSON"):
        read_log(path)
