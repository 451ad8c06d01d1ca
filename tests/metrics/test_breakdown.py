from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.declaration import AnswerOutcome
from eai.abilities.explanation import Explanation, GoalReport, StepReport
from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.report import OperatorReport, OperatorStatus
from eai.abilities.verdict import Confusion, GoalVerdict, OperatorVerdict, PlanVerdict, without_answer
from eai.metrics.breakdown import Flow, break_down, outcome
from eai.metrics.rate import Rate
from eai.pddl.matching import SideMatch
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
    assert outcome(record("1_1", failed(kind))).value == kind.value


def test_outcomes_in_the_order_of_their_names() -> None:
    actions, goals, operators = (
        Ability.ACTION_SEQUENCING,
        Ability.GOAL_INTERPRETATION,
        Ability.TRANSITION_MODELING,
    )
    some, all_, none = (
        GoalVerdict(counts={"state": Confusion(*c)}) for c in ((1, 1, 0), (2, 0, 0), (0, 1, 1))
    )
    right = OperatorVerdict(counts={"effect": {"object_states": Confusion(2, 0, 0)}})
    for verdict, ability, expected in (
        (replace(SUCCEEDED, excluded="why"), actions, AnswerOutcome.EXCLUDED),
        (SUCCEEDED, actions, AnswerOutcome.SUCCESS),
        (PlanVerdict(executable=True, success=False), actions, AnswerOutcome.GOAL_MISSED),
        (some, goals, AnswerOutcome.PARTLY_RIGHT),
        (all_, goals, AnswerOutcome.SUCCESS),
        (none, goals, AnswerOutcome.GOAL_MISSED),
        (replace(right, planner=PlannerOutcome.UNSOLVABLE), operators, AnswerOutcome.PARTLY_RIGHT),
        (replace(right, planner=PlannerOutcome.NOT_RUN), operators, AnswerOutcome.SUCCESS),
    ):
        assert outcome(record("1_1", verdict, ability=ability)) is expected


def test_a_task_without_an_answer_is_an_outcome_and_in_no_breakdown() -> None:
    lacking = replace(record("1_1", without_answer(failed(FaultKind.PARSING))), unanswered="no row")
    found = break_down([record("2_1", SUCCEEDED), lacking], Ability.ACTION_SEQUENCING)
    assert found.outcomes == {AnswerOutcome.NOT_ANSWERED: 1, AnswerOutcome.SUCCESS: 1}
    assert found.flow == Flow(1, 1, 1, 1, 1)
    assert found.by_goals == {1: Rate(1, 1)}


def test_flow_loses_answers_stage_by_stage() -> None:
    kinds = (FaultKind.PARSING, FaultKind.HALLUCINATION, FaultKind.ARGUMENT_NUMBER, FaultKind.AFFORDANCE)
    verdicts = [*map(failed, kinds), PlanVerdict(executable=True, success=False), SUCCEEDED]
    verdicts.append(PlanVerdict(excluded="why"))
    found = break_down([record(str(i), v) for i, v in enumerate(verdicts)], Ability.ACTION_SEQUENCING)
    assert found.flow == Flow(answers=6, readable=5, known=3, executed=2, reached=1)
    assert found.outcomes[AnswerOutcome.EXCLUDED] == 1
    assert break_down([], Ability.GOAL_INTERPRETATION).flow is None


def test_shares_by_length_action_and_predicate() -> None:
    explained = replace(record("1", failed(FaultKind.MISSING_STEP)), explanation=PLAN)
    found = break_down([explained, replace(explained, task_id="2")], Ability.ACTION_SEQUENCING)
    assert found.by_goals == {1: Rate(0, 2)}
    assert found.by_length == {2: Rate(0, 2)}
    assert found.by_action == {"GRAB": Rate(0, 2), "WALK": Rate(2, 2)}
    assert found.by_predicate == {"ON": Rate(2, 4), "READ or WATCH": Rate(0, 2)}


def test_operators_by_f1() -> None:
    side = SideMatch(("on", "on"), ("near",), ("off",))
    verdict = OperatorVerdict(operators=(OperatorReport("open", OperatorStatus.COMPARED, side),))
    written = record("1", verdict, ability=Ability.TRANSITION_MODELING)
    found = break_down([written], Ability.TRANSITION_MODELING)
    assert found.by_action == {"open": Rate(4, 6)}
    assert found.by_predicate == {"near": Rate(0, 1), "off": Rate(0, 1), "on": Rate(4, 4)}
