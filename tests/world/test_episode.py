from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.world.action import Action, Fault
from eai.world.episode import Episode, KnownOutcomes, Slip, SlipSampler
from eai.world.execution import Trajectory, attempt_action, execute_plan
from eai.world.fault import FaultKind, Notice
from eai.world.state import State
from world import toy
from world.random_domains import Case, cases
from world.test_execution import plan

RUN = plan("LIFT red", "GO shed", "DROP red", "PRESS lamp")
"""A plan in which every step but the last needs the step before it."""


def lucky(probability: float, *, seed: int = 0, notice: Notice = "detected") -> SlipSampler:
    return SlipSampler(probability, "task", seed=seed, notice=notice)


def episode(sampler: SlipSampler | None = None) -> Episode:
    return Episode(toy.DOMAIN, toy.initial(), sampler)


@given(cases())
@settings(deadline=None)
def test_a_plan_without_slips_has_the_trajectory_of_execute(case: Case) -> None:
    played = Episode(case.domain, case.initial, SlipSampler(0, "task"))
    ended = played.run(case.plan)
    trajectory = execute_plan(case.domain, case.initial, case.plan)
    assert played.trajectory == trajectory
    assert ended == trajectory.failure


@given(cases(), st.data())
@settings(deadline=None)
def test_episodes_with_equal_beginnings_share_known_outcomes(case: Case, data: st.DataObject) -> None:
    known: KnownOutcomes = {}
    for _ in range(4):
        ways = data.draw(st.lists(st.sampled_from(case.plan), max_size=6)) if case.plan else []
        played = Episode(case.domain, case.initial, known_outcomes=known)
        ended = played.run(ways)
        trajectory = execute_plan(case.domain, case.initial, ways)
        assert (played.trajectory, ended) == (trajectory, trajectory.failure)


def test_episodes_with_equal_beginnings_compute_no_action_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[Action] = []
    known: KnownOutcomes = {}
    monkeypatch.setattr(
        "eai.world.episode.attempt_action", lambda *given: tried.append(given[2]) or attempt_action(*given)
    )
    for steps in (RUN, RUN, RUN[:2]):
        Episode(toy.DOMAIN, toy.initial(), known_outcomes=known).run(steps)
    assert tried == list(RUN)
    Episode(toy.DOMAIN, toy.initial(), known_outcomes=known).run(RUN[1:])  # a plan with another beginning
    assert tried == [*RUN, *RUN[1:3]]


@given(cases(), st.floats(0, 1))
@settings(deadline=None)
def test_the_executed_actions_alone_lead_to_the_same_states(case: Case, probability: float) -> None:
    played = Episode(case.domain, case.initial, lucky(probability))
    for action in case.plan:
        played.act(action)
    trajectory = played.trajectory
    alone = execute_plan(case.domain, case.initial, trajectory.executed_actions)
    assert alone.failure is None
    assert alone.states == trajectory.states
    assert [step.action for step in trajectory.steps] == list(case.plan)


def test_each_action_returns_its_outcome() -> None:
    acted = episode()
    (lift, go, *_), (press,) = RUN, plan("PRESS lamp")
    fault = acted.act(press)
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.MISSING_STEP
    assert isinstance(acted.act(lift), State)
    assert acted.act(go) is acted.state
    assert [step.is_executed for step in acted.trajectory.steps] == [False, True, True]
    assert len(acted.trajectory.states) == 3


def test_after_a_fault_the_next_action_is_tried_in_the_same_state() -> None:
    acted = episode()
    before = acted.state
    acted.act(plan("PRESS lamp")[0])
    assert acted.state is before
    assert acted.run(RUN) is None


def test_a_wrong_order_is_searched_for_in_the_whole_episode() -> None:
    acted = episode()
    assert acted.run(plan("GO shed", "LIFT blue", "LIFT blue")) is not None
    assert acted.run(plan("GO hall")) is None
    fault = acted.run(plan("PRESS lamp"))
    assert isinstance(fault, Fault)
    assert (fault.kind, fault.earlier) == (FaultKind.WRONG_ORDER, 2)


@pytest.mark.parametrize(
    ("start", "states", "earlier"),
    [
        (0, 4, 2),  # the whole episode
        (1, 3, 1),  # one step before the part was executed
        (3, 2, 0),  # two of three steps before the part were executed
        (4, 1, -1),  # the state that counts is before the part
    ],
)
def test_a_part_of_an_episode_is_a_trajectory_of_its_own(start: int, states: int, earlier: int) -> None:
    acted = episode()
    acted.run(plan("GO shed", "LIFT blue", "LIFT blue"))
    acted.run(plan("GO hall"))
    fault = acted.run(plan("PRESS lamp"))
    assert isinstance(fault, Fault)
    whole, part = acted.trajectory, acted.trajectory_from(start)
    assert part.states == whole.states[-states:]
    assert [step.action for step in part.steps] == [step.action for step in whole.steps[start:]]
    assert part.steps[-1].fault == replace(fault, earlier=earlier)
    assert acted.trajectory_from(5) == Trajectory((acted.state,), ())


def test_an_additional_step_ends_no_plan() -> None:
    acted = episode()
    assert acted.run(plan("GO hall", "GO shed")) is None
    assert acted.trajectory.needless_step_count == 1


def test_a_plan_ends_early_if_its_condition_holds() -> None:
    acted = episode()
    lit = acted.state.scene.index["lamp"]
    assert acted.run([*RUN, *RUN], until=lambda now: now.state.has("lit", lit)) is None
    assert len(acted.trajectory.steps) == len(RUN)


def test_a_slip_changes_nothing_and_is_recorded() -> None:
    acted = episode(lucky(1))
    before = acted.state
    assert acted.act(RUN[0]) == Slip()
    assert acted.state is before
    (step,) = acted.trajectory.steps
    assert (step.fault, step.slipped, step.is_executed) == (None, True, False)
    assert acted.trajectory.executed_actions == ()
    assert acted.trajectory.failure is None


def test_a_detected_slip_ends_the_plan() -> None:
    acted = episode(lucky(1))
    assert acted.run(RUN) == Slip()
    assert len(acted.trajectory.steps) == 1


def test_after_a_silent_slip_the_plan_continues_and_a_dependent_step_fails() -> None:
    acted = episode(lucky(1, notice="silent"))
    fault = acted.run(RUN)
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.MISSING_STEP
    assert [step.slipped for step in acted.trajectory.steps] == [True, True, False]


def test_an_impossible_action_draws_no_random_number() -> None:
    plain, stumbling = episode(lucky(0.5, seed=3)), episode(lucky(0.5, seed=3))
    outcomes = []
    for action in RUN * 5:
        stumbling.act(plan("PRESS red")[0])
        outcomes.append((plain.act(action), stumbling.act(action)))
    assert [type(a) for a, _ in outcomes] == [type(b) for _, b in outcomes]


def test_equal_seeds_give_equal_slips() -> None:
    def draws(task_id: str = "a", seed: int = 0, epoch: int = 0) -> list[bool]:
        sampler = SlipSampler(0.5, task_id, seed=seed, epoch=epoch)
        return [sampler.draw_whether_next_action_slips() for _ in range(100)]

    assert draws() == draws()
    assert draws() not in [draws(seed=1), draws("b"), draws(epoch=1)]


def test_a_lower_probability_gives_a_subset_of_the_slips() -> None:
    few, many = lucky(0.1), lucky(0.3)
    assert all(
        b or not a
        for a, b in [
            (few.draw_whether_next_action_slips(), many.draw_whether_next_action_slips()) for _ in range(200)
        ]
    )


def test_a_possible_action_slips_as_often_as_it_should() -> None:
    seeds, p, length = 4000, 0.1, len(RUN)
    succeeded = sum([episode(lucky(p, seed=seed)).run(RUN) is None for seed in range(seeds)])
    expected = (1 - p) ** length
    assert abs(succeeded - seeds * expected) < 4 * math.sqrt(seeds * expected * (1 - expected))


def test_an_unknown_action_raises_a_key_error() -> None:
    with pytest.raises(KeyError):
        episode().act(Action("FLY", ()))
