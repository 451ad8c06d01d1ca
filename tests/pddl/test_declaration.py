from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import pytest
from hypothesis import given, settings

from eai.base.errors import DomainError
from eai.logic.formula import Atom
from eai.pddl.declaration import ConvertedPddlDomain
from eai.pddl.execute import PddlPlanExecutor, PddlState, PlanStep
from eai.pddl.export import export_domain_and_problem
from eai.pddl.model import PddlDomain, PddlProblem
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.writer import write_domain
from eai.world.action import Action, Fault
from eai.world.execution import attempt_action
from eai.world.fault import FaultKind
from eai.world.history import History
from eai.world.state import State
from pddl.random_pddl import DOMAINS, PROBLEMS
from sweeps import examples


def reached(states: PddlState | str, declared: set[str]) -> set[Atom] | None:
    return None if isinstance(states, str) else {atom for atom in states if atom.predicate in declared}


@given(DOMAINS, PROBLEMS)
@settings(max_examples=examples(60), deadline=None)
def test_a_declared_domain_does_what_the_pddl_does_and_so_does_its_export(
    source: PddlDomain, problem: PddlProblem
) -> None:
    declaration = ConvertedPddlDomain(source)
    domain, (initial, goals) = declaration.domain, declaration.convert_problem(problem)
    original = PddlPlanExecutor(source, problem)
    exported = export_domain_and_problem(domain, initial, goals)
    again = PddlPlanExecutor(exported.domain, exported.problem)
    declared = {predicate.name for predicate in source.predicates}
    goal = all(domain.holds(part, initial) for part in goals)
    assert goal == original.holds(problem.goal, original.initial_state, {})
    assert goal == again.holds(exported.problem.goal, again.initial_state, {})
    for action in _actions(domain.operator_arities, len(source.constants)):
        names = tuple(source.constants[i].name for i in action.arguments)
        outcome = attempt_action(domain, History(initial), action)
        engine = None if isinstance(outcome, Fault) else exported.export_state(outcome)
        expected = reached(
            original.execute_step(original.initial_state, PlanStep(action.operator, names)), declared
        )
        assert (None if engine is None else reached(engine, declared)) == expected
        assert (
            reached(again.execute_step(again.initial_state, exported.to_pddl_step(action)), declared)
            == expected
        )


def _actions(arities: object, count: int) -> Iterator[Action]:
    assert isinstance(arities, dict)
    for name, arity in arities.items():
        yield from (Action(name, things) for things in product(range(count), repeat=arity))


ZOO = read_domain(
    """(define (domain zoo) (:requirements :adl :derived-predicates)
    (:types lion seal - animal animal keeper - thing thing cage)
    (:constants agent - keeper)
    (:predicates (in ?a - thing ?c - cage) (fed ?a - animal) (content ?a - animal) (animal ?c - cage))
    (:derived (content ?x - seal) (fed ?x))
    (:derived (content ?y - lion) (and (fed ?y) (not (exists (?c - cage) (and (in ?y ?c) (animal ?c))))))
    (:action feed :parameters (?a - animal ?c - cage)
      :precondition (and (in agent ?c) (in ?a ?c) (not (content ?a))
        (or (animal ?c) (fed ?a) (not (= ?c ?c))))
      :effect (and (fed ?a) (not (fed ?a)))))"""
)
PROBLEM = read_problem(
    """(define (problem p) (:domain zoo) (:objects leo - lion sam - seal ann - keeper house pool - cage)
    (:init (in leo house) (in sam pool) (in agent pool) (fed leo) (animal pool))
    (:goal (forall (?a - animal) (content ?a))))"""
)


@pytest.fixture(scope="module")
def zoo() -> ConvertedPddlDomain:
    return ConvertedPddlDomain(ZOO)


def test_types_are_categories_and_supertypes_are_their_parents(zoo: ConvertedPddlDomain) -> None:
    initial, _ = zoo.convert_problem(PROBLEM)
    kinds = {thing.name: thing.category for thing in initial.scene.objects}
    assert kinds == {
        "agent": "keeper",
        "leo": "lion",
        "sam": "seal",
        "ann": "keeper",
        "house": "cage",
        "pool": "cage",
    }
    assert initial.scene.names_of_category("animal") == ("leo", "sam")
    assert initial.scene.names_of_category("thing") == ("agent", "leo", "sam", "ann")
    static = {predicate.name for predicate in zoo.domain.vocabulary.predicates if predicate.static}
    assert static == {"in", "animal"}


def test_an_object_named_agent_is_the_object_that_formulas_mean_by_it(zoo: ConvertedPddlDomain) -> None:
    initial, _ = zoo.convert_problem(PROBLEM)
    index = initial.scene.index
    assert isinstance(
        attempt_action(zoo.domain, History(initial), Action("feed", (index["sam"], index["pool"]))), State
    )


def test_checks_are_affordances_where_nothing_changes_what_they_say(zoo: ConvertedPddlDomain) -> None:
    checks = zoo.domain.compiled_operators["feed"].operator.checks
    assert [(check.fault, check.reason) for check in checks] == [
        (FaultKind.AFFORDANCE, "{a} is no animal"),
        (FaultKind.AFFORDANCE, "{c} is no cage"),
        (FaultKind.AFFORDANCE, "in(agent, {c}) does not hold"),
        (FaultKind.AFFORDANCE, "in({a}, {c}) does not hold"),
        (FaultKind.MISSING_STEP, "content({a}) holds"),
        (FaultKind.MISSING_STEP, "(or (animal {c}) (fed {a}) (not (= {c} {c}))) does not hold"),
    ]


def test_a_derived_predicate_that_no_action_changes_makes_an_affordance() -> None:
    source = read_domain(
        """(define (domain d) (:predicates (p) (q) (r) (s) (t))
        (:derived (r) (p)) (:derived (s) (r)) (:derived (t) (or (s) (q)))
        (:action a :precondition (and (s) (t)) :effect (q)))"""
    )
    checks = ConvertedPddlDomain(source).domain.compiled_operators["a"].operator.checks
    assert [check.fault for check in checks] == [FaultKind.AFFORDANCE, FaultKind.MISSING_STEP]


def test_an_addition_wins_over_a_deletion(zoo: ConvertedPddlDomain) -> None:
    initial, _ = zoo.convert_problem(PROBLEM)
    index = initial.scene.index
    after = attempt_action(zoo.domain, History(initial), Action("feed", (index["sam"], index["pool"])))
    assert isinstance(after, State)
    assert after.has("fed", index["sam"])


def test_a_subtype_fits_a_parameter_of_its_supertype_and_nothing_else_does(zoo: ConvertedPddlDomain) -> None:
    initial, _ = zoo.convert_problem(PROBLEM)
    index = initial.scene.index
    failed = attempt_action(zoo.domain, History(initial), Action("feed", (index["house"], index["pool"])))
    assert isinstance(failed, Fault)
    assert failed.kind is FaultKind.AFFORDANCE


def test_types_survive_an_export(zoo: ConvertedPddlDomain) -> None:
    initial, goals = zoo.convert_problem(PROBLEM)
    exported = export_domain_and_problem(zoo.domain, initial, goals)
    types = {each.name: each.type for each in exported.domain.types}
    animals, things = {"lion": "animal", "seal": "animal"}, {"animal": "thing", "keeper": "thing"}
    assert types == {**animals, **things, "thing": "object", "cage": "object"}
    again = ConvertedPddlDomain(read_domain(write_domain(exported.domain)))
    assert again.domain.vocabulary.parents == zoo.domain.vocabulary.parents


def test_axioms_of_one_predicate_are_alternatives(zoo: ConvertedPddlDomain) -> None:
    initial, (goal,) = zoo.convert_problem(PROBLEM)
    assert not zoo.domain.holds(goal, initial)
    fed = initial.scene.state([("fed", (1,)), ("fed", (2,))])
    assert zoo.domain.holds(goal, fed)


@pytest.mark.parametrize(
    "condition",
    [
        "(not (p ?x))",
        "(imply (p ?x) (q ?x))",
        "(forall (?y) (not (and (q ?y) (p ?y))))",
        "(not (not (not (p ?x))))",
    ],
)
def test_a_predicate_that_depends_on_its_negation_has_no_meaning(condition: str) -> None:
    text = f"(define (domain d) (:predicates (p ?x) (q ?x)) (:derived (p ?x) {condition}))"
    with pytest.raises(DomainError, match="the derived predicate p depends on its own negation"):
        ConvertedPddlDomain(read_domain(text))
