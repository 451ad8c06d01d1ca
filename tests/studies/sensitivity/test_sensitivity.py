from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.rules import (
    OperatorScoringRules,
    PaperOperatorScoringRules,
    ReplacedPart,
)
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.pddl.model import OperatorText
from eai.pddl.planning import PddlPlanner, PlannerOutcome
from eai.pddl.reader import read_domain
from eai.pddl.search import BuiltInPlanner
from eai.results.record import Record
from eai.studies.sensitivity.study import (
    NOT_WRITTEN,
    OperatorReplacementTrial,
    make_operator_sensitivity_tables,
    replace_gold_operators_one_by_one,
)
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.task import PredicateCategory
from results.verdicts import record

OPEN = OperatorText("open", "(?o)", "(shut ?o)", "(wide ?o)")
LIGHT = OperatorText("light", "(?o)", "(wide ?o)", "(lit ?o)")
BROKEN = OperatorText("open", "(?o)", "(lit ?o)", "(wide ?o)")
DOMAIN = OperatorLibrary(
    read_domain("(define (domain d) (:predicates (shut ?o) (wide ?o) (lit ?o)))"),
    {"open": OPEN, "light": LIGHT},
    dict.fromkeys(("shut", "wide", "lit"), PredicateCategory.OBJECT_STATES),
)
CATEGORIES = (PredicateCategory.OBJECT_STATES, PredicateCategory.SPATIAL_RELATIONS)
PROBLEM = "(define (problem p) (:domain d) (:objects box) (:init (shut box)) (:goal (lit box)))"
TASK = TransitionTask("t", DOMAIN, ("open", "light"), CATEGORIES, PROBLEM)
S, U, X = (o.value for o in (PlannerOutcome.SOLVED, PlannerOutcome.UNSOLVABLE, PlannerOutcome.INPUT_ERROR))


def answer(*operators: OperatorText) -> str:
    return json.dumps({"output": "\n".join(operator.write_pddl for operator in operators)})


MakeRules: TypeAlias = Callable[[PddlPlanner | None], OperatorScoringRules]


@pytest.fixture
def rules_with() -> MakeRules:
    """Makes the rules of `strict`; tests of other protocols have a fixture of this name, too."""
    return PaperOperatorScoringRules


def tried(
    text: str, rules_with: MakeRules, replaced: ReplacedPart = "operator"
) -> list[OperatorReplacementTrial]:
    scorer = TransitionModelingScorer(TASK, rules_with(BuiltInPlanner()))
    return list(replace_gold_operators_one_by_one(scorer, scored(scorer, text), replaced))


def scored(scorer: TransitionModelingScorer, text: str) -> Record:
    return record("t", scorer.score(text), ability=Ability.TRANSITION_MODELING, response=text)


ANSWERS = [
    (answer(OPEN, LIGHT), {"open": S, "light": S}),
    (answer(BROKEN, LIGHT), {"open": U, "light": S}),
    (answer(LIGHT), {"open": NOT_WRITTEN, "light": S}),
    (answer(OperatorText("open", "()", "(dark)", "()"), LIGHT), {"open": X, "light": S}),
    ("no operators", dict.fromkeys(("open", "light"), NOT_WRITTEN)),
    ("3", dict.fromkeys(("open", "light"), NOT_WRITTEN)),
]


@pytest.mark.parametrize(("text", "outcomes"), ANSWERS)
def test_each_operator_is_tried_alone_among_gold_operators(text: str, outcomes: dict[str, str]) -> None:
    found = tried(text, PaperOperatorScoringRules)
    assert {each.operator: each.outcome for each in found} == outcomes
    assert all(each.categories == "object_states spatial_relations" for each in found)


NO_EFFECT = OperatorText("open", "(?o)", "(shut ?o)", "(shut ?o)")
OTHER_NAMES = OperatorText("open", "(?x)", "(shut ?x)", "(wide ?x)")


@pytest.mark.parametrize(
    ("written", "precondition", "effect"),
    [(OPEN, True, True), (BROKEN, False, True), (NO_EFFECT, True, False), (OTHER_NAMES, False, False)],
)
def test_one_side_of_an_operator_is_tried_with_the_gold_parameters_and_other_side(
    rules_with: MakeRules, written: OperatorText, precondition: bool, effect: bool
) -> None:
    parts: tuple[tuple[ReplacedPart, bool], ...] = (("precondition", precondition), ("effect", effect))
    for replaced, expected in parts:
        found = tried(answer(written, LIGHT), rules_with, replaced)
        assert {each.operator: each.outcome == S for each in found} == {"open": expected, "light": True}


def test_a_trial_records_the_errors_of_the_replaced_part() -> None:
    both = OperatorText("open", "(?o)", "(lit ?o)", "(and (wide ?o) (lit ?o))")
    wrong = ("precondition:missing:shut", "precondition:additional:lit", "effect:additional:lit")
    parts: dict[ReplacedPart, tuple[str, ...]] = {
        "operator": wrong,
        "precondition": wrong[:2],
        "effect": wrong[2:],
    }
    for replaced, expected in parts.items():
        first, second = tried(answer(both, LIGHT), PaperOperatorScoringRules, replaced)
        assert (first.errors, second.errors) == (" ".join(expected), "")


def test_a_missing_answer_has_no_operator(rules_with: MakeRules) -> None:
    scorer = TransitionModelingScorer(TASK, rules_with(BuiltInPlanner()))
    missing = replace(scored(scorer, "3"), unanswered="timeout")
    assert [trial.outcome for trial in replace_gold_operators_one_by_one(scorer, missing)] == [
        NOT_WRITTEN,
        NOT_WRITTEN,
    ]


def trial(
    task: str, operator: str, categories: str, outcome: str, errors: str = "", model: str = "m"
) -> OperatorReplacementTrial:
    return OperatorReplacementTrial(
        protocol="strict",
        domain="d",
        ability="transition_modeling",
        model=model,
        task=task,
        name=task,
        replaced="operator",
        operator=operator,
        outcome=outcome,
        categories=categories,
        errors=errors,
    )


BOTH = "object_states spatial_relations"
TRIALS = [
    trial("1", "open", BOTH, S),
    trial("2", "open", "object_states", U, "precondition:missing:shut effect:additional:lit"),
    trial("4", "open", "", S, "effect:additional:lit"),
    trial("2", "light", "object_states", S),
    trial("3", "light", "", NOT_WRITTEN),
]


def rows_of(name: str, trials: Sequence[OperatorReplacementTrial] = TRIALS) -> list[str]:
    table = next(table for table in make_operator_sensitivity_tables(trials) if table.name == name)
    return [" ".join(map(str, row[3:])) for row in table.rows]


def test_operators_with_the_lowest_success_come_first() -> None:
    assert [row.partition(" [")[0] for row in rows_of("sensitivity")] == [
        "m operator light overall 50 (1/2)",
        "m operator light object_states 100 (1/1)",
        "m operator open overall 66.7 (2/3)",
        "m operator open object_states 50 (1/2)",
        "m operator open spatial_relations 100 (1/1)",
    ]


def test_each_outcome_of_a_planner_is_counted_separately() -> None:
    assert rows_of("outcomes") == ["m operator light 1 0 0 0 0 0 0 1", "m operator open 2 1 0 0 0 0 0 0"]


def test_errors_are_compared_with_the_same_operator_without_them() -> None:
    assert [re.sub(r" \[.*?\]", "", row) for row in rows_of("errors")] == [
        "m operator open effect additional lit 50 (1/2) 0 (0/1)",
        "m operator open precondition missing shut 100 (1/1) 0 (0/2)",
    ]


def test_figures_show_all_models_and_one_model_by_category() -> None:
    other = replace(TRIALS[0], model="n")
    told = [row for row in rows_of("sensitivity", [*TRIALS, other]) if "open overall" in row]
    assert [row.partition(" [")[0] for row in told] == [
        "all models operator open overall 75 (3/4)",
        "m operator open overall 66.7 (2/3)",
        "n operator open overall 100 (1/1)",
    ]
