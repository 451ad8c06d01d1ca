from __future__ import annotations

import pytest

from eai.logic.formula import Atom, Constant, Eventually, Variable
from eai.pddl.execute import Executor, PlanFlaw, PlanStep
from eai.pddl.reader import read_action, read_domain, read_problem

DOMAIN = read_domain(
    """(define (domain d) (:types room) (:predicates (at ?r - room) (lit ?r - room) (held ?x))
    (:action go :parameters (?a - room ?b - room) :precondition (at ?a) :effect (and (at ?b) (not (at ?a))))
    (:action light :parameters (?r - room) :precondition (and (at ?r) (not (lit ?r)))
      :effect (and (lit ?r) (forall (?o - room) (when (and (lit ?o) (not (= ?o ?r))) (not (lit ?o))))))
    (:action swap :parameters () :effect (and (when (held k) (not (held k))) (when (not (held k)) (held k))))
    (:action both :parameters () :effect (and (not (held k)) (held k))))"""
)
PROBLEM = read_problem(
    """(define (problem p) (:domain d) (:objects hall attic - room k)
    (:init (at hall) (lit attic)) (:goal (and (at attic) (exists (?r - room) (lit ?r)))))"""
)
EXECUTOR = Executor(DOMAIN, PROBLEM)


def plan(*lines: str) -> list[PlanStep]:
    return [PlanStep(name, tuple(arguments)) for name, *arguments in (line.split() for line in lines)]


def fact(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(map(Constant, names)))


@pytest.mark.parametrize(
    ("steps", "flaw"),
    [
        (("go hall attic",), None),
        (("light hall", "go hall attic"), None),
        ((), PlanFlaw(0, "goal not reached")),
        (("go attic hall",), PlanFlaw(0, "the precondition of (go attic hall) does not hold")),
        (
            ("go hall attic", "go hall attic"),
            PlanFlaw(1, "the precondition of (go hall attic) does not hold"),
        ),
        (("fly hall",), PlanFlaw(0, "no operator fly")),
        (("go hall",), PlanFlaw(0, "go takes 2 objects")),
        (("go hall k",), PlanFlaw(0, "k is no room")),
    ],
)
def test_plans(steps: tuple[str, ...], flaw: PlanFlaw | None) -> None:
    assert EXECUTOR.flaw(plan(*steps)) == flaw


def test_conditions_of_an_effect_are_read_before_it() -> None:
    lit = EXECUTOR.successor(EXECUTOR.initial, PlanStep("light", ("hall",)))
    assert lit == {fact("at", "hall"), fact("lit", "hall")}
    held = EXECUTOR.successor(EXECUTOR.initial, PlanStep("swap", ()))
    assert isinstance(held, frozenset)
    assert fact("held", "k") in held
    assert EXECUTOR.successor(held, PlanStep("swap", ())) == EXECUTOR.initial


def test_what_is_deleted_and_added_is_true() -> None:
    state = EXECUTOR.successor(EXECUTOR.initial, PlanStep("both", ()))
    assert isinstance(state, frozenset)
    assert fact("held", "k") in state


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("(and)", True),
        ("(or)", False),
        ("(or (lit hall) (lit attic))", True),
        ("(imply (lit hall) (held k))", True),
        ("(forall (?r - room) (or (lit ?r) (at ?r)))", True),
        ("(exists (?r - room) (and (lit ?r) (at ?r)))", False),
        ("(exists (?r - ghost) (and))", False),
        ("(forall (?r - ghost) (or))", True),
        ("(exists (?x) (not (or (= ?x hall) (= ?x attic))))", True),
    ],
)
def test_conditions(text: str, value: bool) -> None:
    condition = read_action(f"(:action a :precondition {text})").precondition
    assert EXECUTOR.holds(condition, EXECUTOR.initial, {}) is value


def test_what_has_no_meaning_is_an_error() -> None:
    with pytest.raises(ValueError, match="no meaning in a single state"):
        EXECUTOR.holds(Eventually(fact("held", "k")), EXECUTOR.initial, {})
    with pytest.raises(ValueError, match=r"unbound variable \?x"):
        EXECUTOR.holds(Atom("held", (Variable("x"),)), EXECUTOR.initial, {})
