"""Each rule of the tolerant planner: the rewritten operator, and the goals that it can reach."""

from __future__ import annotations

import pytest

from eai.extensions.reference.planner_of_2024 import make_task_imitating_planner_of_2024, read_operator
from eai.pddl.check import PddlFinding, PddlViolationKind
from eai.pddl.model import OperatorText, PddlAction, PddlDomain
from eai.pddl.planning import PlanningTask
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.search import search
from eai.pddl.writer import write_action, write_effect, write_formula
from eai.planning.search import Limits, SearchEndReason

HEADER = read_domain(
    """(define (domain d) (:types room thing)
    (:predicates (at ?x) (in ?x ?y) (lit ?x) (goal) (ready)))"""
)
PROBLEM = "(define (problem p) (:domain d) (:objects hall - room cup - thing) (:init {init}) (:goal {goal}))"


def read(precondition: str, effect: str, parameters: str = "(?x - thing)", name: str = "act") -> object:
    return read_operator(OperatorText(name, parameters, precondition, effect), HEADER)


def action(precondition: str, effect: str, parameters: str = "(?x - thing)", name: str = "act") -> PddlAction:
    found = read(precondition, effect, parameters, name)
    assert isinstance(found, PddlAction), found
    return found


def task(
    *actions: PddlAction, init: str = "", goal: str = "(goal)", header: PddlDomain = HEADER
) -> PlanningTask:
    return make_task_imitating_planner_of_2024(
        header, actions, read_problem(PROBLEM.format(init=init, goal=goal))
    )


def solvable(*actions: PddlAction, init: str = "", goal: str = "(goal)") -> bool:
    made = task(*actions, init=init, goal=goal)
    verdict = search(made.domain, made.problem, Limits()).end
    assert verdict is not SearchEndReason.STATES
    return verdict is SearchEndReason.SOLVED


@pytest.mark.parametrize(
    ("precondition", "effect", "offence"),
    [
        ("(and (at ?x)", "(goal)", PddlViolationKind.UNBALANCED),
        ("(at ?x))", "(goal)", PddlViolationKind.UNBALANCED),
        ("(at ?é)", "(goal)", PddlViolationKind.MALFORMED),
        ("(dark ?x)", "(goal)", PddlViolationKind.UNKNOWN_PREDICATE),
        ("(at ?x)", "(dark)", PddlViolationKind.UNKNOWN_PREDICATE),
        ("(at ?x ?x)", "(goal)", PddlViolationKind.WRONG_ARITY),
        ("(at (at ?x))", "(goal)", PddlViolationKind.MALFORMED),
        ("(and ())", "(goal)", PddlViolationKind.MALFORMED),
        ("(not ())", "(goal)", PddlViolationKind.MALFORMED),
        ("(and ready)", "(goal)", PddlViolationKind.MALFORMED),
        ("(when (ready) (goal))", "(goal)", PddlViolationKind.EFFECT_IN_CONDITION),
        ("(ready)", "(or (goal) (ready))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(ready)", "(not (not (goal)))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(ready)", "(not (and (goal)))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(ready)", "(room ?x)", PddlViolationKind.UNKNOWN_PREDICATE),
        ("(not (ready) (goal))", "(goal)", PddlViolationKind.MALFORMED),
        ("(exists (?y - (either room thing)) (at ?y))", "(goal)", PddlViolationKind.UNSUPPORTED),
        ("(exists (?y -) (at ?y))", "(goal)", PddlViolationKind.MALFORMED),
        ("(forall (?y) (in ?y ?z))", "(goal)", PddlViolationKind.UNBOUND_VARIABLE),
        ("(not (exists (?y) (in ?y ?z)))", "(goal)", PddlViolationKind.UNBOUND_VARIABLE),
    ],
)
def test_what_every_planner_refuses(precondition: str, effect: str, offence: PddlViolationKind) -> None:
    found = read(precondition, effect)
    assert isinstance(found, PddlFinding), found
    assert found.offence is offence


def test_a_parameter_needs_a_question_mark() -> None:
    found = read("(ready)", "(goal)", "(x - thing)")
    assert isinstance(found, PddlFinding)


@pytest.mark.parametrize(
    ("precondition", "effect", "parameters"),
    [
        ("(ready)", "()", "()"),
        ("(ready)", "(and)", "()"),
        ("(ready)", "(goal)", "(?x - (either room thing))"),
    ],
)
def test_what_is_left_out_without_a_word(precondition: str, effect: str, parameters: str) -> None:
    assert read(precondition, effect, parameters) is None


def test_an_operator_that_is_left_out_can_still_be_refused() -> None:
    assert isinstance(read("(dark)", "()"), PddlFinding)
    assert isinstance(read("(dark)", "(goal)", "(?x - (either room thing))"), PddlFinding)


@pytest.mark.parametrize("text", ["()", "(and)"])
def test_empty_conditions_are_legal(text: str) -> None:
    assert solvable(action(text, f"(when {text} (goal))"))


def test_objects_of_the_problem_may_be_named() -> None:
    named = action("(at hall)", "(goal)")
    assert solvable(named, init="(at hall)")
    assert not solvable(named, init="(at cup)")


class TestUnboundVariables:
    def test_an_existential_of_the_precondition_binds_the_rest(self) -> None:
        found = action("(exists (?r - room) (in ?x ?r))", "(and (goal) (lit ?r))")
        assert [p.name for p in found.parameters] == ["x", "r"]
        assert write_formula(found.precondition) == "(in ?x ?r)"
        assert solvable(found, init="(in cup hall)", goal="(lit hall)")

    def test_so_does_a_negated_universal(self) -> None:
        found = action("(not (forall (?r - room) (in ?x ?r)))", "(lit ?r)")
        assert [p.name for p in found.parameters] == ["x", "r"]

    def test_only_the_first_quantifier_of_a_name_leaks(self) -> None:
        found = action("(and (exists (?r - room) (at ?r)) (exists (?r - thing) (lit ?r)))", "(lit ?r)")
        assert [(p.name, p.category) for p in found.parameters] == [("x", "thing"), ("r", "room")]
        assert write_formula(found.precondition) == "(and (at ?r) (exists (?r - thing) (lit ?r)))"

    def test_a_name_of_a_parameter_does_not_leak(self) -> None:
        found = action("(and (exists (?x - room) (at ?x)) (lit ?y))", "(goal)")
        assert write_formula(found.precondition) == "(and (exists (?x - room) (at ?x)) (or))"

    def test_bound_operators_stay_as_they_are(self) -> None:
        found = action("(exists (?r - room) (in ?x ?r))", "(goal)")
        assert [p.name for p in found.parameters] == ["x"]

    def test_an_existential_of_a_conditional_effect_binds_its_part(self) -> None:
        found = action("()", "(when (exists (?r - room) (in ?x ?r)) (lit ?r))")
        assert write_effect(found.effect) == "(forall (?r - room) (when (in ?x ?r) (lit ?r)))"

    def test_otherwise_a_literal_of_a_condition_is_false(self) -> None:
        assert write_formula(action("(or (in ?x ?y) (ready))", "(goal)").precondition) == "(or (or) (ready))"
        assert solvable(action("(not (lit ?y))", "(goal)"))
        assert not solvable(action("(lit ?y)", "(goal)"), init="(lit cup)")
        assert not solvable(action("(= ?x ?y)", "(goal)"))

    def test_a_deletion_vanishes(self) -> None:
        found = action("()", "(and (goal) (not (lit ?y)))")
        assert write_effect(found.effect) == "(and (goal) (and))"

    def test_an_addition_is_fatal_where_it_can_be_reached(self) -> None:
        made = task(action("()", "(and (goal) (lit ?y))"))
        assert made.fatal is not None
        assert "eai--unbound-added" in write_action(made.domain.actions[0])
        assert task(action("()", "(goal)")).fatal is None


class TestUnknownNames:
    def test_a_literal_gets_a_predicate_of_its_own(self) -> None:
        adds = action("()", "(in ?x attic)", name="add")
        asks = action("(in ?x attic)", "(goal)", name="ask")
        assert solvable(adds, asks)
        assert not solvable(asks)

    def test_no_variable_is_bound_to_it(self) -> None:
        adds = action("()", "(in ?x attic)", name="add")
        asks = action("(exists (?y) (in ?x ?y))", "(goal)", name="ask")
        assert not solvable(adds, asks)

    def test_the_initial_state_may_have_one(self) -> None:
        assert solvable(action("(in ?x attic)", "(goal)"), init="(in cup attic)")

    def test_equations_with_one_are_false(self) -> None:
        assert not solvable(action("(= ?x attic)", "(goal)"))


def test_a_type_as_a_predicate_is_false() -> None:
    assert not solvable(action("(thing ?x)", "(goal)"))
    assert solvable(action("(not (thing ?x))", "(goal)"))


def test_an_undeclared_type_has_no_objects() -> None:
    assert not solvable(action("()", "(goal)", "(?x - ghost)"))
    assert solvable(action("(forall (?y - ghost) (lit ?y))", "(goal)"))


def test_a_quantifier_may_bind_a_bare_name() -> None:
    found = action("(exists (y - room) (and (at y) (at ?x)))", "(goal)")
    assert solvable(found, init="(at hall) (at cup)")
    assert not solvable(found, init="(at cup)")


def test_argument_types_are_not_checked() -> None:
    assert solvable(action("()", "(in ?x ?x)"), goal="(in cup cup)")


def test_equal_names_are_both_kept() -> None:
    upper = action("(ready)", "(goal)", name="PUT")
    lower = action("(lit hall)", "(goal)", name="put")
    made = task(upper, lower)
    assert [each.name for each in made.domain.actions] == ["put", "put--2"]
    assert solvable(upper, lower, init="(lit hall)")
