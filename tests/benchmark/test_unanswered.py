"""A task without an answer fails in every suite and under every protocol, whatever an empty answer does."""

from __future__ import annotations

import pytest

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import FOUR, Ability, Protocol
from eai.abilities.transition_modeling.declaration import OperatorVerdict
from eai.abilities.verdict import Confusion
from eai.benchmark.suite import open_suite
from eai.data.store import Store
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.results.rate import Rate
from eai.results.summary import summarise
from eai.tasks.source import Source

SUITES = [(d, a, p) for d in ("virtualhome", "behavior") for a in FOUR for p in Protocol.known()]
IN_STATISTICS = {
    ("virtualhome", Ability.ACTION_SEQUENCING, Protocol.STRICT): 337,
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION, Protocol.STRICT): 337,
    ("virtualhome", Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5")): 305,
}
"""How many tasks count, where they are not all tasks."""

_LITERALS = {"precondition": Confusion(0, 0, 19), "effect": Confusion(0, 0, 19)}
"""How many gold literals the first BEHAVIOR task has."""


@pytest.mark.parametrize(("domain", "ability", "protocol"), SUITES, ids=str)
def test_nothing_is_reached_and_no_error_is_blamed(
    data_store: Store, domain: str, ability: Ability, protocol: Protocol
) -> None:
    suite = open_suite(domain, ability, protocol, source=Source(data_store, planner=PlannerChoice.NONE))
    verdicts = [suite.unanswered(task_id) for task_id in suite.task_ids]
    counted = [verdict for verdict in verdicts if verdict.excluded is None]
    assert len(counted) == IN_STATISTICS.get((domain, ability, protocol), len(suite.task_ids))
    assert not any(verdict.error or verdict.repairs for verdict in counted)
    declared, rates = declaration_of(ability), summarise(verdicts, ability)
    for column in declared.columns:
        assert not rates[column.metric].numerator, column.metric
    for metric in declared.yes_no - {"overall.planner_success", "overall.plan_works"}:
        assert rates[metric] == Rate(0, len(counted))
    main = next(iter(declared.main))
    without_goals = sum(not declared.contributions(verdict)[main].denominator for verdict in counted)
    assert without_goals == (4 if (domain, ability) == ("virtualhome", Ability.GOAL_INTERPRETATION) else 0)


@pytest.mark.parametrize("protocol", list(Protocol.known()))
def test_gold_operators_do_not_solve_a_task_without_an_answer(data_store: Store, protocol: Protocol) -> None:
    """The reference fills in what an answer lacks; an empty answer that it can read solves every problem."""
    source = Source(data_store, planner=PlannerChoice.BUILT_IN)
    suite = open_suite("behavior", Ability.TRANSITION_MODELING, protocol, source=source)
    verdict = suite.unanswered(suite.task_ids[0])
    assert isinstance(verdict, OperatorVerdict)
    assert (verdict.success, verdict.planner) == (False, PlannerOutcome.INPUT_ERROR)
    assert verdict.literals == (_LITERALS if protocol is Protocol.STRICT else None)
