"""The outcomes of an operator with one of forty defects, under ``strict``.

In the task an agent opens a box and lights a lamp inside. The table lists each mutation of the operator
``open``, the outcome of the planner, and the defects that are reported.
"""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

from eai.abilities.transition_modeling.rules import OperatorScoringRules, PaperOperatorScoringRules
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import Verdict
from eai.pddl.model import OperatorText
from eai.pddl.planning import PddlPlanner
from eai.pddl.reader import read_domain
from eai.pddl.search import BuiltInPlanner
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.task import PredicateCategory
from sweeps import swept

OPEN = OperatorText(
    "open", "(?a - agent ?o - object)", "(and (shut ?o) (near ?a ?o))", "(and (wide ?o) (not (shut ?o)))"
)
LIGHT = OperatorText(
    "light", "(?a - agent ?o - object)", "(exists (?b) (and (wide ?b) (in ?o ?b)))", "(lit ?o)"
)
HEADER = """(define (domain d) (:types agent object)
(:predicates (shut ?o) (wide ?o) (near ?a - agent ?o) (in ?o ?b) (lit ?o)))"""
PROBLEM = """(define (problem p) (:domain d) (:objects me - agent box lamp - object)
(:init (shut box) (near me box) (in lamp box)) (:goal (lit lamp)))"""
CATEGORIES = {
    "shut": PredicateCategory.OBJECT_STATES,
    "wide": PredicateCategory.OBJECT_STATES,
    "lit": PredicateCategory.OBJECT_STATES,
    "near": PredicateCategory.SPATIAL_RELATIONS,
    "in": PredicateCategory.SPATIAL_RELATIONS,
}


@pytest.fixture(scope="module")
def task() -> TransitionTask:
    domain = OperatorLibrary(read_domain(HEADER), {"open": OPEN, "light": LIGHT}, CATEGORIES)
    return TransitionTask("t", domain, ("open", "light"), (PredicateCategory.OBJECT_STATES,), PROBLEM)


def score(task: TransitionTask, text: str, rules: Callable[[PddlPlanner], OperatorScoringRules]) -> Verdict:
    return TransitionModelingScorer(task, rules(BuiltInPlanner())).score(text)


def operator(
    precondition: str = OPEN.precondition, effect: str = OPEN.effect, parameters: str = OPEN.parameters
) -> str:
    return OperatorText("open", parameters, precondition, effect).write_pddl


def offences(verdict: Verdict) -> set[str]:
    assert isinstance(verdict, OperatorVerdict)
    return {found.offence.value for each in verdict.operators for found in each.offences}


S, U, X = "solved", "unsolvable", "input_error"
MANY = " ".join(f"(wide ?x{i})" for i in range(60_000))
LONGEST = "sixty thousand clauses"

MUTATIONS = {
    "none": (operator(), S, set()),
    "an effect is missing": (operator(effect="(not (shut ?o))"), U, set()),
    "no effect": (operator(effect="()"), U, set()),
    "an effect is reversed": (operator(effect="(and (not (wide ?o)) (not (shut ?o)))"), U, set()),
    "a precondition is missing": (operator("(shut ?o)"), S, set()),
    "no precondition": (operator("()"), S, set()),
    "an impossible precondition": (operator("(and (shut ?o) (lit ?o))"), U, set()),
    "undeclared predicate in a condition": (operator("(ajar ?o)"), X, {"unknown_predicate"}),
    "undeclared predicate in an effect": (operator(effect="(ajar ?o)"), X, {"unknown_predicate"}),
    "wrong arity in a condition": (operator("(near ?o)"), X, {"wrong_arity"}),
    "wrong arity in an effect": (operator(effect="(wide ?a ?o)"), X, {"wrong_arity"}),
    "undeclared type of a parameter": (operator(parameters="(?a - ghost ?o)"), X, {"unknown_type"}),
    "undeclared type of a quantifier": (operator("(exists (?g - ghost) (wide ?g))"), X, {"unknown_type"}),
    "a type as a predicate": (operator("(agent ?a)"), X, {"unknown_predicate"}),
    "arguments turned round": (operator("(near ?o ?a)"), U, {"wrong_argument_type"}),
    "unbound variable in a condition": (operator("(shut ?x)"), X, {"unbound_variable"}),
    "unbound variable under not": (operator("(not (wide ?x))"), X, {"unbound_variable"}),
    "unbound variable in a universal": (operator("(forall (?y) (near ?x ?y))"), X, {"unbound_variable"}),
    "unbound variable in a deletion": (
        operator(effect="(and (wide ?o) (not (shut ?x)))"),
        X,
        {"unbound_variable"},
    ),
    "unbound variable in an addition": (operator(effect="(wide ?x)"), X, {"unbound_variable"}),
    "a quantified name used outside": (
        operator("(exists (?x) (and (shut ?x) (near ?a ?x)))", "(wide ?x)"),
        X,
        {"unbound_variable"},
    ),
    "an object of the problem": (operator("(shut box)", "(wide box)"), X, {"undeclared_constant"}),
    "an unknown object": (operator("(shut crate)"), X, {"undeclared_constant"}),
    "exists in an effect": (operator(effect="(exists (?x) (wide ?x))"), X, {"condition_in_effect"}),
    "or in an effect": (operator(effect="(or (wide ?o) (shut ?o))"), X, {"condition_in_effect"}),
    "double negation in an effect": (operator(effect="(not (not (wide ?o)))"), X, {"condition_in_effect"}),
    "when in a condition": (operator("(when (shut ?o) (near ?a ?o))"), X, {"effect_in_condition"}),
    "nested when": (operator(effect="(when (shut ?o) (when (near ?a ?o) (wide ?o)))"), S, set()),
    "when with one part": (operator(effect="(when (wide ?o))"), X, {"malformed"}),
    "not with two parts": (operator("(not (wide ?o) (lit ?o))"), X, {"malformed"}),
    "an empty part of and": (operator("(and (shut ?o) ())"), X, {"malformed"}),
    "a bare word for a condition": (operator("(and shut)"), X, {"malformed"}),
    "a list as an argument": (operator("(shut (?o))"), X, {"malformed"}),
    "a parameter without question mark": (operator(parameters="(?a - agent o)"), X, {"malformed"}),
    "a parameter of several types": (
        operator(parameters="(?a ?o - (either agent object))"),
        X,
        {"unsupported"},
    ),
    "parameters of other names": (
        operator("(and (shut ?y) (near ?x ?y))", "(wide ?y)", "(?x - agent ?y - object)"),
        S,
        set(),
    ),
    "upper case": (operator().upper(), S, set()),
    "too deep": (operator("(not " * 150 + "(wide ?o)" + ")" * 150), X, set()),
    LONGEST: (operator(f"(or (shut ?o) {MANY})"), X, {"unbound_variable"}),
}


EACH_MUTATION = pytest.mark.parametrize(
    "name", [*(name for name in MUTATIONS if name != LONGEST), *swept(LONGEST)]
)


def mutate_operator(name: str) -> str:
    """Return an answer with a mutated operator ``open``."""
    return json.dumps({"output": f"{MUTATIONS[name][0]}\n{LIGHT.write_pddl}"})


@EACH_MUTATION
def test_a_mutated_operator_has_its_documented_outcome(task: TransitionTask, name: str) -> None:
    _, outcome, found = MUTATIONS[name]
    verdict = score(task, mutate_operator(name), PaperOperatorScoringRules)
    assert verdict.planner is not None
    assert verdict.planner.value == outcome
    assert offences(verdict) == found


WHOLE_ANSWERS = [
    ("", X),
    ("I cannot do that.", X),
    ("[" * 500_000, X),
    ("(" * 1_000_000, X),
    ("x" * 1_000_000, X),
    ('{"open": {"parameters": ["?o"], "effect": ["wide"]}}', X),
    (json.dumps({"output": ""}), U),
    (operator(), U),
    (f"{operator()[:-30]}", X),
    (f"{operator()} {LIGHT.write_pddl}", S),
    (f"{operator()} {LIGHT.write_pddl} (:action fly :parameters () :precondition () :effect (lit lamp))", S),
    (f"{operator()} (:action light", X),
]


@pytest.mark.parametrize(("answer", "outcome"), WHOLE_ANSWERS)
def test_a_mutated_answer_has_its_documented_outcome(task: TransitionTask, answer: str, outcome: str) -> None:
    planner = score(task, answer, PaperOperatorScoringRules).planner
    assert (planner and planner.value) == outcome


def test_there_are_about_forty_mutations() -> None:
    assert len(MUTATIONS) >= 38
