"""Every counter and every planner outcome of the reference, row by row, under eai-1.0.5."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from typing import Any

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.abilities.transition_modeling.verdict import OperatorStatus, OperatorVerdict
from eai.abilities.verdict import Confusion, Verdict
from eai.base.errors import DataError
from eai.base.store import Store
from eai.benchmarks.published import TransitionTasks, open_behavior, open_virtualhome
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.matching import SideMatch
from eai.pddl.planners import make_planner
from eai.pddl.planning import PddlPlanner, PlannerChoice, PlannerOutcome
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import Source, TaskSet
from operator_rules import gold_answer, rules_of
from oracle import MODELS, Oracle
from sweeps import first_of


@pytest.fixture(scope="module")
def virtualhome(data_store: Store) -> TransitionTasks:
    return open_virtualhome(Source(data_store))


@pytest.fixture(scope="module")
def behavior(data_store: Store) -> TaskSet[TransitionTask]:
    return find_benchmark("behavior").operators(Source(data_store))


@pytest.fixture(scope="module")
def behavior_as_published(data_store: Store) -> TransitionTasks:
    return open_behavior(Source(data_store))


def planner() -> PddlPlanner:
    try:
        found = make_planner(PlannerChoice.FULL, 100)
    except DataError as error:
        pytest.skip(str(error))
    assert found is not None
    return found


def expected(row: Mapping[str, Any], side: str) -> dict[str, list[int]]:
    counts = row[f"{side}_predicate_type_res"]
    return {name.replace("-", "_"): values for name, values in counts.items() if any(values)}


def counted(verdict: Verdict, side: str) -> dict[str, list[int]]:
    counts = (verdict.counts or {}).get(side, {})
    assert not isinstance(counts, Confusion)
    return {name: list(confusion) for name, confusion in counts.items()}


def assert_equal(row: Mapping[str, Any], verdict: Verdict, known: Collection[str], place: str) -> None:
    if row.get("format_wrong") or row.get("format_wrong_num"):
        assert verdict.excluded, place
        return
    for ours, theirs in (("precondition", "precond"), ("effect", "effect")):
        assert counted(verdict, ours) == expected(row, theirs), f"{place} {ours}"
    assert isinstance(verdict, OperatorVerdict), place
    operators = verdict.operators
    assert len(operators) == row["total_predict_action_num"], place
    hallucinated = [each for each in operators if each.status is OperatorStatus.HALLUCINATED]
    assert len(hallucinated) == row["hallucination_num"], place
    for part, key in (("precondition", "precond_action_type"), ("effect", "effect_action_type")):
        found = {each.name: _sizes(getattr(each, part), known) for each in operators}
        reference = {name: values for name, values in row[key].items() if any(values)}
        assert {name: sizes for name, sizes in found.items() if any(sizes)} == reference, f"{place} {part}"


def _sizes(side: SideMatch, known: Collection[str]) -> list[int]:
    """Matched, additional and missing predicates; the reference does not count those without a category."""
    return [sum(name in known for name in names) for names in (side.matched, side.additional, side.missing)]


@pytest.mark.parametrize("name", [*first_of(MODELS), "gold", "perturbed"])
def test_virtualhome_counters_and_planner(virtualhome: TransitionTasks, oracle: Oracle, name: str) -> None:
    rows = oracle("virtualhome", "transition_modeling", name)["tasks"]
    rules = rules_of(Protocol("eai-1.0.5"), planner())
    for row in rows:
        task = virtualhome[row["id"].split("@")[0]]
        verdict = TransitionModeling(task, rules).score(row["llm_output"])
        assert_equal(row, verdict, task.domain.categories, row["id"])
        if row.get("planner"):
            assert verdict.success is row["planner"]["success"], row["id"]


@pytest.mark.parametrize("name", [*MODELS, "gt", "perturb_logic_only"])
def test_behavior_counters(behavior_as_published: TransitionTasks, oracle: Oracle, name: str) -> None:
    rows = oracle("behavior", "transition_modeling", name)["records"]
    rules = rules_of(Protocol("eai-1.0.5"), None)
    for row in rows:
        task = behavior_as_published[row["identifier"].split("@")[0]]
        verdict = TransitionModeling(task, rules).score(row["response"])
        assert verdict.planner is PlannerOutcome.NOT_RUN
        assert_equal(row["verdict"], verdict, task.domain.categories, row["identifier"])


@pytest.mark.parametrize(("name", "solved"), [("gpt-4o-2024-05-13.fd26.6", 50)])
def test_strict_refuses_undefined_names_as_the_current_translator(
    virtualhome: TransitionTasks, oracle: Oracle, name: str, solved: int
) -> None:
    rows = oracle("virtualhome", "transition_modeling", name)["tasks"]
    rules = rules_of(Protocol.STRICT, planner())
    outcomes: Counter[bool] = Counter()
    for row in rows:
        scorer = TransitionModeling(virtualhome[row["id"]], rules)
        verdict = scorer.score(row["llm_output"])
        found = verdict.planner is PlannerOutcome.SOLVED
        assert found is row["planner"]["success"], row["id"]
        outcomes[found] += 1
    assert outcomes[True] == solved


@pytest.mark.parametrize(
    ("protocol", "status"),
    [(Protocol.STRICT, OperatorStatus.COMPARED), (Protocol("eai-1.0.5"), OperatorStatus.HALLUCINATED)],
)
def test_an_operator_has_the_name_that_was_asked_for(
    oracle: Oracle, data_store: Store, protocol: Protocol, status: OperatorStatus
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


@pytest.mark.parametrize("protocol", list(Protocol.known()))
@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_gold_answers_are_right_in_every_respect(
    virtualhome: TransitionTasks, behavior: TaskSet[TransitionTask], domain: str, protocol: Protocol
) -> None:
    tasks = virtualhome if domain == "virtualhome" else behavior
    rules = rules_of(protocol, planner())
    for task in tasks.values():
        verdict = TransitionModeling(task, rules).score(gold_answer(task))
        assert verdict.planner is PlannerOutcome.SOLVED, task.id
        assert verdict.plan_works is (True if protocol is Protocol.STRICT else None)
        assert verdict.repairs == ()
        for side in (verdict.counts or {}).values():
            assert not isinstance(side, Confusion)
            assert all(c.false_positives == c.false_negatives == 0 for c in side.values()), task.id
