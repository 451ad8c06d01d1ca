"""Lookahead, by what the search finds when it may evaluate but one state."""

from __future__ import annotations

import pytest

from eai.pddl.execute import Executor
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.search import GroundLimits, SearchVerdict, search

ONE = GroundLimits(central=1, full=1)
HOUSE = read_domain(
    """(define (domain house)
    (:predicates (at ?x) (held ?x) (full) (in ?x ?y) (open ?y) (beside ?x ?y))
    (:action go :parameters (?x) :effect (and (forall (?y) (not (at ?y))) (at ?x)))
    (:action take :parameters (?x) :precondition (and (at ?x) (not (full))
      (forall (?y) (or (open ?y) (not (in ?x ?y)))))
     :effect (and (held ?x) (full)
      (forall (?y) (and (not (in ?x ?y)) (not (beside ?x ?y)) (not (beside ?y ?x))))))
    (:action put :parameters (?x ?y) :precondition (and (held ?x) (at ?y) (open ?y))
     :effect (and (not (held ?x)) (not (full)) (in ?x ?y)))
    (:action join :parameters (?x ?y) :precondition (and (held ?x) (at ?y))
     :effect (and (not (held ?x)) (not (full)) (beside ?x ?y) (beside ?y ?x)))
    (:action open :parameters (?y) :precondition (and (at ?y) (not (full))) :effect (open ?y))
    (:action shut :parameters (?y) :precondition (at ?y) :effect (not (open ?y))))"""
)


@pytest.mark.parametrize(
    ("initial", "goal", "length"),
    [
        # each thing is brought to the box by itself, though a relaxed plan goes there but once
        ("(open box)", "(and (in cup box) (in jar box) (in pan box))", 12),
        # the box is opened before a hand is full, and shut last
        ("(at cup)", "(and (in cup box) (in jar box) (not (open box)))", 12),
        # what has been done at one place is done again where it is lost
        ("(in cup box)", "(and (at box) (in cup pot) (open pot))", 9),
        # the cup, which every thing may be put beside, is not taken away again
        ("(in jar box) (in pan box)", "(and (beside jar cup) (beside pan cup) (beside pot cup))", 15),
    ],
)
def test_one_state_is_enough_where_parts_of_the_goal_can_be_reached_one_after_the_other(
    initial: str, goal: str, length: int
) -> None:
    head = "(:domain house) (:objects cup jar pan pot box)"
    problem = read_problem(f"(define (problem p) {head} (:init {initial}) (:goal {goal}))")
    result = search(HOUSE, problem, ONE)
    assert (result.verdict, result.evaluated) == (SearchVerdict.SOLVED, 1)
    assert Executor(HOUSE, problem).flaw(result.plan) is None
    assert len(result.plan) <= length
