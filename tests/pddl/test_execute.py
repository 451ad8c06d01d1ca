from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.logic.formula import (
    And,
    Atom,
    Constant,
    Equals,
    Eventually,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
    Or,
    Term,
    Variable,
)
from eai.pddl.execute import DerivedPredicates, PddlPlanExecutor, PlanStep, _ConditionEvaluatorInState
from eai.pddl.model import PddlAxiom, get_variable_type
from eai.pddl.reader import read_action, read_domain, read_problem
from pddl.random_pddl import OBJECTS, atoms, formulas
from sweeps import examples

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
EXECUTOR = PddlPlanExecutor(DOMAIN, PROBLEM)


def plan(*lines: str) -> list[PlanStep]:
    return [PlanStep(name, tuple(arguments)) for name, *arguments in (line.split() for line in lines)]


def fact(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(map(Constant, names)))


@pytest.mark.parametrize(
    ("steps", "flaw"),
    [
        (("go hall attic",), None),
        (("light hall", "go hall attic"), None),
        ((), (0, "goal not reached")),
        (("go attic hall",), (0, "the precondition of (go attic hall) does not hold")),
        (
            ("go hall attic", "go hall attic"),
            (1, "the precondition of (go hall attic) does not hold"),
        ),
        (("fly hall",), (0, "no operator fly")),
        (("go hall",), (0, "go takes 2 objects")),
        (("go hall k",), (0, "k is no room")),
    ],
)
def test_plans(steps: tuple[str, ...], flaw: tuple[int, str] | None) -> None:
    assert EXECUTOR.find_failed_step(plan(*steps)) == flaw


def test_conditions_of_an_effect_are_read_before_it() -> None:
    lit = EXECUTOR.execute_step(EXECUTOR.initial_state, PlanStep("light", ("hall",)))
    assert lit == {fact("at", "hall"), fact("lit", "hall")}
    held = EXECUTOR.execute_step(EXECUTOR.initial_state, PlanStep("swap", ()))
    assert isinstance(held, frozenset)
    assert fact("held", "k") in held
    assert EXECUTOR.execute_step(held, PlanStep("swap", ())) == EXECUTOR.initial_state


def test_what_is_deleted_and_added_is_true() -> None:
    state = EXECUTOR.execute_step(EXECUTOR.initial_state, PlanStep("both", ()))
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
    assert EXECUTOR.holds(condition, EXECUTOR.initial_state, {}) is value


def test_what_has_no_meaning_is_an_error() -> None:
    with pytest.raises(ValueError, match="Eventually has no PDDL form"):
        EXECUTOR.holds(Eventually(fact("held", "k")), EXECUTOR.initial_state, {})
    with pytest.raises(ValueError, match=r"variable \?x is not bound"):
        EXECUTOR.holds(Atom("held", (Variable("x"),)), EXECUTOR.initial_state, {})


MEMBERS = {"object": ("a", "b", "c"), "thing": ("a", "b")}
STATES = st.frozensets(atoms(()), max_size=8)
X, Y, Z = Variable("x"), Variable("y"), Variable("z")


def plainly(formula: Formula, state: frozenset[Atom], binding: Mapping[str, str]) -> bool:
    """The meaning of a condition, word for word."""

    def thing(term: Term) -> str:
        return term.name if isinstance(term, Constant) else binding[term.name]

    def part(each: Formula) -> bool:
        return plainly(each, state, binding)

    def values(variable: Variable, body: Formula) -> list[bool]:
        return [
            plainly(body, state, {**binding, variable.name: name})
            for name in MEMBERS[get_variable_type(variable)]
        ]

    match formula:
        case Atom(predicate, arguments):
            return Atom(predicate, tuple(Constant(thing(term)) for term in arguments)) in state
        case Equals(left, right):
            return thing(left) == thing(right)
        case Not(operand):
            return not part(operand)
        case And(operands):
            return all(map(part, operands))
        case Or(operands):
            return any(map(part, operands))
        case Implies(premise, conclusion):
            return not part(premise) or part(conclusion)
        case ForAll(variable, body):
            return all(values(variable, body))
        case Exists(variable, body):
            return any(values(variable, body))
        case _:
            raise AssertionError(formula)


@given(formulas((), 4), STATES)
@settings(max_examples=examples(200))
def test_conditions_mean_what_they_say(formula: Formula, state: frozenset[Atom]) -> None:
    assert _ConditionEvaluatorInState(state, DerivedPredicates(()), MEMBERS).holds(formula, {}) == plainly(
        formula, state, {}
    )


@given(formulas(("x", "y"), 3), formulas((), 3), STATES)
@settings(max_examples=examples(100))
def test_a_derived_predicate_stands_for_its_condition(
    condition: Formula, formula: Formula, state: frozenset[Atom]
) -> None:
    def unfolded(part: Formula) -> Formula:
        match part:
            case Atom("q", (one, other)):
                return Exists(X, Exists(Y, And((Equals(X, one), Equals(Y, other), condition))))
            case Not(operand):
                return Not(unfolded(operand))
            case And(operands) | Or(operands):
                return type(part)(tuple(map(unfolded, operands)))
            case Implies(premise, conclusion):
                return Implies(unfolded(premise), unfolded(conclusion))
            case ForAll(variable, body) | Exists(variable, body):
                return type(part)(variable, unfolded(body))
            case _:
                return part

    def renamed(part: Formula) -> Formula:
        match part:
            case Atom("q", arguments):
                return Atom("derived", arguments)
            case Not(operand):
                return Not(renamed(operand))
            case And(operands) | Or(operands):
                return type(part)(tuple(map(renamed, operands)))
            case Implies(premise, conclusion):
                return Implies(renamed(premise), renamed(conclusion))
            case ForAll(variable, body) | Exists(variable, body):
                return type(part)(variable, renamed(body))
            case _:
                return part

    derived = DerivedPredicates([PddlAxiom("derived", (X, Y), condition)])
    assert _ConditionEvaluatorInState(state, derived, MEMBERS).holds(renamed(formula), {}) == plainly(
        unfolded(formula), state, {}
    )


@given(st.frozensets(st.tuples(*[st.sampled_from([item.name for item in OBJECTS])] * 2), max_size=6))
def test_a_derived_predicate_that_depends_on_itself_is_a_least_fixpoint(
    pairs: frozenset[tuple[str, str]],
) -> None:
    def reach(one: Term, other: Term) -> Atom:
        return Atom("reach", (one, other))

    step = Exists(Z, And((Atom("q", (X, Z)), Atom("on", (Z, Y)))))
    derived = DerivedPredicates(
        [
            PddlAxiom("reach", (X, Y), Atom("q", (X, Y))),
            PddlAxiom("reach", (X, Y), step),
            PddlAxiom("on", (X, Y), reach(X, Y)),
        ]
    )
    assert derived.cycles.keys() == {"reach", "on"}
    closure = set(pairs)
    while more := {(a, d) for a, b in closure for c, d in pairs if b == c} - closure:
        closure |= more
    state = frozenset(Atom("q", tuple(map(Constant, pair))) for pair in pairs)
    evaluation = _ConditionEvaluatorInState(state, derived, MEMBERS)
    for a in MEMBERS["object"]:
        for b in MEMBERS["object"]:
            assert evaluation.holds(reach(Constant(a), Constant(b)), {}) == ((a, b) in closure)
            assert evaluation.holds(Not(Atom("on", (Constant(a), Constant(b)))), {}) != ((a, b) in closure)


def test_what_has_no_meaning_in_a_state_is_an_error() -> None:
    evaluation = _ConditionEvaluatorInState(frozenset(), DerivedPredicates(()), MEMBERS)
    with pytest.raises(ValueError, match="Eventually"):
        evaluation.holds(Eventually(Atom("r")), {})
    with pytest.raises(ValueError, match="not bound"):
        evaluation.holds(Atom("p", (X,)), {})
