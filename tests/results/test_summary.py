from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.declaration import get_declaration, load_declarations_of_paper_abilities
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.task_features import TaskFeatures
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import ConfusionCounts, ErrorReport, SummaryCounts
from eai.pddl.planning import PlannerOutcome
from eai.results.certainty import TaskRateContribution
from eai.results.rate import Rate
from eai.results.summary import compute_metric_rates, make_contributions_by_metric
from eai.tasks.share import Share, TalliesByGoalKind
from eai.world.fault import FaultKind
from results.verdicts import SUCCEEDED, failed, goals, record

ARITY = ErrorReport(FaultKind.ARGUMENT_NUMBER, None, "OPEN takes 1 argument")


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_every_column_that_is_shown_is_a_metric(ability: Ability) -> None:
    declared = get_declaration(ability)
    rates = compute_metric_rates([declared.verdict()], ability)
    shown = {column.metric for column in declared.columns}
    assert {
        *declared.terminal_metrics,
        *declared.overview_headings,
        *declared.averaged_metrics,
        *declared.yes_no_metrics,
    } <= rates.keys()
    assert shown <= rates.keys()
    assert {*declared.terminal_metrics, *declared.overview_headings} <= shown


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_lower_is_better_only_for_errors_and_granularity(ability: Ability) -> None:
    fewer = {kind.value for kind in FaultKind} | {"ill_formed", "granularity"}
    for column in get_declaration(ability).columns:
        assert column.more_is_better is (column.metric not in fewer), column.metric


def test_every_ability_is_declared() -> None:
    assert tuple(load_declarations_of_paper_abilities()) == PAPER_ABILITIES
    assert all(
        declared.ability is ability for ability, declared in load_declarations_of_paper_abilities().items()
    )


def test_excluded_answers_are_in_no_denominator() -> None:
    verdicts = [SUCCEEDED, replace(SUCCEEDED, excluded="why")]
    assert compute_metric_rates(verdicts, Ability.ACTION_SEQUENCING)["task_success"] == Rate(1, 1)


def test_plans_are_counted_by_the_error_that_ended_them() -> None:
    verdicts = [SUCCEEDED, failed(FaultKind.MISSING_STEP), failed(FaultKind.PARSING)]
    rates = compute_metric_rates(verdicts, Ability.ACTION_SEQUENCING)
    assert rates["task_success"] == Rate(1, 3)
    assert rates["missing_step"] == rates["parsing"] == Rate(1, 3)
    assert rates["wrong_order"] == Rate(0, 3)
    assert rates["state_goal"] == rates["total_goal"] == Rate(1, 3)


def test_additional_steps_count_by_answer_unless_the_verdict_says_otherwise() -> None:
    three = replace(SUCCEEDED, additional_steps=3)
    assert compute_metric_rates([three, SUCCEEDED], Ability.ACTION_SEQUENCING)["additional_step"] == Rate(
        1, 2
    )
    by_step = replace(three, counted=SummaryCounts(True, goals((1, 1)), {FaultKind.ADDITIONAL_STEP: 3}))
    assert compute_metric_rates([by_step, SUCCEEDED], Ability.ACTION_SEQUENCING)["additional_step"] == Rate(
        3, 2
    )


def test_counts_for_the_summary_override_the_verdict() -> None:
    failure = failed(FaultKind.PARSING)
    twice = replace(failure, counted=SummaryCounts(False, goals((0, 1)), {FaultKind.PARSING: 2}))
    missed = SummaryCounts(False, TalliesByGoalKind(Share(0, 0), Share(0, 0), Share(1, 2)), {})
    rates = compute_metric_rates([twice, replace(SUCCEEDED, counted=missed)], Ability.ACTION_SEQUENCING)
    assert rates["parsing"] == Rate(2, 2)
    assert rates["task_success"] == Rate(0, 2)
    assert rates["execution_success"] == Rate(1, 2)
    assert rates["action_goal"] == Rate(1, 2)


def test_predicted_goals_are_counted_by_kind() -> None:
    read = GoalVerdict(
        counts={"state": ConfusionCounts(2, 1, 0), "action": ConfusionCounts(0, 0, 1)},
        predicted=4,
        ill_formed=1,
        hallucinated=("sofaa", "x"),
    )
    unread = GoalVerdict(
        counts={"state": ConfusionCounts(0, 0, 2)}, error=ErrorReport(FaultKind.PARSING, None, "no JSON")
    )
    rates = compute_metric_rates([read, unread], Ability.GOAL_INTERPRETATION)
    assert rates["state.recall"] == Rate(2, 4)
    assert rates["overall.precision"] == Rate(2, 3)
    assert rates["overall.f1"] == Rate(4, 8)
    assert rates["relation.f1"].percent is None
    assert rates["parsing"] == Rate(1, 2)
    assert (rates["ill_formed"], rates["hallucination"]) == (Rate(1, 4), Rate(2, 4))


def test_goals_without_a_kind_count_only_overall() -> None:
    verdict = GoalVerdict(counts={"state": ConfusionCounts(1, 0, 0), "all": ConfusionCounts(1, 2, 0)})
    rates = compute_metric_rates([verdict], Ability.GOAL_INTERPRETATION)
    assert rates["overall.precision"] == Rate(1, 3)


def test_subgoals_are_counted_by_outcome() -> None:
    correct = SubgoalVerdict(category=SubgoalAnswerCategory.CORRECT, additional_steps=2, goals=goals((1, 1)))
    arity = SubgoalVerdict(category=SubgoalAnswerCategory.HALLUCINATION, error=ARITY)
    unknown = SubgoalVerdict(
        category=SubgoalAnswerCategory.HALLUCINATION, error=ErrorReport(FaultKind.HALLUCINATION, None, "x")
    )
    unreadable = SubgoalVerdict(category=SubgoalAnswerCategory.NOT_PARSEABLE)
    verdicts = [correct, arity, unknown, unreadable]
    rates = compute_metric_rates(verdicts, Ability.SUBGOAL_DECOMPOSITION)
    for name in ("task_success", "execution_success", "parsing", "argument_number", "hallucination"):
        assert rates[name] == Rate(1, 4), name
    assert rates["additional_step"] == Rate(1, 4)


def test_errors_of_subgoals_count_as_often_as_the_verdict_says() -> None:
    wrong_order = ErrorReport(FaultKind.WRONG_ORDER, 0, "why")
    runtime = SubgoalVerdict(category=SubgoalAnswerCategory.RUNTIME, error=wrong_order, additional_steps=1)
    missed = replace(runtime, category=SubgoalAnswerCategory.GOAL_UNREACHABLE)
    none = goals((0, 1))
    entries = replace(runtime, counted=SummaryCounts(False, none, {FaultKind.WRONG_ORDER: 2}))
    for verdicts, counted, additional in (
        ([runtime, missed], 2, 2),
        ([entries, missed], 3, 1),
        ([entries, replace(missed, counted=SummaryCounts(False, none, {}))], 2, 0),
    ):
        rates = compute_metric_rates(verdicts, Ability.SUBGOAL_DECOMPOSITION)
        assert rates["wrong_order"] == Rate(counted, 2)
        assert rates["additional_step"] == Rate(additional, 2)
        assert rates["execution_success"] == Rate(1, 2)


def test_operators_count_by_category_and_plans_by_task() -> None:
    solved = OperatorVerdict(
        counts={
            "precondition": {"object_states": ConfusionCounts(1, 0, 1)},
            "effect": {"object_states": ConfusionCounts(1, 2, 0), "object_tools": ConfusionCounts(3, 0, 0)},
        },
        planner=PlannerOutcome.SOLVED,
        task_categories=("object_states", "spatial_relations"),
    )
    unsolved = replace(solved, planner=PlannerOutcome.TIME, counts=None, task_categories=())
    rates = compute_metric_rates([solved, unsolved], Ability.TRANSITION_MODELING)
    assert rates["object_states.f1"] == Rate(4, 7)
    assert rates["overall.precision"] == Rate(5, 7)
    assert rates["overall.planner_success"] == Rate(1, 2)
    assert rates["spatial_relations.planner_success"] == Rate(1, 1)
    assert rates["object_affordance.planner_success"].percent is None


def test_clauses_of_several_categories_count_once_and_literals_apart() -> None:
    side = {
        "all": ConfusionCounts(1, 1, 2),
        "object_states": ConfusionCounts(1, 0, 1),
        "other": ConfusionCounts(1, 1, 1),
    }
    verdict = OperatorVerdict(counts={"effect": side}, literals={"effect": ConfusionCounts(4, 1, 3)})
    rates = compute_metric_rates([verdict], Ability.TRANSITION_MODELING)
    assert rates["overall.f1"] == Rate(2, 5)
    assert rates["object_states.f1"] == Rate(2, 3)
    assert rates["literals.f1"] == Rate(8, 12)
    assert rates["literals.recall"] == Rate(4, 7)
    without = compute_metric_rates([replace(verdict, literals=None)], Ability.TRANSITION_MODELING)
    assert without["literals.f1"].percent is None


def test_without_a_planner_there_is_no_planner_success() -> None:
    foregone = OperatorVerdict(planner=PlannerOutcome.INPUT_ERROR)
    verdicts = [foregone, OperatorVerdict(planner=PlannerOutcome.NOT_RUN)]
    rates = compute_metric_rates(verdicts, Ability.TRANSITION_MODELING)
    assert rates["overall.planner_success"].percent is None


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_a_run_without_scored_answers_has_all_metrics_without_a_value(ability: Ability) -> None:
    declared = get_declaration(ability)
    rates = compute_metric_rates([declared.verdict(excluded="for a reason")], ability)
    assert rates.keys() == declared.contributions(declared.verdict()).keys()
    assert all(rate.denominator == 0 for rate in rates.values())


def test_cases_of_scored_records_have_the_names_of_their_tasks() -> None:
    named = replace(record("a_1", SUCCEEDED), task=TaskFeatures("a", 4, 1))
    records = [named, record("b", replace(SUCCEEDED, excluded="why")), record("c", failed(FaultKind.PARSING))]
    cases = make_contributions_by_metric(records, Ability.ACTION_SEQUENCING)
    assert cases.keys() == compute_metric_rates([], Ability.ACTION_SEQUENCING).keys()
    assert cases["task_success"] == [
        TaskRateContribution("a_1", "a", Share(1, 1)),
        TaskRateContribution("c", "c", Share(0, 1)),
    ]
