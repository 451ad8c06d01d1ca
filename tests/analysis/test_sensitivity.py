from __future__ import annotations

import json
from pathlib import Path

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.abilities.transition_modeling.task import Category, OperatorLibrary, TransitionTask
from eai.analysis.sensitivity import OVERALL, OperatorOutcome, summarise, try_operators
from eai.benchmarks.source import Source
from eai.benchmarks.suite import open_suite
from eai.data.store import Store
from eai.metrics.rate import Rate
from eai.pddl.operator_text import OperatorText
from eai.pddl.planner import BuiltInPlanner
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.pddl.reader import read_domain
from eai.report import plot_sensitivity
from operator_rules import rules_of
from oracle import Oracle, read_shared

OPEN = OperatorText("open", "(?o)", "(shut ?o)", "(wide ?o)")
LIGHT = OperatorText("light", "(?o)", "(wide ?o)", "(lit ?o)")
BROKEN = OperatorText("open", "(?o)", "(lit ?o)", "(wide ?o)")
DOMAIN = OperatorLibrary(
    read_domain("(define (domain d) (:predicates (shut ?o) (wide ?o) (lit ?o)))"),
    {"open": OPEN, "light": LIGHT},
    dict.fromkeys(("shut", "wide", "lit"), Category.OBJECT_STATES),
)
CATEGORIES = (Category.OBJECT_STATES, Category.SPATIAL_RELATIONS)
PROBLEM = "(define (problem p) (:domain d) (:objects box) (:init (shut box)) (:goal (lit box)))"
TASK = TransitionTask("t", DOMAIN, ("open", "light"), CATEGORIES, PROBLEM)
S, U, X = PlannerOutcome.SOLVED, PlannerOutcome.UNSOLVABLE, PlannerOutcome.INPUT_ERROR


def answer(*operators: OperatorText) -> str:
    return json.dumps({"output": "\n".join(operator.pddl for operator in operators)})


@pytest.mark.parametrize(
    ("text", "strict", "reference"),
    [
        (answer(OPEN, LIGHT), {"open": S, "light": S}, {"open": S, "light": S}),
        (answer(BROKEN, LIGHT), {"open": U, "light": S}, {"open": U, "light": S}),
        (answer(LIGHT), {"open": None, "light": S}, {"open": None, "light": S}),
        (
            answer(OperatorText("open", "()", "(dark)", "()"), LIGHT),
            {"open": X, "light": S},
            {"open": X, "light": S},
        ),
        ("no operators", {"open": None, "light": None}, {"open": None, "light": None}),
        ("3", {"open": None, "light": None}, {}),
    ],
)
def test_each_operator_is_tried_alone_among_gold_ones(
    text: str, strict: dict[str, PlannerOutcome | None], reference: dict[str, PlannerOutcome | None]
) -> None:
    for protocol, expected in zip(Protocol, (strict, reference), strict=True):
        found = try_operators(TransitionModeling(TASK, rules_of(protocol, BuiltInPlanner())), text)
        assert {each.operator: each.outcome for each in found} == expected
        assert all(each.categories == CATEGORIES for each in found)


OUTCOMES = [
    OperatorOutcome("1", "open", CATEGORIES, S),
    OperatorOutcome("2", "open", CATEGORIES[:1], U),
    OperatorOutcome("2", "light", CATEGORIES[:1], S),
    OperatorOutcome("3", "light", (), None),
]


def test_gpt_4o_on_virtualhome_is_as_sensitive_as_the_paper_says(oracle: Oracle, data_store: Store) -> None:
    """The figures that the paper prints for the model, each as it comes out of its public answers."""
    rows = oracle("virtualhome", "transition_modeling", "gpt-4o-2024-05-13")["tasks"]
    source = Source(data_store, planner=PlannerChoice.BUILT_IN)
    suite = open_suite("virtualhome", Ability.TRANSITION_MODELING, Protocol.EAI_1_0_5, source=source)
    outcomes = []
    for row in rows:
        scorer = suite.scorer(row["id"])
        assert isinstance(scorer, TransitionModeling)
        outcomes += try_operators(scorer, row["llm_output"])
    result = summarise(
        outcomes, ("grab", "walk_towards", "plug_in", "put_inside", "close", "turn_to", "walk_into")
    )
    for category, figures in read_shared("paper", "sensitivity.json")["virtualhome_measured_gpt4o"].items():
        for operator, figure in figures.items():
            rate = result.rates[category][operator]
            assert f"{rate.numerator:g}/{rate.denominator:g}" == figure, (category, operator)


def test_rates_by_operator_and_category() -> None:
    result = summarise(OUTCOMES, ("light", "open", "never"))
    assert result.operators == ("light", "open")
    assert list(result.rates) == [OVERALL, "object_states", "spatial_relations"]
    assert result.rates[OVERALL] == {"light": Rate(1, 2), "open": Rate(1, 2)}
    assert result.rates["spatial_relations"] == {"open": Rate(1, 1)}
    assert result.to_json()["object_states"]["light"]["value"] == 100.0  # type: ignore[index, call-overload]


def test_the_table_has_a_line_an_operator() -> None:
    assert summarise(OUTCOMES, ("light", "open")).to_markdown() == (
        "| operator | overall | object_states | spatial_relations |\n"
        "|---|---|---|---|\n"
        "| light | 50.0 (1/2) | 100.0 (1/1) |  |\n"
        "| open | 50.0 (1/2) | 50.0 (1/2) | 100.0 (1/1) |\n"
    )


def test_the_heat_map_is_written_twice_and_alike(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    result = summarise(OUTCOMES, ("light", "open"))
    first = plot_sensitivity.save(result, "made up", tmp_path / "a.b")
    second = plot_sensitivity.save(result, "made up", tmp_path / "c.b")
    assert [path.name for path in first] == ["a.b.svg", "a.b.png", "a.b.pdf"]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    assert first[0].read_bytes().startswith(b"<?xml")


def test_nothing_tried_is_nothing_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    assert plot_sensitivity.save(summarise([], ("open",)), "none", tmp_path / "a") == ()
