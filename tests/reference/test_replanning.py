"""The script of stochastic actions as a preset: where it ends attempts and trials otherwise than we do."""

from __future__ import annotations

from dataclasses import replace

import pytest

from abilities.action_sequencing.test_trial import BOTH, LAMP, SHED, TORCH, came_to, plan, scorer
from eai.abilities.action_sequencing.trial import Trial
from eai.abilities.experiment import Experiment, Feedback, World
from eai.abilities.record import Attempt
from eai.benchmark.protocols import preset_experiment
from eai.errors import InputError
from eai.reference.replanning import ScriptedTrial
from eai.world.episode import Until


def scripted(slip: float = 0.0) -> Experiment:
    found = preset_experiment("eai-1.0.5", slip, 0, 0)
    assert found is not None
    return found


def tried(experiment: Experiment, *answers: str) -> tuple[list[Attempt], bool]:
    """The attempts, and whether the trial is over after them."""
    trial = (Trial if experiment.preset is None else ScriptedTrial)(scorer(), experiment)
    for text in answers:
        trial.take(text)
    return trial.attempts, trial.over


def test_the_preset_is_an_experiment_of_its_own() -> None:
    ours = Experiment(3, World.CONTINUE, Feedback.STATE, slip=0.1, slip_seed=0, until=Until.GOAL)
    assert replace(scripted(0.1), preset=None) == ours
    assert scripted(0.1).label == f"{ours.label}+as-eai-1.0.5"
    assert preset_experiment("", 0.1, 0, 3) is None
    with pytest.raises(InputError, match="'eai-9' is no preset: expected eai-1"):
        preset_experiment("eai-9", 0.1, 0, 3)


def test_a_plan_that_misses_the_goal_is_not_asked_for_again() -> None:
    (attempt,), over = tried(scripted(), plan(LAMP))
    assert (came_to(attempt), over) == ("ran lost", True)
    assert not tried(replace(scripted(), preset=None), plan(LAMP))[1]


def test_a_step_that_is_not_needed_ends_the_attempt() -> None:
    (attempt,), over = tried(scripted(), plan(LAMP, "GO hall", SHED))
    assert (came_to(attempt), over) == ("additional_step lost", False)
    assert (attempt.verdict.executable, attempt.verdict.additional_steps) == (False, 1)
    (ours,), _ = tried(replace(scripted(), preset=None), plan(LAMP, "GO hall", SHED))
    assert came_to(ours) == "ran lost"


def test_a_slip_is_drawn_before_it_is_known_whether_the_action_is_possible() -> None:
    (attempt,), over = tried(scripted(1.0), plan(TORCH))
    assert (came_to(attempt), attempt.slipped_at, over) == ("slip lost", 0, False)
    (ours,), _ = tried(replace(scripted(1.0), preset=None), plan(TORCH))
    assert (came_to(ours), ours.slipped_at) == ("missing_step lost", None)


def test_what_else_ends_an_attempt_is_as_with_us() -> None:
    for plans in ([plan(*BOTH, TORCH)], [plan(LAMP, TORCH), plan(*BOTH[1:])], ["no plan", plan(*BOTH)]):
        theirs, over = tried(scripted(), *plans)
        ours, _ = tried(replace(scripted(), preset=None), *plans)
        assert [came_to(each) for each in theirs] == [came_to(each) for each in ours]
        assert over
