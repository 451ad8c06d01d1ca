"""Pairs of literals: none that holds together somewhere is excluded, and what is excluded is no goal."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings

from eai.pddl.grounding import GroundCondition, Grounder
from eai.pddl.literals import Literals
from eai.pddl.model import PddlDomain, PddlProblem
from eai.pddl.pairs import Pairs
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.search import GroundLimits, SearchVerdict, search
from eai.pddl.successors import Successors
from eai.planning.effort import Effort
from pddl.random_pddl import DOMAINS, PROBLEMS
from sweeps import examples


@settings(max_examples=examples(100), deadline=None, suppress_health_check=list(HealthCheck))
@given(DOMAINS, PROBLEMS)
def test_what_holds_together_somewhere_is_allowed(domain: PddlDomain, problem: PddlProblem) -> None:
    grounder = Grounder(domain, problem)
    actions = list(grounder.actions())
    initial, atoms = grounder.initial, grounder.atoms
    pairs = Pairs(actions, atoms, initial, Effort())
    literals = Literals(atoms, Effort())
    successors = Successors(actions, literals, Effort())
    waiting, seen = [initial], {initial}
    while waiting and len(seen) < 200:
        state = waiting.pop()
        assert pairs.allow(GroundCondition(state, ~state & (1 << atoms) - 1, ()))
        found = {after for _, after in successors.of(state, literals.of(state))} - seen
        seen |= found
        waiting += sorted(found)


HOUSE = read_domain(
    """(define (domain house) (:predicates (held ?x) (full) (at ?x) (lit ?x) (spare))
    (:action take :parameters (?x) :precondition (and (at ?x) (not (full))) :effect (and (held ?x) (full)))
    (:action drop :parameters (?x) :precondition (held ?x) :effect (and (not (held ?x)) (not (full))))
    (:action go :parameters (?x) :effect (and (at ?x) (forall (?y) (when (not (= ?x ?y)) (not (at ?y))))))
    (:action light :parameters (?x) :precondition (at ?x) :effect (lit ?x))
    (:action swap :effect (and (when (spare) (not (spare))) (when (not (spare)) (spare)))))"""
)
LIT = " ".join(f"(lit {name})" for name in "abcdefghijkl")


@pytest.mark.parametrize(
    ("goal", "is_allowed"),
    [
        ("(and (held a) (held b))", False),
        ("(and (held a) (not (full)))", False),
        ("(and (at a) (at b))", False),
        ("(and (held a) (at b))", True),
        ("(and (held a) (not (held b)))", True),
        ("(and (spare) (lit a))", True),
        ("(and (not (at a)) (not (at b)) (not (at c)))", True),  # no pair of them is impossible
        ("(or (held a) (held b))", True),
    ],
)
def test_pairs_tell_what_one_hand_cannot_hold(goal: str, is_allowed: bool) -> None:
    problem = read_problem(f"(define (problem p) (:domain house) (:objects a b c) (:init) (:goal {goal}))")
    grounder = Grounder(HOUSE, problem)
    condition = grounder.goal()
    assert condition is not None
    actions = list(grounder.actions())
    looks = Effort()
    assert Pairs(actions, grounder.atoms, grounder.initial, looks).allow(condition) is is_allowed
    assert Pairs(actions, grounder.atoms, grounder.initial, Effort(looks.used // 2)).allow(condition)


@pytest.mark.parametrize(
    ("goal", "verdict"),
    [
        (f"(and {LIT} (held a) (held b))", SearchVerdict.UNSOLVABLE),
        (f"(and {LIT} (held a) (at b))", SearchVerdict.SOLVED),
    ],
)
def test_what_pairs_exclude_is_not_searched_for(goal: str, verdict: SearchVerdict) -> None:
    names = " ".join("abcdefghijkl")
    problem = read_problem(f"(define (problem p) (:domain house) (:objects {names}) (:init) (:goal {goal}))")
    result = search(HOUSE, problem, GroundLimits())
    assert result.verdict is verdict
    assert result.evaluated <= 60
