from __future__ import annotations

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.extensions.reference.operator_rules import EaiEvalOperatorScoringRules
from eai.pddl.planning import PlannerChoice
from eai.results.rate import compute_rate
from eai.studies.sensitivity.study import (
    OperatorReplacementTrial,
    group_successes_by_operator_and_category,
    replace_gold_operators_one_by_one,
)
from eai.tasks.source import Source
from oracle import Oracle, read_shared
from results.verdicts import record
from studies.sensitivity.test_sensitivity import (
    ANSWERS,
    MakeRules,
    test_a_missing_answer_has_no_operator,
    test_one_side_of_an_operator_is_tried_with_the_gold_parameters_and_other_side,
    tried,
)
from sweeps import sweep

SHARED = (
    test_a_missing_answer_has_no_operator,
    test_one_side_of_an_operator_is_tried_with_the_gold_parameters_and_other_side,
)
"""Tests of `strict` that are run again with the fixture `rules_with` below."""


@pytest.fixture
def rules_with() -> MakeRules:
    return EaiEvalOperatorScoringRules


@pytest.mark.parametrize(("text", "strict"), ANSWERS)
def test_each_operator_is_tried_alone_among_gold_ones(text: str, strict: dict[str, str]) -> None:
    found = tried(text, EaiEvalOperatorScoringRules)
    assert {each.operator: each.outcome for each in found} == ({} if text == "3" else strict)


@sweep
def test_gpt_4o_on_virtualhome_is_as_sensitive_as_the_paper_says(
    oracle: Oracle, data_store: DataPackStore
) -> None:
    """The figures that the paper prints for the model, each as it comes out of its public answers."""
    rows = oracle("virtualhome", "transition_modeling", "gpt-4o-2024-05-13")["tasks"]
    source = Source(data_store, planner=PlannerChoice.BUILT_IN)
    suite = open_suite("virtualhome", Ability.TRANSITION_MODELING, Protocol("eai-1.0.5"), source=source)
    trials: list[OperatorReplacementTrial] = []
    for row in rows:
        scorer = suite.scorer(row["id"])
        assert isinstance(scorer, TransitionModelingScorer)
        made = record(
            row["id"],
            scorer.score_missing_answer(),
            ability=suite.ability,
            protocol=suite.protocol,
            response=row["llm_output"],
        )
        trials += replace_gold_operators_one_by_one(scorer, made)
    cells = group_successes_by_operator_and_category(trials)
    for category, figures in read_shared("paper", "sensitivity.json")["virtualhome_measured_gpt4o"].items():
        for operator, figure in figures.items():
            rate = compute_rate(case.share for case in cells[operator, category])
            assert f"{rate.numerator:g}/{rate.denominator:g}" == figure, (category, operator)
