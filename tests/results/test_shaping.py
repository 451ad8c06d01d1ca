"""Every shaping of rewards: verdicts and their pay, one row for each term."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pytest

from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.transition_modeling.verdict import (
    OperatorComparisonStatus,
    OperatorReport,
    OperatorVerdict,
)
from eai.abilities.verdict import (
    ConfusionCounts,
    ErrorReport,
    PlanVerdict,
    RewardInputs,
    Verdict,
    compute_condition_gain,
    compute_goal_gain,
)
from eai.pddl.check import PddlFinding, PddlViolationKind
from eai.pddl.matching import ClauseComparison
from eai.results.reward import (
    METRICS,
    Shaping,
    compute_reward_from_inputs,
    compute_reward_inputs_of_verdict,
    make_metrics_from_reward_inputs,
)
from eai.tasks.share import Share
from eai.world.fault import FaultKind

Worth = tuple[float, float, float, float]
"""By `success`, `goals`, `progress` and `diagnosis`."""

NOTHING: Worth = (0, 0, 0, 0)
ALL: Worth = (1, 1, 1, 1)


@pytest.mark.parametrize(
    ("reached", "at_start", "gained"),
    [
        ((), (), None),
        ((True,), (True,), None),
        ((False,), (True,), None),
        ((), (False,), 0),  # nothing was carried out
        ((False, False), (False, False), 0),
        ((True, False), (False, False), 1 / 2),
        ((True, True), (False, False), 1),
        ((True, False), (True, False), 0),
        ((True, True), (True, False), 1),
        ((False, True), (True, False), 0),  # one undone for one reached
        ((False, False), (True, False), 0),  # never less than nothing
        ((True, False, True, True), (True, True, False, False), 1 / 2),
        ((True, True, True, False), (True, False, False, False), 2 / 3),
    ],
)
def test_only_goals_that_did_not_hold_at_the_start_are_gained(
    reached: Sequence[bool], at_start: Sequence[bool], gained: float | None
) -> None:
    assert compute_goal_gain(reached, at_start) == gained


@pytest.mark.parametrize(
    ("partial", "at_start", "of_goals", "gained"),
    [
        ((0, 5), (0, 5), 0, 0),
        ((2, 5), (0, 5), 0, 2 / 5),
        ((5, 5), (0, 5), 1, 1),
        ((2, 5), (2, 5), 0, 0),  # met at the start
        ((3, 5), (2, 5), 0, 1 / 3),
        ((1, 5), (2, 5), 0, 0),  # never less than nothing
        ((0, 2), (1, 2), 0, 0),  # nothing was carried out
        ((1, 2), (2, 4), 0, 0),  # a condition of one option for that of another
        ((3, 4), (1, 2), 0, 1 / 2),
        ((1, 1), (1, 1), 1 / 2, 1 / 2),  # more objects than a goal counts, at the start
        ((5, 5), (0, 5), 1 / 2, 1 / 2),  # and at the end
    ],
)
def test_the_gain_in_partial_success_is_a_share_of_the_possible_gain(
    partial: tuple[int, int], at_start: tuple[int, int], of_goals: float, gained: float
) -> None:
    assert compute_condition_gain(Share(*partial), Share(*at_start), of_goals) == pytest.approx(gained)


def ran(
    *goals: bool,
    success: bool = False,
    steps: int = 0,
    error: FaultKind | None = None,
    executable: bool = True,
) -> PlanVerdict:
    told = None if error is None else ErrorReport(error, 1, "it is so")
    return PlanVerdict(
        executable=executable, success=success, additional_steps=steps, goals_satisfied=goals, error=told
    )


def subgoals(*goals: bool, errors: tuple[FaultKind, ...] = (), **told: object) -> SubgoalVerdict:
    values = {"executable": True, "success": False, "category": SubgoalAnswerCategory.RUNTIME, **told}
    return SubgoalVerdict(goals_satisfied=goals, errors=errors, **values)  # type: ignore[arg-type]


ONE_OF_TWO = (False, False)


@pytest.mark.parametrize(
    ("verdict", "at_start", "worth"),
    [
        pytest.param(ran(True, success=True), (False,), ALL, id="all goals"),
        pytest.param(ran(True, False), ONE_OF_TWO, (0, 1 / 2, 1 / 2, 1 / 2), id="one of two"),
        pytest.param(ran(False, False), ONE_OF_TWO, NOTHING, id="none"),
        pytest.param(ran(True, False), (True, False), NOTHING, id="what holds at the start"),
        pytest.param(ran(True, True, success=True), (True, False), ALL, id="what is left to gain"),
        pytest.param(ran(False, True), (True, False), NOTHING, id="what is undone costs as much"),
        pytest.param(ran(True, success=True), (True,), None, id="nothing to gain"),
        pytest.param(ran(success=True), (), None, id="no goals"),
        pytest.param(PlanVerdict(excluded="it has no plan"), (False,), None, id="in no statistics"),
        pytest.param(ran(True), (False,), (0, 1, 1, 1), id="no success"),
        pytest.param(
            ran(True, False, success=True), ONE_OF_TWO, (0, 1 / 2, 1 / 2, 1 / 2), id="success without all"
        ),
        pytest.param(ran(True, False, executable=False), ONE_OF_TWO, (0, 0, 1 / 2, 1 / 2), id="it was ended"),
        pytest.param(
            ran(True, False, executable=False, error=FaultKind.AFFORDANCE),
            ONE_OF_TWO,
            (0, 0, 1 / 2, 1 / 4),
            id="it was ended by an error",
        ),
        pytest.param(
            ran(True, False, steps=3), ONE_OF_TWO, (0, 1 / 2, 1 / 2, 1 / 8), id="three additional steps"
        ),
        pytest.param(
            ran(True, success=True, steps=1),
            (False,),
            (1, 1, 1, 1 / 2),
            id="a success with an additional step",
        ),
        pytest.param(
            ran(True, True, False, steps=2, executable=False, error=FaultKind.MISSING_STEP),
            (True, False, False),
            (0, 0, 1 / 2, 1 / 8),
            id="steps and an error",
        ),
        pytest.param(subgoals(True, False), ONE_OF_TWO, (0, 1 / 2, 1 / 2, 1 / 2), id="subgoals"),
        pytest.param(
            subgoals(True, False, additional_steps=1), ONE_OF_TWO, (0, 1 / 2, 1 / 2, 1 / 4), id="their steps"
        ),
        pytest.param(
            subgoals(True, success=True, refined=1, added_actions=1),
            (False,),
            (1 / 2, 1 / 2, 1 / 2, 1 / 2),
            id="a success for which the search added an action",
        ),
        pytest.param(
            subgoals(True, False, refined=9, added_actions=3, additional_steps=1),
            ONE_OF_TWO,
            (0, 1 / 8, 1 / 8, 1 / 16),
            id="what the search added, however many subgoals there are",
        ),
        pytest.param(
            subgoals(
                True,
                False,
                executable=False,
                additional_steps=1,
                errors=(FaultKind.ADDITIONAL_STEP, FaultKind.WRONG_ORDER, FaultKind.AFFORDANCE),
                error=ErrorReport(FaultKind.AFFORDANCE, 1, "it cannot be opened"),
            ),
            ONE_OF_TWO,
            (0, 0, 1 / 2, 1 / 8),
            id="all errors of the way that is reported, and no more",
        ),
    ],
)
def test_plans_are_paid_for_the_goals_that_they_gain(
    verdict: PlanVerdict, at_start: tuple[bool, ...], worth: Worth | None
) -> None:
    assert paid(compute_reward_inputs_of_verdict(verdict, at_start)) == worth


def paid(earned: RewardInputs | None) -> Worth | None:
    if earned is None:
        return None
    success, goals, progress, diagnosis = [
        compute_reward_from_inputs(earned, shaping) for shaping in [*Shaping][:4]
    ]
    assert (
        compute_reward_from_inputs(earned, Shaping.PARTIAL) == progress
    )  # conditions are measured by `Reward`
    return success, goals, progress, diagnosis


def test_plans_are_paid_for_the_conditions_that_they_gain() -> None:
    earned = RewardInputs(1 / 4, success=False, ended=True, faults={A: 2}, added_actions=1, conditions=1 / 2)
    assert compute_reward_from_inputs(earned, Shaping.PARTIAL) == 1 / 4


def stated(
    hit: int, extra: int, missed: int, *strangers: str, ill_formed: int = 0, error: FaultKind | None = None
) -> GoalVerdict:
    return GoalVerdict(
        counts={"all": ConfusionCounts(hit, extra, missed), "state": ConfusionCounts(9, 9, 9)},
        hallucinated=strangers,
        ill_formed=ill_formed,
        error=None if error is None else ErrorReport(error, None, "it is so"),
    )


@pytest.mark.parametrize(
    ("verdict", "worth"),
    [
        pytest.param(stated(2, 0, 0), ALL, id="all of them"),
        pytest.param(stated(2, 0, 2), (0, 4 / 6, 4 / 6, 4 / 6), id="two are missing"),
        pytest.param(stated(2, 3, 0), (0, 4 / 7, 4 / 7, 4 / 7), id="three are wrong"),
        pytest.param(stated(2, 1, 1), (0, 4 / 6, 4 / 6, 4 / 6), id="one each"),
        pytest.param(stated(2, 0, 0, "sofa_9"), (0, 4 / 5, 4 / 5, 2 / 5), id="a name that means nothing"),
        pytest.param(stated(2, 0, 0, ill_formed=1), (0, 4 / 5, 4 / 5, 2 / 5), id="one that lacks a part"),
        pytest.param(stated(2, 0, 0, ill_formed=3), (0, 4 / 7, 4 / 7, 1 / 7), id="three that lack a part"),
        pytest.param(
            stated(2, 1, 0, "a", "b", ill_formed=1), (0, 4 / 8, 4 / 8, 1 / 8), id="all that is wrong"
        ),
        pytest.param(stated(0, 3, 2, "a", ill_formed=2), NOTHING, id="nothing is right"),
        pytest.param(stated(0, 0, 2), NOTHING, id="nothing is stated"),
        pytest.param(
            stated(2, 0, 0, error=FaultKind.PARSING), (0, 0, 1, 1 / 2), id="an error of the whole answer"
        ),
        pytest.param(stated(0, 0, 0), None, id="no goals"),
        pytest.param(stated(0, 3, 0, "a", ill_formed=2), None, id="no goals, and some were stated"),
        pytest.param(GoalVerdict(), None, id="nothing was counted"),
    ],
)
def test_stated_goals_are_paid_by_their_f1(verdict: GoalVerdict, worth: Worth | None) -> None:
    assert paid(compute_reward_inputs_of_verdict(verdict)) == worth


@pytest.mark.parametrize("hit", range(4))
@pytest.mark.parametrize("missed", range(3))
def test_meaningless_goals_earn_nothing(hit: int, missed: int) -> None:
    for ill_formed in range(3):
        for strangers in ((), ("a",), ("a", "b")):
            worth = paid(
                compute_reward_inputs_of_verdict(stated(hit, 0, missed, *strangers, ill_formed=ill_formed))
            )
            for more in (
                stated(hit, 0, missed, *strangers, ill_formed=ill_formed + 1),
                stated(hit, 0, missed, *strangers, "c", ill_formed=ill_formed),
                stated(hit, 1, missed, *strangers, ill_formed=ill_formed),
            ):
                less = paid(compute_reward_inputs_of_verdict(more))
                assert (worth, less) == (None, None) or (worth and less and less <= worth)
                assert not hit or (worth and less and less[2] < worth[2])


def written(
    *reports: OperatorReport, error: FaultKind | None = None, **sides: Mapping[str, ConfusionCounts]
) -> Verdict:
    return OperatorVerdict(
        counts=sides
        or {"precondition": {"all": ConfusionCounts(1, 0, 0)}, "effect": {"all": ConfusionCounts(1, 0, 0)}},
        operators=reports,
        error=None if error is None else ErrorReport(error, None, "it is so"),
    )


def compared(*offences: PddlViolationKind) -> OperatorReport:
    return _operator(OperatorComparisonStatus.COMPARED, *offences)


def _operator(status: OperatorComparisonStatus, *offences: PddlViolationKind) -> OperatorReport:
    findings = tuple([PddlFinding(offence, "x", "its effect") for offence in offences])
    return OperatorReport("open", status, ClauseComparison(), ClauseComparison(), findings)


MISSING, UNREADABLE, HALLUCINATED = (
    _operator(status)
    for status in (
        OperatorComparisonStatus.MISSING,
        OperatorComparisonStatus.UNREADABLE,
        OperatorComparisonStatus.HALLUCINATED,
    )
)


@pytest.mark.parametrize(
    ("verdict", "worth"),
    [
        pytest.param(written(compared()), ALL, id="all clauses"),
        pytest.param(
            written(precondition={"all": ConfusionCounts(1, 2, 0)}, effect={"all": ConfusionCounts(3, 0, 1)}),
            (0, 8 / 11, 8 / 11, 8 / 11),
            id="both sides together",
        ),
        pytest.param(
            written(
                precondition={"all": ConfusionCounts(1, 2, 0), "object_states": ConfusionCounts(9, 9, 9)},
                effect={"all": ConfusionCounts(1, 0, 0)},
            ),
            (0, 4 / 6, 4 / 6, 4 / 6),
            id="where all are counted, not by category besides",
        ),
        pytest.param(
            written(
                effect={
                    "object_states": ConfusionCounts(1, 1, 0),
                    "spatial_relations": ConfusionCounts(1, 0, 1),
                }
            ),
            (0, 4 / 6, 4 / 6, 4 / 6),
            id="by category, where all are not",
        ),
        pytest.param(written(effect={"all": ConfusionCounts(0, 0, 0)}), None, id="no clause is asked for"),
        pytest.param(
            written(effect={"all": ConfusionCounts(0, 5, 0)}), None, id="none, and some were written"
        ),
        pytest.param(written(effect={"all": ConfusionCounts(0, 5, 2)}), NOTHING, id="nothing is right"),
        pytest.param(OperatorVerdict(), None, id="nothing was counted"),
        pytest.param(written(compared(), MISSING), ALL, id="what is missing is counted by its clauses"),
        pytest.param(written(compared(), UNREADABLE), (0, 1, 1, 1 / 2), id="one that cannot be read"),
        pytest.param(written(HALLUCINATED, HALLUCINATED), (0, 1, 1, 1 / 3), id="two that were not asked for"),
        pytest.param(written(compared(PddlViolationKind.DUPLICATE)), (0, 1, 1, 1 / 2), id="an offence"),
        pytest.param(
            written(compared(PddlViolationKind.UNKNOWN_TYPE, PddlViolationKind.WRONG_ARITY)),
            (0, 1, 1, 1 / 3),
            id="two offences",
        ),
        pytest.param(
            written(_operator(OperatorComparisonStatus.HALLUCINATED, PddlViolationKind.WRONG_ARITY)),
            (0, 1, 1, 1 / 2),
            id="what was not asked for is one fault, whatever is wrong with it",
        ),
        pytest.param(written(error=FaultKind.PARSING), (0, 0, 1, 1 / 2), id="an error of the whole answer"),
    ],
)
def test_operators_are_paid_by_the_f1_of_their_clauses(verdict: Verdict, worth: Worth | None) -> None:
    assert paid(compute_reward_inputs_of_verdict(verdict)) == worth


P, H, N, A = FaultKind.PARSING, FaultKind.HALLUCINATION, FaultKind.ARGUMENT_NUMBER, FaultKind.AFFORDANCE


@pytest.mark.parametrize(
    ("verdict", "faults"),
    [
        (ran(True, steps=2), {FaultKind.ADDITIONAL_STEP: 2}),
        (ran(True, steps=1, error=A), {FaultKind.ADDITIONAL_STEP: 1, A: 1}),
        (ran(True, steps=1, error=FaultKind.ADDITIONAL_STEP), {FaultKind.ADDITIONAL_STEP: 2}),
        (subgoals(True, errors=(A, H, A)), {A: 2, H: 1}),
        (stated(1, 1, 1), {}),
        (stated(1, 0, 0, "a", "b", ill_formed=3), {P: 3, H: 2}),
        (stated(1, 0, 0, "a", ill_formed=1, error=P), {P: 2, H: 1}),
        (written(compared()), {}),
        (written(MISSING), {}),
        (written(UNREADABLE, HALLUCINATED, HALLUCINATED), {P: 1, H: 2}),
        (written(UNREADABLE, error=P), {P: 2}),
        *[
            (written(compared(offence)), {kind: 1})
            for offence, kind in {
                **dict.fromkeys(PddlViolationKind, P),
                PddlViolationKind.UNKNOWN_PREDICATE: H,
                PddlViolationKind.UNKNOWN_TYPE: H,
                PddlViolationKind.UNBOUND_VARIABLE: H,
                PddlViolationKind.UNDECLARED_CONSTANT: H,
                PddlViolationKind.WRONG_ARITY: N,
                PddlViolationKind.WRONG_ARGUMENT_TYPE: A,
            }.items()
        ],
    ],
)
def test_faults_are_counted_by_kind_as_metrics(verdict: Verdict, faults: Mapping[FaultKind, int]) -> None:
    earned = compute_reward_inputs_of_verdict(verdict, (False,))
    assert earned is not None
    assert earned.faults == faults
    told = make_metrics_from_reward_inputs(earned)
    assert tuple(told) == METRICS
    assert told["faults"] == sum(faults.values())
    assert {kind: told[f"fault.{kind.value}"] for kind in FaultKind} == dict.fromkeys(FaultKind, 0) | faults


def test_metrics_follow_from_the_credit() -> None:
    told = make_metrics_from_reward_inputs(RewardInputs(1 / 2, success=False, ended=True, faults={A: 2}))
    assert (told["success"], told["progress"], told["faults"], told["fault.affordance"]) == (0, 1 / 2, 2, 2)
    assert (
        make_metrics_from_reward_inputs(RewardInputs(1, success=True, ended=False, faults={}))["success"] == 1
    )
    assert make_metrics_from_reward_inputs(None) == dict.fromkeys(METRICS, 0)


def test_a_verdict_without_an_ability_has_no_credit() -> None:
    with pytest.raises(NotImplementedError, match="Verdict does not define how answers are rewarded"):
        compute_reward_inputs_of_verdict(Verdict())
