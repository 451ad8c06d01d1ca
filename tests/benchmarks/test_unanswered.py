"""A task without an answer fails in every suite and under every protocol."""

from __future__ import annotations

import pytest

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import RAISED, ConfusionCounts
from eai.agents.setting import ACTING
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.results.rate import Rate
from eai.results.summary import compute_metric_rates
from eai.tasks.source import Source
from protocols import EACH_PROTOCOL, PROTOCOLS

SUITES = [(d, a, p) for d in ("virtualhome", "behavior") for a in PAPER_ABILITIES for p in PROTOCOLS]
COUNTED_TASKS = {
    ("virtualhome", Ability.ACTION_SEQUENCING): 337,
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION): 337,
}
"""Number of tasks that count under `strict`, if some do not."""

_EXPECTED_LITERALS = {"precondition": ConfusionCounts(0, 0, 19), "effect": ConfusionCounts(0, 0, 19)}
"""Counts of the gold literals of the first BEHAVIOR task."""


@pytest.mark.parametrize(("domain", "ability", "protocol"), SUITES, ids=str)
def test_a_task_without_an_answer_fails_without_an_error(
    data_store: DataPackStore, domain: str, ability: Ability, protocol: Protocol
) -> None:
    suite = open_suite(domain, ability, protocol, source=Source(data_store, planner=PlannerChoice.NONE))
    verdicts = [suite.score_missing_answer(task_id) for task_id in suite.task_ids]
    counted = [verdict for verdict in verdicts if verdict.excluded is None]
    if protocol is Protocol.STRICT:
        assert len(counted) == COUNTED_TASKS.get((domain, ability), len(suite.task_ids))
    assert not any(verdict.error or verdict.repairs for verdict in counted)
    declared, rates = get_declaration(ability), compute_metric_rates(verdicts, ability)
    for column in declared.columns:
        assert not rates[column.metric].numerator, column.metric
    for metric in declared.yes_no_metrics - {"overall.planner_success", "overall.plan_works"}:
        assert rates[metric] == Rate(0, len(counted))
    main = next(iter(declared.overview_headings))
    without_goals = sum(not declared.contributions(verdict)[main].denominator for verdict in counted)
    assert without_goals == (4 if (domain, ability) == ("virtualhome", Ability.GOAL_INTERPRETATION) else 0)


@EACH_PROTOCOL
def test_a_task_of_operators_without_an_answer_is_not_solved(
    data_store: DataPackStore, protocol: Protocol
) -> None:
    """The reference fills gaps with gold operators, so a readable empty answer would solve all problems."""
    source = Source(data_store, planner=PlannerChoice.BUILT_IN)
    suite = open_suite("behavior", Ability.TRANSITION_MODELING, protocol, source=source)
    verdict = suite.score_missing_answer(suite.task_ids[0])
    assert isinstance(verdict, OperatorVerdict)
    assert (verdict.success, verdict.planner) == (False, PlannerOutcome.INPUT_ERROR)
    assert verdict.literals == (_EXPECTED_LITERALS if protocol is Protocol.STRICT else None)


ODD_TEXTS = (
    *("", "NaN", "1e400", "-1e400", "9" * 5000, "[1e308]", '{"a": 1e400}', "\ud800", "\x00", '"x', "DONE"),
    *("[" * 5000, "{" * 5000, "(" * 5000, "x" * 20_000, '{"turns": [{"said": "DONE"}], "opening": "0"}'),
    *(
        '{"output": NaN}',
        '{"output": []}',
        "[null]",
        "null",
        '[["ON", 1e400]]',
        '[{"action": 1, "object": 1e308}]',
    ),
)
"""Meaningless texts, and numbers that programs cannot represent."""


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
@pytest.mark.parametrize("ability", [*PAPER_ABILITIES, ACTING], ids=str)
def test_no_text_changes_a_denominator_or_makes_a_scorer_raise(
    data_store: DataPackStore, domain: str, ability: Ability
) -> None:
    suite = open_suite(domain, ability, source=Source(data_store, planner=PlannerChoice.NONE))
    declared = get_declaration(ability)
    for task_id in suite.task_ids[::40]:
        nothing = declared.contributions(suite.score_missing_answer(task_id))
        for text in ODD_TEXTS:
            verdict = suite.score(task_id, text)
            assert verdict.error is None or verdict.error.check != RAISED, text[:40]
            assert verdict.excluded == suite.scorer(task_id).find_exclusion(), text[:40]
            if verdict.excluded is None:
                contributions = declared.contributions(verdict)
                for metric in declared.overview_headings:
                    assert contributions[metric].denominator >= nothing[metric].denominator, (
                        metric,
                        text[:40],
                    )
