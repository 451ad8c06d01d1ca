from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import Confusion, Counted, ErrorReport, PlanVerdict, SubgoalCategory, Verdict
from eai.metrics.rate import Rate
from eai.metrics.summary import MAIN_COLUMNS, TABLE_COLUMNS, contribution, summarise
from eai.pddl.planning import PlannerOutcome
from eai.world.fault import FaultKind
from metrics.verdicts import SUCCEEDED, failed, goals

ARITY = ErrorReport(FaultKind.ARGUMENT_NUMBER, None, "OPEN takes 1 argument")


@pytest.mark.parametrize("ability", Ability)
def test_every_column_of_the_tables_is_a_metric(ability: Ability) -> None:
    rates = summarise([Verdict()], "virtualhome", ability, Protocol.STRICT)
    assert {*TABLE_COLUMNS[ability], *MAIN_COLUMNS[ability]} <= rates.keys()


def test_excluded_answers_are_in_no_denominator() -> None:
    verdicts = [SUCCEEDED, replace(SUCCEEDED, excluded="why")]
    rates = summarise(verdicts, "virtualhome", Ability.ACTION_SEQUENCING, Protocol.STRICT)
    assert rates["task_success"] == Rate(1, 1)


def test_plans_by_the_kind_of_their_end() -> None:
    verdicts = [SUCCEEDED, failed(FaultKind.MISSING_STEP), failed(FaultKind.PARSING)]
    rates = summarise(verdicts, "behavior", Ability.ACTION_SEQUENCING, Protocol.STRICT)
    assert rates["task_success"] == Rate(1, 3)
    assert rates["missing_step"] == rates["parsing"] == Rate(1, 3)
    assert rates["wrong_order"] == Rate(0, 3)
    assert rates["state_goal"] == rates["total_goal"] == Rate(1, 3)


def test_answers_with_additional_steps_are_counted() -> None:
    verdicts = [replace(SUCCEEDED, additional_steps=3), SUCCEEDED]
    rates = summarise(verdicts, "virtualhome", Ability.ACTION_SEQUENCING, Protocol.STRICT)
    assert rates["additional_step"] == Rate(1, 2)


def test_an_answer_may_count_as_something_else_than_its_verdict_says() -> None:
    in_order = goals((1, 1), action=(1, 2))
    counted = Counted(False, in_order, ((FaultKind.PARSING, 2), (FaultKind.ADDITIONAL_STEP, 3)))
    verdict = PlanVerdict(executable=True, success=True, goals=goals((1, 1)), counted=counted)
    rates = summarise([verdict], "virtualhome", Ability.ACTION_SEQUENCING, Protocol.EAI_1_0_5)
    assert rates["task_success"] == Rate(0, 1)
    assert rates["execution_success"] == Rate(1, 1)
    assert (rates["parsing"], rates["additional_step"]) == (Rate(2, 1), Rate(3, 1))
    assert (rates["affordance"], rates["action_goal"]) == (Rate(0, 1), Rate(1, 2))


def test_predicted_goals() -> None:
    read = Verdict(
        counts={"state": Confusion(2, 1, 0), "action": Confusion(0, 0, 1)},
        details={"predicted": 4, "ill_formed": 1, "hallucinated": ["sofaa", "x"]},
    )
    unread = Verdict(
        counts={"state": Confusion(0, 0, 2)}, error=ErrorReport(FaultKind.PARSING, None, "no JSON")
    )
    rates = summarise([read, unread], "virtualhome", Ability.GOAL_INTERPRETATION, Protocol.STRICT)
    assert rates["state.recall"] == Rate(2, 4)
    assert rates["overall.precision"] == Rate(2, 3)
    assert rates["overall.f1"] == Rate(4, 8)
    assert rates["relation.f1"].percent is None
    assert rates["parsing"] == Rate(1, 2)
    assert (rates["ill_formed"], rates["hallucination"]) == (Rate(1, 4), Rate(2, 4))


def test_goals_of_no_kind_count_overall() -> None:
    verdict = Verdict(counts={"state": Confusion(1, 0, 0), "all": Confusion(1, 2, 0)})
    rates = summarise([verdict], "behavior", Ability.GOAL_INTERPRETATION, Protocol.STRICT)
    assert rates["overall.precision"] == Rate(1, 3)


def test_subgoals_by_outcome() -> None:
    correct = Verdict(category=SubgoalCategory.CORRECT, additional_steps=2, goals=goals((1, 1)))
    arity = Verdict(category=SubgoalCategory.HALLUCINATION, error=ARITY)
    unknown = Verdict(
        category=SubgoalCategory.HALLUCINATION, error=ErrorReport(FaultKind.HALLUCINATION, None, "x")
    )
    unreadable = Verdict(category=SubgoalCategory.NOT_PARSEABLE)
    verdicts = [correct, arity, unknown, unreadable]
    rates = summarise(verdicts, "virtualhome", Ability.SUBGOAL_DECOMPOSITION, Protocol.STRICT)
    for name in ("task_success", "execution_success", "parsing", "argument_number", "hallucination"):
        assert rates[name] == Rate(1, 4), name
    assert rates["additional_step"] == Rate(1, 4)


def test_reference_counts_entries_but_not_those_of_unreachable_goals() -> None:
    wrong_order = ErrorReport(FaultKind.WRONG_ORDER, 0, "why")
    runtime = Verdict(
        category=SubgoalCategory.RUNTIME,
        error=wrong_order,
        details={"errors": ["wrong_order", "additional_step", "wrong_order"]},
    )
    missed = replace(runtime, category=SubgoalCategory.GOAL_UNREACHABLE, additional_steps=1)
    for protocol, counted, additional in ((Protocol.EAI_1_0_5, 2, 0), (Protocol.STRICT, 2, 1)):
        rates = summarise([runtime, missed], "virtualhome", Ability.SUBGOAL_DECOMPOSITION, protocol)
        assert rates["wrong_order"] == Rate(counted, 2)
        assert rates["additional_step"] == Rate(additional, 2)
    assert rates["execution_success"] == Rate(1, 2)


def test_operators_count_by_category_and_plans_by_task() -> None:
    solved = Verdict(
        counts={
            "precondition": {"object_states": Confusion(1, 0, 1)},
            "effect": {"object_states": Confusion(1, 2, 0), "object_tools": Confusion(3, 0, 0)},
        },
        planner=PlannerOutcome.SOLVED,
        details={"task_categories": ["object_states", "spatial_relations"]},
    )
    unsolved = replace(solved, planner=PlannerOutcome.TIME, counts=None, details=None)
    rates = summarise([solved, unsolved], "behavior", Ability.TRANSITION_MODELING, Protocol.STRICT)
    assert rates["object_states.f1"] == Rate(4, 7)
    assert rates["overall.precision"] == Rate(5, 7)
    assert rates["overall.planner_success"] == Rate(1, 2)
    assert rates["spatial_relations.planner_success"] == Rate(1, 1)
    assert rates["object_affordance.planner_success"].percent is None


def test_without_a_planner_there_is_no_planner_success() -> None:
    foregone = Verdict(planner=PlannerOutcome.INPUT_ERROR)
    verdicts = [foregone, Verdict(planner=PlannerOutcome.NOT_RUN)]
    rates = summarise(verdicts, "virtualhome", Ability.TRANSITION_MODELING, Protocol.STRICT)
    assert rates["overall.planner_success"].percent is None


@pytest.mark.parametrize("ability", list(Ability))
@pytest.mark.parametrize("protocol", list(Protocol))
def test_a_run_without_scored_answers_has_all_metrics_without_a_value(
    ability: Ability, protocol: Protocol
) -> None:
    rates = summarise([Verdict(excluded="for a reason")], "virtualhome", ability, protocol)
    assert rates.keys() == contribution(Verdict(), "virtualhome", ability, protocol).keys()
    assert all(rate.denominator == 0 for rate in rates.values())
