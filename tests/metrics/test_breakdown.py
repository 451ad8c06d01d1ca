from __future__ import annotations

from dataclasses import replace

import pytest
from eai.metrics.explained import explanation_of

from eai.abilities.explanation import Explanation, GoalReport, StepReport
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Confusion, Verdict
from eai.errors import InputError
from eai.metrics.breakdown import Flow, Outcome, break_down, outcome
from eai.metrics.rate import Rate
from eai.pddl.planning import PlannerOutcome
from eai.world.fault import FaultKind
from metrics.verdicts import SUCCEEDED, failed, record

PLAN = Explanation(
    steps=(StepReport("WALK(bed.1)", "executed"), StepReport("GRAB(cup.2)", "missing_step", "why")),
    goals=(
        GoalReport("state", "not ON(light.1)", True),
        GoalReport("state", "forall x: lamp. (ON(x))", False),
        GoalReport("action", "READ or WATCH", False),
    ),
)


@pytest.mark.parametrize("kind", FaultKind)
def test_every_kind_of_error_is_an_outcome(kind: FaultKind) -> None:
    assert outcome(failed(kind), Ability.ACTION_SEQUENCING).value == kind.value


def test_outcomes_in_the_order_of_their_names() -> None:
    actions, goals, operators = (
        Ability.ACTION_SEQUENCING,
        Ability.GOAL_INTERPRETATION,
        Ability.TRANSITION_MODELING,
    )
    some, all_, none = (Verdict(counts={"state": Confusion(*c)}) for c in ((1, 1, 0), (2, 0, 0), (0, 1, 1)))
    for verdict, ability, expected in (
        (replace(SUCCEEDED, excluded="why"), actions, Outcome.EXCLUDED),
        (SUCCEEDED, actions, Outcome.SUCCESS),
        (Verdict(executable=True, success=False), actions, Outcome.GOAL_MISSED),
        (some, goals, Outcome.PARTLY_RIGHT),
        (all_, goals, Outcome.SUCCESS),
        (none, goals, Outcome.GOAL_MISSED),
        (replace(all_, planner=PlannerOutcome.UNSOLVABLE), operators, Outcome.PARTLY_RIGHT),
        (replace(all_, planner=PlannerOutcome.NOT_RUN), operators, Outcome.SUCCESS),
    ):
        assert outcome(verdict, ability) is expected


def test_flow_loses_answers_stage_by_stage() -> None:
    kinds = (FaultKind.PARSING, FaultKind.HALLUCINATION, FaultKind.ARGUMENT_NUMBER, FaultKind.AFFORDANCE)
    verdicts = [*map(failed, kinds), Verdict(executable=True, success=False), SUCCEEDED]
    verdicts.append(Verdict(excluded="why"))
    found = break_down([record(str(i), v) for i, v in enumerate(verdicts)], Ability.ACTION_SEQUENCING)
    assert found.flow == Flow(answers=6, readable=5, known=3, executed=2, reached=1)
    assert found.outcomes[Outcome.EXCLUDED] == 1
    assert break_down([], Ability.GOAL_INTERPRETATION).flow is None


def test_shares_by_length_action_and_predicate() -> None:
    verdict = replace(failed(FaultKind.MISSING_STEP), details={"explanation": PLAN.to_json()})
    found = break_down([record("1", verdict), record("2", verdict)], Ability.ACTION_SEQUENCING)
    assert found.by_goals == {1: Rate(0, 2)}
    assert found.by_length == {2: Rate(0, 2)}
    assert found.by_action == {"GRAB": Rate(0, 2), "WALK": Rate(2, 2)}
    assert found.by_predicate == {"ON": Rate(2, 4), "READ or WATCH": Rate(0, 2)}


def test_operators_by_f1() -> None:
    side = {"matched": ["on", "on"], "additional": ["near"], "missing": ["off"]}
    verdict = Verdict(details={"operators": [{"name": "open", "precondition": side, "effect": {}}]})
    found = break_down([record("1", verdict)], Ability.TRANSITION_MODELING)
    assert found.by_action == {"open": Rate(4, 6)}
    assert found.by_predicate == {"near": Rate(0, 1), "off": Rate(0, 1), "on": Rate(4, 4)}


def test_explanations_come_back_as_they_were_written() -> None:
    assert explanation_of(Verdict(details={"explanation": PLAN.to_json()})) == PLAN
    assert explanation_of(Verdict()) == Explanation()
    with pytest.raises(InputError, match=r"field explanation\.steps"):
        explanation_of(Verdict(details={"explanation": {"steps": 3}}))
