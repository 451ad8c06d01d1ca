"""Relevance, by problems too large to be searched unless what does not matter is left out."""

from __future__ import annotations

import pytest

from eai.pddl.execute import PddlPlanExecutor
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.search import restrict_to_relevant, search
from eai.planning.search import Limits, SearchEndReason

NAMES = "abcdefghijkl"
EIGHT = " ".join(f"?x{i}" for i in range(8))
PAIRS = "(near ?x0 ?x1) (near ?x2 ?x3) (near ?x4 ?x5) (near ?x6 ?x7)"
WIDE = f"(:action wide :parameters ({EIGHT}) :precondition {{}} :effect {{}})"
MOVE = "(:action move :parameters (?x ?y) :effect (near ?x ?y))"
WASH = "(:action wash :parameters (?x) :precondition (wet ?x) :effect (clean ?x))"
DRY = "(:action dry :parameters (?x) :effect (not (wet ?x)))"
DERIVED = "(:derived (fine ?x) (clean ?x))"
SOLVED, UNSOLVABLE, UNDECIDED = SearchEndReason.SOLVED, SearchEndReason.UNREACHABLE, SearchEndReason.STATES


@pytest.mark.parametrize(
    ("operators", "initial", "goal", "verdict", "why"),
    [
        (WIDE.format(f"(and {PAIRS})", "(done)") + MOVE, "", "(done)", UNDECIDED, "all of it matters"),
        (
            WIDE.format("()", f"(and {PAIRS})") + WASH,
            "(wet a)",
            "(clean a)",
            SOLVED,
            "no one asks what is near",
        ),
        (WIDE.format("(cold a)", f"(and {PAIRS} (done))"), "", "(done)", UNSOLVABLE, "nothing is ever cold"),
        (
            WIDE.format("(wet a)", f"(and {PAIRS} (wet ?x7))"),
            "",
            "(wet b)",
            UNSOLVABLE,
            "wet things come of wet",
        ),
        (
            WIDE.format("(exists (?y) (and (cold ?y) (near ?x0 ?y)))", f"(and {PAIRS} (done))"),
            "(near a b)",
            "(done)",
            UNSOLVABLE,
            "nothing is ever cold, whatever is near",
        ),
        (
            WIDE.format("()", f"(when (cold a) (and {PAIRS} (done)))"),
            "",
            "(done)",
            UNSOLVABLE,
            "what happens in the cold never does",
        ),
        (WIDE.format("(wet ?x0)", "(done)"), "(wet a)", "(done)", SOLVED, "the other parameters are idle"),
        (WIDE.format("()", "(wet ?x0)") + DRY, "", "(and (wet a) (wet b))", SOLVED, "these too"),
        (
            WIDE.format(f"(and {PAIRS})", "(not (wet ?x7))") + MOVE,
            "(wet b)",
            "(and (wet a) (done))",
            UNSOLVABLE,
            "nothing becomes wet that is not",
        ),
        (
            WIDE.format(f"(and {PAIRS})", "(wet ?x7)") + MOVE,
            "(wet a) (done)",
            "(and (not (wet a)) (done))",
            UNSOLVABLE,
            "nothing wet becomes dry",
        ),
        (
            DERIVED + WASH + WIDE.format("()", f"(and {PAIRS})"),
            "(wet a)",
            "(fine a)",
            SOLVED,
            "fine is clean",
        ),
        (DERIVED + WASH + MOVE, "", "(fine a)", UNSOLVABLE, "and nothing is clean"),
    ],
)
def test_what_does_not_matter_costs_nothing(
    operators: str, initial: str, goal: str, verdict: SearchEndReason, why: str
) -> None:
    predicates = "(near ?x ?y) (wet ?x) (clean ?x) (cold ?x) (fine ?x) (done)"
    constants = " ".join(NAMES)
    domain = read_domain(
        f"(define (domain d) (:predicates {predicates}) (:constants {constants}) {operators})"
    )
    problem = read_problem(f"(define (problem p) (:domain d) (:init {initial}) (:goal {goal}))")
    result = search(domain, problem, Limits())
    assert result.end is verdict, why
    if verdict is SOLVED:
        assert PddlPlanExecutor(domain, problem).find_failed_step(result.plan) is None


def test_of_operators_that_do_the_same_in_what_matters_the_first_is_left() -> None:
    domain = read_domain(
        """(define (domain d) (:predicates (held ?x) (on ?x ?y) (beside ?x ?y) (full))
        (:action take :parameters (?x) :precondition (not (full)) :effect (and (held ?x) (full)))
        (:action put :parameters (?x ?y) :precondition (held ?x)
         :effect (and (not (held ?x)) (not (full)) (on ?x ?y)))
        (:action lay :parameters (?x ?y) :precondition (held ?x)
         :effect (and (not (held ?x)) (not (full)) (beside ?x ?y))))"""
    )
    problem = "(define (problem p) (:domain d) (:objects a b) (:init) (:goal {}))"
    held = restrict_to_relevant(domain, read_problem(problem.format("(and (held a) (not (full)))")))
    assert [action.name for action in held.actions] == ["take", "put"]
    both = restrict_to_relevant(domain, read_problem(problem.format("(and (on a b) (beside b a))")))
    assert both == domain
