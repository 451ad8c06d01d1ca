"""Domains with a simulator of their own: execution by the simulator, and the laws that it must keep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count

import pytest

from abilities.action_sequencing.test_scorer import TASK
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.notation.plans import JsonPlanNotation
from eai.world.action import Action, Fault
from eai.world.conformance import check_domain
from eai.world.domain import Domain, make_declared_effects_simulator
from eai.world.episode import Episode, KnownOutcomes, Slip, SlipSampler
from eai.world.fault import FaultKind
from eai.world.operator import missing_step
from eai.world.state import State
from world import toy
from world.test_execution import plan

STUCK = Fault(FaultKind.MISSING_STEP, missing_step(toy.lit(toy.X), "it is too dark for {x}"))
"""A fault that is not part of the declaration."""


class Simulated:
    """The toy world, executed by a function of the state, the action and the declared state."""

    def __init__(
        self,
        initial: State,
        carry_out: Callable[[State, Action, State], State | Fault] = lambda before, action, after: after,
    ) -> None:
        self.state = initial
        self._carry_out = carry_out

    def act(self, action: Action, declared: State) -> State | Fault:
        after = self._carry_out(self.state, action, declared)
        if isinstance(after, State):
            self.state = after
        return after


def with_facts(state: State, added: Sequence[str] = (), without: Sequence[str] = ()) -> State:
    facts = set(state.facts()).union(map(state.scene.read_fact, added))
    return state.replace_all_facts(sorted(facts.difference(map(state.scene.read_fact, without))))


def world(carry_out: Callable[[State, Action, State], State | Fault]) -> Domain:
    return replace(toy.DOMAIN, begin=lambda initial: Simulated(initial, carry_out))


DARK = world(lambda before, action, after: STUCK if action.operator == "LIFT" else after)
LAMP_LIGHTS = world(lambda before, action, after: with_facts(after, ["lit(lamp)"]))


def test_a_simulator_may_fail_possible_actions_and_never_gets_impossible_ones() -> None:
    episode = Episode(DARK, toy.initial())
    assert episode.run(plan("PRESS lamp")) != STUCK
    assert episode.run(plan("LIFT red")) == STUCK
    assert isinstance(episode.act(*plan("GO shed")), State)
    assert [step.fault is STUCK for step in episode.trajectory.steps] == [False, True, False]


def test_an_action_that_slips_does_not_reach_the_simulator() -> None:
    episode = Episode(DARK, toy.initial(), SlipSampler(1.0, "task"))
    assert episode.act(*plan("LIFT red")) == Slip()


def test_an_episode_has_the_states_that_its_simulator_returns() -> None:
    episode = Episode(LAMP_LIGHTS, toy.initial())
    assert episode.run(plan("GO shed")) is None
    assert episode.state.has("lit", episode.state.scene.index["lamp"])


def test_episodes_stop_sharing_outcomes_if_the_simulator_departs_from_the_declaration() -> None:
    known: KnownOutcomes = {}
    initial, steps = toy.initial(), plan("GO shed", "PRESS lamp")
    Episode(toy.DOMAIN, initial, known_outcomes=known).run(steps)
    beside, alone = Episode(LAMP_LIGHTS, initial, known_outcomes=known), Episode(LAMP_LIGHTS, initial)
    assert beside.run(steps) == alone.run(steps)
    assert beside.trajectory == alone.trajectory


def test_plans_for_a_simulator_are_scored_but_not_repaired() -> None:
    answer = '[{"action": "LIFT", "object": "red"}]'
    scorer = ActionSequencingScorer(TASK, DARK, JsonPlanNotation())
    assessment = scorer.assess(answer)
    assert getattr(assessment.verdict, "error", None) is not None
    assert [step.reason for step in assessment.explain().steps] == ["it is too dark for red"]
    assert assessment.analyze_failure is None
    assert (
        ActionSequencingScorer(TASK, toy.DOMAIN, JsonPlanNotation()).assess(answer).analyze_failure
        is not None
    )


NUMBERS = count()


@pytest.mark.parametrize(
    ("domain", "defect"),
    [
        (toy.DOMAIN, None),
        (DARK, None),
        (LAMP_LIGHTS, None),
        (
            world(lambda before, action, after: after.scene.state(after.facts())),
            "GO: two equal simulators give different outcomes of the action",
        ),
        (
            world(lambda before, action, after: before if action.operator == "LIFT" else after),
            "LIFT: executed without its intended effect holding(x)",
        ),
        (
            world(lambda before, action, after: STUCK if next(NUMBERS) % 3 else after),
            "GO: two equal simulators give different outcomes of the action",
        ),
        (
            replace(toy.DOMAIN, begin=lambda initial: Simulated(with_facts(initial, (), ["at(blue, shed)"]))),
            "toy: the simulator begins without at of the initial state",
        ),
    ],
)
def test_a_broken_law_of_simulators_is_reported(domain: Domain, defect: str | None) -> None:
    found = {*check_domain(domain, [toy.initial()])}
    assert found == set() if defect is None else defect in found


def test_a_simulator_whose_state_differs_from_its_outcome_is_reported() -> None:
    class Late(Simulated):
        def act(self, action: Action, declared: State) -> State | Fault:
            return declared

    found = check_domain(replace(toy.DOMAIN, begin=Late), [toy.initial()])
    assert "GO: the simulator's state differs from the outcome that it returned" in found


def test_predicates_that_are_not_simulated_must_follow_the_declaration() -> None:
    found = check_domain(LAMP_LIGHTS, [toy.initial()], simulated_predicates=("at", "holding"))
    assert any("the simulator changes lit, which must follow the declaration" in each for each in found)
    moved = world(lambda before, action, after: with_facts(after, ["at(lamp, hall)"]))
    assert check_domain(moved, [toy.initial()], simulated_predicates=("at",)) == ()


def test_an_episode_follows_the_declaration_by_default() -> None:
    assert toy.DOMAIN.begin is make_declared_effects_simulator
