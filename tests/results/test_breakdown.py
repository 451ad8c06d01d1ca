from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.declaration import AnswerOutcome
from eai.abilities.explanation import (
    GoalReport,
    StepReport,
    VerdictExplanation,
    find_predicate_names,
    parse_statement,
)
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.task_features import TaskFeatures
from eai.abilities.transition_modeling.verdict import (
    OperatorComparisonStatus,
    OperatorReport,
    OperatorVerdict,
    find_predicates_and_their_categories,
)
from eai.abilities.verdict import ConfusionCounts, PlanVerdict
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.pddl.matching import ClauseComparison
from eai.pddl.planning import PlannerOutcome
from eai.results.certainty import TaskRateContribution
from eai.results.rate import Rate, compute_rate
from eai.results.summary import break_down_records, find_answer_outcome
from eai.tasks.share import Share
from eai.world.fault import FaultKind
from oracle import read_oracle
from results.verdicts import SUCCEEDED, failed, record

PLAN = VerdictExplanation(
    steps=(
        StepReport("WALK(bed.1)", "executed", call=parse_statement("WALK(bed.1)")),
        StepReport("GRAB(cup.2)", "missing_step", "why", call=parse_statement("GRAB(cup.2)")),
    ),
    goals=(
        GoalReport("state", "not ON(light.1)", True, predicates=("ON",)),
        GoalReport("state", "forall x: lamp. (ON(x))", False, predicates=("ON",)),
        GoalReport("action", "READ or WATCH", False, predicates=("READ", "WATCH")),
    ),
)


@pytest.mark.parametrize("kind", FaultKind)
def test_every_kind_of_error_is_an_outcome(kind: FaultKind) -> None:
    assert find_answer_outcome(record("1_1", failed(kind))).value == kind.value


def test_verdicts_of_each_ability_have_their_outcomes() -> None:
    actions = Ability.ACTION_SEQUENCING
    goals = Ability.GOAL_INTERPRETATION
    operators = Ability.TRANSITION_MODELING
    some, all_, none = (
        GoalVerdict(counts={"state": ConfusionCounts(*c)}) for c in ((1, 1, 0), (2, 0, 0), (0, 1, 1))
    )
    right = OperatorVerdict(counts={"effect": {"object_states": ConfusionCounts(2, 0, 0)}})
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
        assert find_answer_outcome(record("1_1", verdict, ability=ability)) is expected


def test_a_task_without_an_answer_is_an_outcome_and_in_no_breakdown() -> None:
    features = TaskFeatures("name", annotated_steps=3, goals=1)
    answered = replace(record("2_1", SUCCEEDED), task=features)
    verdict = failed(FaultKind.PARSING).to_verdict_on_missing_answer()
    lacking = replace(record("1_1", verdict), task=features, unanswered="no row")
    found = break_down_records([answered, lacking], Ability.ACTION_SEQUENCING)
    assert found.outcomes == {AnswerOutcome.NOT_ANSWERED: 1, AnswerOutcome.SUCCESS: 1}
    assert found.flow
    assert [*found.flow.values()] == [1] * 6
    assert found.by_goals == {1: [TaskRateContribution("2_1", "name", Share(1, 1))]}


def test_flow_loses_answers_stage_by_stage() -> None:
    kinds = (FaultKind.PARSING, FaultKind.HALLUCINATION, FaultKind.ARGUMENT_NUMBER, FaultKind.AFFORDANCE)
    verdicts = [*map(failed, kinds), PlanVerdict(executable=True, success=False), SUCCEEDED]
    verdicts.append(PlanVerdict(excluded="why"))
    found = break_down_records([record(str(i), v) for i, v in enumerate(verdicts)], Ability.ACTION_SEQUENCING)
    assert found.flow
    assert [*found.flow.values()] == [6, 5, 4, 3, 2, 1]
    assert found.outcomes[AnswerOutcome.EXCLUDED] == 1
    assert break_down_records([], Ability.GOAL_INTERPRETATION).flow is None


def test_success_is_broken_down_by_length_action_and_predicate() -> None:
    explained = replace(record("1", failed(FaultKind.MISSING_STEP)), explanation=PLAN)
    found = break_down_records([explained, replace(explained, task_id="2")], Ability.ACTION_SEQUENCING)
    assert found.by_goals == found.by_length == {}  # what the tasks are like is not known
    assert found.by_action == {"GRAB": Rate(0, 2), "WALK": Rate(2, 2)}
    assert found.by_predicate == {"ON": Rate(2, 4), "READ": Rate(0, 2), "WATCH": Rate(0, 2)}


def test_difficulty_is_measured_by_the_task_and_not_by_the_answer() -> None:
    """A plan that fails at its first step still counts for a task of nine steps."""
    task = TaskFeatures("wash", 9, 2)
    right, wrong = (
        replace(record(name, verdict), explanation=PLAN, task=task)
        for name, verdict in (("1", SUCCEEDED), ("2", failed(FaultKind.MISSING_STEP)))
    )
    unreadable = replace(record("3", failed(FaultKind.PARSING)), task=task)
    without_plan = replace(right, task_id="4", task=TaskFeatures("4", None, 1))
    found = break_down_records([right, wrong, unreadable, without_plan], Ability.ACTION_SEQUENCING)
    assert found.by_length == {
        9: [
            TaskRateContribution("1", "wash", Share(1, 1)),
            TaskRateContribution("2", "wash", Share(0, 1)),
            TaskRateContribution("3", "wash", Share(0, 1)),
        ]
    }
    assert {goals: len(cases) for goals, cases in found.by_goals.items()} == {1: 1, 2: 3}


def test_operators_are_broken_down_by_f1() -> None:
    side = ClauseComparison(
        ("(on ?o)", "(forall (?o - object) (when (on ?o) (on ?o)))"), ("near",), ("(off ?o)",)
    )
    verdict = OperatorVerdict(
        operators=(OperatorReport("open", OperatorComparisonStatus.COMPARED, side),),
        clauses={
            part: find_predicates_and_their_categories(part, {})
            for part in (*side.matched, *side.additional, *side.missing)
        },
    )
    written = record("1", verdict, ability=Ability.TRANSITION_MODELING)
    found = break_down_records([written], Ability.TRANSITION_MODELING)
    assert found.by_action == {"open": Rate(4, 6)}
    assert found.by_predicate == {"near": Rate(0, 1), "off": Rate(0, 1), "on": Rate(4, 4)}


def test_success_by_length_is_the_paper_s_figure(behavior_tasks: BehaviorTasks) -> None:
    """Success of GPT-4o by tens of annotated steps: the paper's figure has 0.7, 0.5, 0.14, 0.17, 0.5 and, at
    60, 0.

    One of the 37 answers that reached its goal in the simulator fails on the reconstructed scenes.
    """
    rows = read_oracle("behavior", "action_sequencing", "gpt-4o-2024-05-13")["records"]
    records = [
        replace(
            record(row["identifier"], SUCCEEDED if row["verdict"]["task_success"] else PlanVerdict()),
            task=TaskFeatures.from_task(behavior_tasks[row["identifier"]]),
        )
        for row in rows
    ]
    tens: dict[int, Rate] = {}
    for length, cases in break_down_records(records, Ability.ACTION_SEQUENCING).by_length.items():
        before, here = tens.get(length // 10, Rate(0, 0)), compute_rate(case.share for case in cases)
        tens[length // 10] = Rate(before.numerator + here.numerator, before.denominator + here.denominator)
    assert tens == {
        0: Rate(27, 39),
        1: Rate(17, 37),
        2: Rate(2, 15),
        3: Rate(1, 6),
        4: Rate(1, 2),
        6: Rate(0, 1),
    }


@pytest.mark.parametrize(
    ("goal", "names"),
    [
        ("exists x: jar.n.01. (inside(peach_0, x) and not inside(plum_0, x))", ("inside",)),
        ("ontop(a, b) or nextto(a, b)", ("ontop", "nextto")),
        ("TOUCH or GRAB", ("TOUCH", "GRAB")),
    ],
)
def test_a_goal_mentions_each_predicate_once(goal: str, names: tuple[str, ...]) -> None:
    assert find_predicate_names(goal) == names


def test_an_additional_step_is_tried_and_not_executed() -> None:
    """The authors' evaluator counts additional steps in this way."""
    steps = (
        StepReport("OPEN(box.1)", "executed", call=parse_statement("OPEN(box.1)")),
        StepReport("OPEN(box.1)", "additional_step", "is open", call=parse_statement("OPEN(box.1)")),
    )
    plan = replace(record("1", SUCCEEDED), explanation=VerdictExplanation(steps=steps))
    assert break_down_records([plan], Ability.ACTION_SEQUENCING).by_action == {"OPEN": Rate(1, 2)}
