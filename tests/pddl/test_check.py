from __future__ import annotations

import pytest

from eai.pddl.check import (
    PddlDeclarations,
    PddlFinding,
    PddlViolationKind,
    check_action,
    check_domain,
    check_problem,
)
from eai.pddl.reader import read_action, read_domain, read_problem

DOMAIN = read_domain(
    """(define (domain d) (:types person room - place)
    (:constants hall - room)
    (:predicates (at ?p - person ?r - room) (lit ?r - room) (big ?x)))"""
)


def offences(
    precondition: str, effect: str = "(lit hall)", parameters: str = "(?p - person ?r - room)"
) -> set[str]:
    text = f"(:action a :parameters {parameters} :precondition {precondition} :effect {effect})"
    findings = check_action(read_action(text), PddlDeclarations.from_domain(DOMAIN))
    return {f"{finding.offence.value} {finding.name}" for finding in findings}


@pytest.mark.parametrize(
    ("precondition", "expected"),
    [
        ("(and (at ?p ?r) (lit hall) (big ?p))", set()),
        ("(forall (?x - room) (imply (lit ?x) (exists (?y) (big ?y))))", set()),
        ("(dark ?r)", {"unknown_predicate dark"}),
        ("(lit)", {"wrong_arity lit"}),
        ("(at ?r ?p)", {"wrong_argument_type r", "wrong_argument_type p"}),
        ("(lit ?x)", {"unbound_variable x"}),
        ("(and (exists (?x) (big ?x)) (big ?x))", {"unbound_variable x"}),
        ("(lit cellar)", {"undeclared_constant cellar"}),
        ("(exists (?x - ghost) (big ?x))", {"unknown_type ghost"}),
        ("(= ?p ?z)", {"unbound_variable z"}),
        ("(not (or (dark ?r) (lit cellar)))", {"unknown_predicate dark", "undeclared_constant cellar"}),
    ],
)
def test_names_of_a_condition(precondition: str, expected: set[str]) -> None:
    assert offences(precondition) == expected


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        ("(and (not (at ?p hall)) (when (lit ?r) (at ?p ?r)))", set()),
        ("(forall (?x - room) (lit ?x))", set()),
        ("(forall (?x - attic) (lit ?x))", {"unknown_type attic"}),
        ("(not (lit ?q))", {"unbound_variable q"}),
        ("(when (dark ?r) (lit ?r ?r))", {"unknown_predicate dark", "wrong_arity lit"}),
    ],
)
def test_names_of_an_effect(effect: str, expected: set[str]) -> None:
    assert offences("()", effect) == expected


def test_parameters() -> None:
    found = offences("()", parameters="(?p - person ?p - person ?x - ghost)")
    assert found == {"duplicate p", "unknown_type ghost"}


def test_objects_of_a_problem_may_be_admitted() -> None:
    problem = read_problem(
        "(define (problem q) (:domain d) (:objects cellar - room) (:init) (:goal (lit cellar)))"
    )
    action = read_action("(:action a :parameters () :effect (lit cellar))")
    assert check_action(action, PddlDeclarations.from_domain(DOMAIN)) != ()
    assert check_action(action, PddlDeclarations.from_domain(DOMAIN, problem.objects)) == ()


def test_a_finding_stands_there_once_and_says_where() -> None:
    action = read_action("(:action go :precondition (and (dark) (dark)) :effect (dark))")
    assert check_action(action, PddlDeclarations.from_domain(DOMAIN)) == (
        PddlFinding(PddlViolationKind.UNKNOWN_PREDICATE, "dark", "precondition of go"),
        PddlFinding(PddlViolationKind.UNKNOWN_PREDICATE, "dark", "effect of go"),
    )


def test_a_problem_is_checked_against_its_domain() -> None:
    text = (
        "(define (problem q) (:domain d) (:objects x - ghost x - room)"
        " (:init (lit y) (not (dark))) (:goal (big x)))"
    )
    found = {(f.offence, f.name, f.place) for f in check_problem(read_problem(text), DOMAIN)}
    assert found == {
        (PddlViolationKind.DUPLICATE, "x", "objects"),
        (PddlViolationKind.UNKNOWN_TYPE, "ghost", "objects"),
        (PddlViolationKind.UNDECLARED_CONSTANT, "y", "initial state"),
        (PddlViolationKind.UNKNOWN_PREDICATE, "dark", "initial state"),
    }


def test_declarations_of_a_domain() -> None:
    text = "(define (domain d) (:predicates (p ?x - ghost) (p)) (:action a) (:action a))"
    found = {(f.offence, f.name, f.place) for f in check_domain(read_domain(text))}
    assert found == {
        (PddlViolationKind.DUPLICATE, "p", "predicates"),
        (PddlViolationKind.DUPLICATE, "a", "operators"),
        (PddlViolationKind.UNKNOWN_TYPE, "ghost", "predicate p"),
    }


def test_only_argument_types_do_not_stop_a_planner() -> None:
    assert {offence for offence in PddlViolationKind if not offence.makes_planners_refuse_domain} == {
        PddlViolationKind.WRONG_ARGUMENT_TYPE
    }


def test_axioms_are_checked_too() -> None:
    domain = read_domain(
        "(define (domain d) (:predicates (p ?x) (q ?x)) (:derived (q ?x - den) (and (p ?y) (r) (p ?x ?x))))"
    )
    assert [(finding.offence, finding.name) for finding in check_domain(domain)] == [
        (PddlViolationKind.UNKNOWN_TYPE, "den"),
        (PddlViolationKind.UNBOUND_VARIABLE, "y"),
        (PddlViolationKind.UNKNOWN_PREDICATE, "r"),
        (PddlViolationKind.WRONG_ARITY, "p"),
    ]
