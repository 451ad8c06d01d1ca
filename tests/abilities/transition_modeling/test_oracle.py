"""Scores of operators that models wrote, and of the data set's own operators."""

from __future__ import annotations

from collections import Counter

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.transition_modeling.rules import OperatorScoringRules, PaperOperatorScoringRules
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorComparisonStatus, OperatorVerdict
from eai.abilities.verdict import ConfusionCounts
from eai.base.errors import DataError
from eai.base.store import DataPackStore
from eai.benchmarks.published import TransitionTasks, open_virtualhome_transition_tasks
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.planners import make_planner
from eai.pddl.planning import PddlPlanner, PlannerChoice, PlannerOutcome
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import Source, TaskSet
from operator_rules import gold_answer
from oracle import Oracle


@pytest.fixture(scope="module")
def virtualhome(data_store: DataPackStore) -> TransitionTasks:
    return open_virtualhome_transition_tasks(Source(data_store))


@pytest.fixture(scope="module")
def behavior(data_store: DataPackStore) -> TaskSet[TransitionTask]:
    return find_benchmark("behavior").operator_tasks(Source(data_store))


def planner() -> PddlPlanner:
    try:
        found = make_planner(PlannerChoice.FULL, 100)
    except DataError as error:
        pytest.skip(str(error))
    assert found is not None
    return found


@pytest.mark.parametrize(("name", "solved"), [("gpt-4o-2024-05-13.fd26.6", 50)])
def test_strict_refuses_undefined_names_as_the_current_translator(
    virtualhome: TransitionTasks, oracle: Oracle, name: str, solved: int
) -> None:
    rows = oracle("virtualhome", "transition_modeling", name)["tasks"]
    rules = PaperOperatorScoringRules(planner())
    outcomes: Counter[bool] = Counter()
    for row in rows:
        scorer = TransitionModelingScorer(virtualhome[row["id"]], rules)
        verdict = scorer.score(row["llm_output"])
        found = verdict.planner is PlannerOutcome.SOLVED
        assert found is row["planner"]["success"], row["id"]
        outcomes[found] += 1
    assert outcomes[True] == solved


@pytest.fixture
def protocol() -> Protocol:
    """Return the protocol `strict`. Tests of other protocols replace this fixture."""
    return Protocol.STRICT


@pytest.fixture
def status() -> OperatorComparisonStatus:
    """Return the status of an operator whose name has a hyphen in the data set."""
    return OperatorComparisonStatus.COMPARED


def test_an_operator_has_the_name_that_was_asked_for(
    oracle: Oracle, data_store: DataPackStore, protocol: Protocol, status: OperatorComparisonStatus
) -> None:
    """The data set calls an operator ``slice-carvingknife``; prompts and answers have an underscore."""
    rows = oracle("behavior", "transition_modeling", "gpt-4o-2024-05-13")["records"]
    source = Source(data_store, planner=PlannerChoice.NONE)
    suite = open_suite("behavior", Ability.TRANSITION_MODELING, protocol, source=source)
    written = [row for row in rows if "slice_carvingknife" in row["response"]]
    found = []
    for row in written:
        verdict = suite.score(row["identifier"], row["response"])
        assert isinstance(verdict, OperatorVerdict)
        found += [each.status for each in verdict.operators if each.name == "slice_carvingknife"]
    assert found == [status] * 3


@pytest.fixture
def rules() -> OperatorScoringRules:
    return PaperOperatorScoringRules(planner())


@pytest.fixture
def plan_works() -> bool | None:
    """Return by task whether the plan for the gold answer works."""
    return True


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_gold_answers_are_right_in_every_respect(
    virtualhome: TransitionTasks,
    behavior: TaskSet[TransitionTask],
    domain: str,
    rules: OperatorScoringRules,
    plan_works: bool | None,
) -> None:
    tasks = virtualhome if domain == "virtualhome" else behavior
    for task in tasks.values():
        verdict = TransitionModelingScorer(task, rules).score(gold_answer(task))
        assert verdict.planner is PlannerOutcome.SOLVED, task.id
        assert verdict.plan_works is plan_works
        assert verdict.repairs == ()
        for side in (verdict.counts or {}).values():
            assert not isinstance(side, ConfusionCounts)
            assert all(c.false_positives == c.false_negatives == 0 for c in side.values()), task.id
