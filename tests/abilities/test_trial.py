"""Trials: attempts in a world that restarts or continues, with slips, until a success."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import pytest

from agents.switches import SWITCHES
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.attempt import Attempt
from eai.abilities.protocol import Ability
from eai.abilities.replanning_options import AttemptStart, ReplanningOptions
from eai.abilities.trial import MultiAttemptTrial
from eai.benchmarks.suite import open_suite
from eai.tasks.task import GoalKind
from eai.world.episode import SlipSampler

ACTIONS = Ability.ACTION_SEQUENCING
SUITE = open_suite(SWITCHES, ACTIONS)
LAMP, SHED, BOX, TORCH = "PRESS lamp", "GO shed", "OPEN box", "PRESS torch"
BOTH = (LAMP, SHED, BOX, TORCH)


def scorer(task_id: str = "both") -> ActionSequencingScorer:
    found = SUITE.scorer(task_id)
    assert isinstance(found, ActionSequencingScorer)
    return found


def plan(*steps: str) -> str:
    """Return a plan as an answer. Each step is an action and its object."""
    words = [step.split() for step in steps]
    return json.dumps([{"action": name, "object": ", ".join(objects)} for name, *objects in words])


def tried(experiment: ReplanningOptions, answers: Sequence[str], task_id: str = "both") -> list[Attempt]:
    trial = MultiAttemptTrial(scorer(task_id), experiment)
    for text in answers:
        trial.try_answer(text)
    return trial.attempts


def outcome_of(attempt: Attempt) -> str:
    """Return in two words how an attempt ended, and whether the goals hold."""
    error = attempt.verdict.error
    return f"{error.kind.value if error else 'ran'} {'won' if attempt.verdict.success else 'lost'}"


@pytest.mark.parametrize(
    ("world", "second", "outcome"),
    [
        ("restart", BOTH, "ran won"),
        ("continue", BOTH, "ran lost"),
        ("restart", (SHED, BOX, TORCH), "ran lost"),
        ("continue", (SHED, BOX, TORCH), "ran won"),
    ],
)
def test_a_further_attempt_restarts_or_continues_the_world(
    world: AttemptStart, second: tuple[str, ...], outcome: str
) -> None:
    """The first attempt presses the lamp on. A second press switches it off."""
    first, last = tried(ReplanningOptions(1, world), [plan(LAMP, TORCH), plan(*second)])
    assert outcome_of(first) == "missing_step lost"
    assert first.verdict.error is not None
    assert first.verdict.error.step == 1
    assert outcome_of(last) == outcome


def test_a_trial_ends_with_a_success_or_after_the_last_attempt() -> None:
    trial = MultiAttemptTrial(scorer(), ReplanningOptions(2))
    trial.try_answer(plan(LAMP))
    assert not trial.has_no_attempt_left
    trial.try_answer(plan(*BOTH))
    assert trial.has_no_attempt_left
    with pytest.raises(ValueError, match="over"):
        trial.try_answer(plan(*BOTH))
    lost = MultiAttemptTrial(scorer(), ReplanningOptions(2))
    for _ in range(3):
        assert not lost.has_no_attempt_left
        lost.try_answer("no plan")
    assert lost.has_no_attempt_left


def test_an_excluded_task_gets_one_attempt() -> None:
    trial = MultiAttemptTrial(scorer("none"), ReplanningOptions(3))
    attempt = trial.try_answer(plan(LAMP))
    assert trial.has_no_attempt_left
    assert attempt.verdict.excluded is not None
    assert attempt.goal_held_at is None


def test_the_first_state_with_all_goals_is_recorded() -> None:
    """The plan reaches the goal and leaves it again: it succeeds only if it ends at the goal."""
    through = plan(*BOTH, TORCH)
    (whole,) = tried(ReplanningOptions(), [through])
    assert (outcome_of(whole), whole.goal_held_at) == ("ran lost", 4)
    (ended,) = tried(ReplanningOptions(until="goal"), [through])
    assert (outcome_of(ended), ended.goal_held_at) == ("ran won", 4)
    (never,) = tried(ReplanningOptions(), [plan(LAMP)])
    assert never.goal_held_at is None


def test_goals_that_hold_at_the_start_are_recorded_at_step_zero() -> None:
    first, second = tried(ReplanningOptions(1, "continue"), [plan(*BOTH, LAMP), plan("GO hall")])
    assert (outcome_of(first), first.goal_held_at) == ("wrong_order lost", 4)
    assert (outcome_of(second), second.goal_held_at) == ("ran won", 0)


def find_seed(numbers: Sequence[int], length: int) -> int:
    """Return a seed with which exactly these draws slip, with a slip probability of one half."""
    for seed in range(10_000):
        luck = SlipSampler(0.5, "both", seed=seed, epoch=1)
        if [i for i in range(length) if luck.draw_whether_next_action_slips()] == list(numbers):
            return seed
    raise AssertionError


@pytest.mark.parametrize("world", get_args(AttemptStart))
def test_a_detected_slip_ends_the_attempt_without_an_error_of_the_answer(world: AttemptStart) -> None:
    seed = find_seed([1], 6)
    chosen = ReplanningOptions(1, world, slip=0.5, slip_seed=seed)
    rest = BOTH if world == "restart" else BOTH[1:]
    first, second = tried(chosen, [plan(*BOTH), plan(*rest)])
    assert (outcome_of(first), first.slipped_at) == ("slip lost", 1)
    assert first.verdict.executable is False
    assert first.explanation is not None
    assert [step.outcome for step in first.explanation.steps] == ["executed", "slip"]
    assert (outcome_of(second), second.slipped_at) == ("ran won", None)


def test_a_step_that_depends_on_a_silent_slip_fails() -> None:
    chosen = ReplanningOptions(slip=0.5, slip_seed=find_seed([1], 4), notice="silent")
    (attempt,) = tried(chosen, [plan(*BOTH)])
    assert (outcome_of(attempt), attempt.slipped_at) == ("missing_step lost", 1)
    assert attempt.verdict.error is not None
    assert attempt.verdict.error.step == 2  # the box is not here
    last = ReplanningOptions(slip=0.5, slip_seed=find_seed([3], 4), notice="silent")
    (unnoticed,) = tried(last, [plan(*BOTH)])
    assert (outcome_of(unnoticed), unnoticed.verdict.executable) == ("ran lost", True)


def test_a_wrong_order_may_refer_to_an_earlier_attempt() -> None:
    """The attempt counts its steps from its own beginning."""
    first, second = tried(ReplanningOptions(1, "continue"), [plan(SHED, BOX, "GO hall"), plan(TORCH)])
    assert (outcome_of(first), outcome_of(second)) == ("ran lost", "wrong_order lost")
    assert second.verdict.error is not None
    assert second.verdict.error.step == 0
    assert second.explanation is not None
    (step,) = second.explanation.steps
    assert step.earlier == "what it lacks held in an earlier attempt"


def test_action_goals_count_over_all_attempts_in_a_continued_world() -> None:
    goes_on = ReplanningOptions(1, "continue")
    _, last = tried(goes_on, [plan("WAVE", SHED), plan(BOX, TORCH)], "greet")
    assert outcome_of(last) == "ran won"
    _, anew = tried(replace(goes_on, world="restart"), [plan("WAVE"), plan(SHED, BOX)], "greet")
    assert outcome_of(anew) == "ran lost"


def test_the_rest_of_a_task_begins_in_the_present_state() -> None:
    trial = MultiAttemptTrial(scorer("greet"), ReplanningOptions(2, "continue"))
    assert trial.task_in_next_question.goals == trial.task.goals
    trial.try_answer(plan("WAVE", SHED))
    left = trial.task_in_next_question
    assert left.initial is not trial.task.initial
    assert [goal.kind for goal in left.goals] == [GoalKind.ACTION, GoalKind.STATE]
    assert [action.operator for action in trial.executed_actions] == ["WAVE", "GO"]
    anew = MultiAttemptTrial(scorer("greet"), ReplanningOptions(2))
    anew.try_answer(plan("WAVE", SHED))
    assert anew.task_in_next_question is anew.task
    assert anew.executed_actions == ()


def test_a_plain_attempt_has_the_scorers_verdict() -> None:
    for answer in (plan(*BOTH), plan(LAMP, TORCH), plan("FLY moon"), plan("GO shed shed"), "none", ""):
        (attempt,) = tried(ReplanningOptions(), [answer])
        assessment = scorer().assess(answer)
        assert (attempt.verdict, attempt.explanation) == (assessment.verdict, assessment.explain())
