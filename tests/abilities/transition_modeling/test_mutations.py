"""What becomes of an operator that is damaged in one of forty ways, under both protocols.

The task is to open a box and to light a lamp in it. For each mutation of the operator ``open`` the table
says the outcome of the planner under ``strict`` and under ``eai-1.0.5`` and what is wrong with it under
``strict``.
"""

from __future__ import annotations

import json

import pytest

from eai.abilities.protocol import Protocol
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import Verdict
from eai.pddl.model import OperatorText
from eai.pddl.reader import read_domain
from eai.pddl.search import BuiltInPlanner
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.task import Category
from operator_rules import rules_of
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
    "shut": Category.OBJECT_STATES,
    "wide": Category.OBJECT_STATES,
    "lit": Category.OBJECT_STATES,
    "near": Category.SPATIAL_RELATIONS,
    "in": Category.SPATIAL_RELATIONS,
}


@pytest.fixture(scope="module")
def task() -> TransitionTask:
    domain = OperatorLibrary(read_domain(HEADER), {"open": OPEN, "light": LIGHT}, CATEGORIES)
    return TransitionTask("t", domain, ("open", "light"), (Category.OBJECT_STATES,), PROBLEM)


def score(task: TransitionTask, text: str, protocol: Protocol) -> Verdict:
    return TransitionModeling(task, rules_of(protocol, BuiltInPlanner())).score(text)


def operator(
    precondition: str = OPEN.precondition, effect: str = OPEN.effect, parameters: str = OPEN.parameters
) -> str:
    return OperatorText("open", parameters, precondition, effect).pddl


def offences(verdict: Verdict) -> set[str]:
    assert isinstance(verdict, OperatorVerdict)
    return {found.offence.value for each in verdict.operators for found in each.offences}


S, U, X = "solved", "unsolvable", "input_error"
MANY = " ".join(f"(wide ?x{i})" for i in range(60_000))
LONGEST = "sixty thousand clauses"

MUTATIONS = {
    "none": (operator(), S, S, set()),
    "an effect is missing": (operator(effect="(not (shut ?o))"), U, U, set()),
    "no effect": (operator(effect="()"), U, U, set()),
    "an effect is reversed": (operator(effect="(and (not (wide ?o)) (not (shut ?o)))"), U, U, set()),
    "a precondition is missing": (operator("(shut ?o)"), S, S, set()),
    "no precondition": (operator("()"), S, S, set()),
    "an impossible precondition": (operator("(and (shut ?o) (lit ?o))"), U, U, set()),
    "undeclared predicate in a condition": (operator("(ajar ?o)"), X, X, {"unknown_predicate"}),
    "undeclared predicate in an effect": (operator(effect="(ajar ?o)"), X, X, {"unknown_predicate"}),
    "wrong arity in a condition": (operator("(near ?o)"), X, X, {"wrong_arity"}),
    "wrong arity in an effect": (operator(effect="(wide ?a ?o)"), X, X, {"wrong_arity"}),
    "undeclared type of a parameter": (
        operator(parameters="(?a - ghost ?o)"),
        X,
        U,
        {"unknown_type"},
    ),
    "undeclared type of a quantifier": (operator("(exists (?g - ghost) (wide ?g))"), X, U, {"unknown_type"}),
    "a type as a predicate": (operator("(agent ?a)"), X, U, {"unknown_predicate"}),
    "arguments turned round": (operator("(near ?o ?a)"), U, U, {"wrong_argument_type"}),
    "unbound variable in a condition": (operator("(shut ?x)"), X, U, {"unbound_variable"}),
    "unbound variable under not": (operator("(not (wide ?x))"), X, S, {"unbound_variable"}),
    "unbound variable in a universal": (operator("(forall (?y) (near ?x ?y))"), X, X, {"unbound_variable"}),
    "unbound variable in a deletion": (
        operator(effect="(and (wide ?o) (not (shut ?x)))"),
        X,
        S,
        {"unbound_variable"},
    ),
    "unbound variable in an addition": (operator(effect="(wide ?x)"), X, "unsupported", {"unbound_variable"}),
    "a quantified name used outside": (
        operator("(exists (?x) (and (shut ?x) (near ?a ?x)))", "(wide ?x)"),
        X,
        S,
        {"unbound_variable"},
    ),
    "an object of the problem": (operator("(shut box)", "(wide box)"), X, S, {"undeclared_constant"}),
    "an unknown object": (operator("(shut crate)"), X, U, {"undeclared_constant"}),
    "exists in an effect": (operator(effect="(exists (?x) (wide ?x))"), X, X, {"condition_in_effect"}),
    "or in an effect": (operator(effect="(or (wide ?o) (shut ?o))"), X, X, {"condition_in_effect"}),
    "double negation in an effect": (operator(effect="(not (not (wide ?o)))"), X, X, {"condition_in_effect"}),
    "when in a condition": (operator("(when (shut ?o) (near ?a ?o))"), X, X, {"effect_in_condition"}),
    "nested when": (operator(effect="(when (shut ?o) (when (near ?a ?o) (wide ?o)))"), S, S, set()),
    "when with one part": (operator(effect="(when (wide ?o))"), X, X, {"malformed"}),
    "not with two parts": (operator("(not (wide ?o) (lit ?o))"), X, X, {"malformed"}),
    "an empty part of and": (operator("(and (shut ?o) ())"), X, X, {"malformed"}),
    "a bare word for a condition": (operator("(and shut)"), X, X, {"malformed"}),
    "a list as an argument": (operator("(shut (?o))"), X, X, {"malformed"}),
    "a parameter without question mark": (operator(parameters="(?a - agent o)"), X, X, {"malformed"}),
    "a parameter of several types": (
        operator(parameters="(?a ?o - (either agent object))"),
        X,
        U,
        {"unsupported"},
    ),
    "parameters of other names": (
        operator("(and (shut ?y) (near ?x ?y))", "(wide ?y)", "(?x - agent ?y - object)"),
        S,
        S,
        set(),
    ),
    "upper case": (operator().upper(), S, S, set()),
    "too deep": (operator("(not " * 150 + "(wide ?o)" + ")" * 150), X, X, set()),
    LONGEST: (operator(f"(or (shut ?o) {MANY})"), X, S, {"unbound_variable"}),
}


@pytest.mark.parametrize("name", [*(name for name in MUTATIONS if name != LONGEST), *swept(LONGEST)])
def test_a_mutated_operator_has_its_documented_outcome(task: TransitionTask, name: str) -> None:
    text, strict, reference, found = MUTATIONS[name]
    answer = json.dumps({"output": f"{text}\n{LIGHT.pddl}"})
    verdict = score(task, answer, Protocol.STRICT)
    assert verdict.planner is not None
    assert verdict.planner.value == strict
    assert offences(verdict) == found
    reference_verdict = score(task, answer, Protocol("eai-1.0.5"))
    assert reference_verdict.planner is not None
    assert reference_verdict.planner.value == reference


@pytest.mark.parametrize(
    ("answer", "strict", "reference"),
    [
        ("", X, S),
        ("I cannot do that.", X, S),
        ("[" * 500_000, X, S),
        ("(" * 1_000_000, X, S),
        ("x" * 1_000_000, X, S),
        ('{"open": {"parameters": ["?o"], "effect": ["wide"]}}', X, None),
        (json.dumps({"output": ""}), U, S),
        (operator(), U, S),
        (f"{operator()[:-30]}", X, X),
        (f"{operator()} {LIGHT.pddl}", S, S),
        (f"{operator()} {LIGHT.pddl} (:action fly :parameters () :precondition () :effect (lit lamp))", S, S),
        (f"{operator()} (:action light", X, S),
    ],
)
def test_an_answer_as_a_whole_has_its_documented_outcome(
    task: TransitionTask, answer: str, strict: str, reference: str | None
) -> None:
    for protocol, expected in ((Protocol.STRICT, strict), (Protocol("eai-1.0.5"), reference)):
        outcome = score(task, answer, protocol).planner
        assert (outcome and outcome.value) == expected, protocol


def test_there_are_about_forty() -> None:
    assert len(MUTATIONS) >= 38
