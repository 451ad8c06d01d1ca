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
from eai.pddl.evaluation import DerivedPredicates, Evaluation
from eai.pddl.model import PddlAxiom, type_of
from pddl.random_pddl import OBJECTS, atoms, formulas
from sweeps import examples

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
        return [plainly(body, state, {**binding, variable.name: name}) for name in MEMBERS[type_of(variable)]]

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
    assert Evaluation(state, DerivedPredicates(()), MEMBERS).holds(formula, {}) == plainly(formula, state, {})


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
    assert Evaluation(state, derived, MEMBERS).holds(renamed(formula), {}) == plainly(
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
    assert derived.circles.keys() == {"reach", "on"}
    closure = set(pairs)
    while more := {(a, d) for a, b in closure for c, d in pairs if b == c} - closure:
        closure |= more
    state = frozenset(Atom("q", tuple(map(Constant, pair))) for pair in pairs)
    evaluation = Evaluation(state, derived, MEMBERS)
    for a in MEMBERS["object"]:
        for b in MEMBERS["object"]:
            assert evaluation.holds(reach(Constant(a), Constant(b)), {}) == ((a, b) in closure)
            assert evaluation.holds(Not(Atom("on", (Constant(a), Constant(b)))), {}) != ((a, b) in closure)


def test_what_has_no_meaning_in_a_state_is_an_error() -> None:
    evaluation = Evaluation(frozenset(), DerivedPredicates(()), MEMBERS)
    with pytest.raises(ValueError, match="Eventually"):
        evaluation.holds(Eventually(Atom("r")), {})
    with pytest.raises(ValueError, match="unbound"):
        evaluation.holds(Atom("p", (X,)), {})
