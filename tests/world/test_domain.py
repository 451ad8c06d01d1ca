"""Operators with several tries, and the two rules that recognize a wrong order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from eai.base.errors import DomainError
from eai.logic.formula import FALSE, Atom, Formula, Variable
from eai.world.action import Action, Fault
from eai.world.derived import ComputedPredicate, DefinedPredicate, is_a
from eai.world.domain import Domain
from eai.world.effect import Add, Delete
from eai.world.execution import Trajectory, attempt_action, execute_plan
from eai.world.fault import FaultKind
from eai.world.history import History, HistoryRule, find_when_action_was_possible, find_when_conditions_held
from eai.world.operator import (
    Check,
    Operator,
    OperatorAlternative,
    additional_step,
    affordance,
    missing_step,
    sort_checks_in_paper_order,
)
from eai.world.state import Scene, State, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy

WET, DIRTY, MUDDY, SOAP = (Predicate(name, 0) for name in ("wet", "dirty", "muddy", "soap"))
CLEAN = Operator(
    "CLEAN",
    (),
    (additional_step(DIRTY() | MUDDY(), "clean already"),),
    (Delete(WET()),),
    alternatives=(
        OperatorAlternative(DIRTY(), (missing_step(SOAP(), "no soap"),), (Delete(DIRTY()),)),
        OperatorAlternative(MUDDY(), (affordance(WET(), "dry"),), (Delete(MUDDY()),)),
    ),
)
TAKE, LOSE = Operator("TAKE", (), (), (Add(SOAP()),)), Operator("LOSE", (), (), (Delete(SOAP()),))
DOMAIN = Domain(
    "bath",
    Vocabulary((WET, DIRTY, MUDDY, SOAP)),
    (CLEAN, TAKE, LOSE),
    history_rule=find_when_action_was_possible,
)

X, Y = Variable("x"), Variable("y")
LIT, FIXED, NEAR = Predicate("lit", 1), Predicate("fixed", 1, static=True), Predicate("near", 2)


def press(*effects: object, checks: object = (), parameters: object = (X,)) -> Operator:
    return Operator("PRESS", parameters, checks, effects)  # type: ignore[arg-type]


def lamps(*operators: Operator, derived: tuple[DefinedPredicate, ...] = (), **more: Any) -> Domain:
    return Domain("lamps", Vocabulary((LIT, FIXED, NEAR), derived), operators, **more)


def circle(name: str, other: str) -> DefinedPredicate:
    return DefinedPredicate(name, (X,), ~Atom(other, (X,)))


@pytest.mark.parametrize(
    ("declare", "problem"),
    [
        (lambda: lamps(press(), press()), "operator PRESS is declared twice"),
        (lambda: press(parameters=(X, X)), "operator PRESS: two parameters are called x"),
        (
            lambda: press(parameters=X),
            "operator PRESS, parameters: expected a tuple; write a tuple of one value",
        ),
        (
            lambda: press(parameters="x"),
            "operator PRESS, parameters: expected a tuple of Variable, found",
        ),
        (lambda: press(checks=(LIT(X),)), "operator PRESS, checks: expected Check, found Atom"),
        (lambda: press(LIT(X)), "operator PRESS, effects: expected Add, Delete, When, ForEach or Let, found"),
        (
            lambda: Domain("d", Vocabulary(()), press()),
            "operators: expected a tuple; write a tuple of one value",
        ),
        (
            lambda: press(checks=(missing_step(LIT(X), "{lamp} is dark"),), parameters=(Variable("lamps"),)),
            "operator PRESS: the reason of a check mentions {lamp}, which is no parameter of the operator; "
            "did you mean lamps?",
        ),
        (lambda: missing_step(LIT(X), ""), "a check for missing_step has an empty reason"),
        (
            lambda: Check(LIT(X), FaultKind.PARSING, "no"),
            "the check with the reason 'no' has the fault kind parsing: expected uncategorised, "
            "additional_step, affordance or",
        ),
        (
            lambda: lamps(press(Add(Atom("lt", (X,))))),
            "operator PRESS: predicate lt is not declared; did you mean lit?",
        ),
        (lambda: lamps(press(Add(Atom("lit", (X, X))))), "operator PRESS: lit takes 1 argument, not 2"),
        (lambda: lamps(press(Add(LIT(Y)))), "operator PRESS: variable y is not bound"),
        (lambda: lamps(press(Add(FIXED(X)))), "operator PRESS: an effect changes fixed, which is declared"),
        (
            lambda: lamps(
                press(Add(Atom("bright", (X,)))), derived=(DefinedPredicate("bright", (X,), LIT(X)),)
            ),
            "operator PRESS: an effect changes bright, which is derived: change the predicates",
        ),
        (
            lambda: lamps(press(checks=(missing_step(Atom("nearr", (X, X)), "far"),))),
            "operator PRESS: predicate nearr is not declared; did you mean near?",
        ),
        (
            lambda: lamps(derived=(DefinedPredicate("d", (X,), Atom("at", (X,))),)),
            "derived predicate d: predicate at is not declared",
        ),
        (
            lambda: lamps(derived=(circle("d", "d"),)),
            "derived predicate d: derived predicate d is defined",
        ),
        (
            lambda: lamps(derived=(circle("c", "d"), circle("d", "c"))),
            "derived predicate c: derived predicate c is defined by itself",
        ),
        (lambda: lamps(visible=LIT(Y)), "visible: variable y is not bound"),
        (lambda: lamps(landmarks=Atom("new", (X,))), "landmarks: predicate new is not declared"),
    ],
)
def test_a_wrong_declaration_raises_an_error_that_names_the_mistake(
    declare: Callable[[], object], problem: str
) -> None:
    with pytest.raises(DomainError) as error:
        declare()
    assert str(error.value).startswith(problem)
    assert "\n" not in str(error.value)


def run(facts: str, *names: str, domain: Domain = DOMAIN) -> Trajectory:
    state = Scene(domain.vocabulary, (WorldObject("it", "thing"),)).state(
        (name, ()) for name in facts.split()
    )
    return execute_plan(domain, state, [Action(name, ()) for name in names])


def facts(trajectory: Trajectory) -> str:
    return " ".join(fact.predicate for fact in trajectory.final_state.facts())


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("dirty soap wet", "soap"),
        ("dirty soap muddy wet", "soap"),
        ("dirty soap muddy", "muddy soap"),
        ("dirty muddy wet", "dirty"),
        ("muddy wet", ""),
    ],
)
def test_an_action_has_the_effects_of_all_successful_tries(before: str, after: str) -> None:
    trajectory = run(before, "CLEAN")
    assert trajectory.failure is None
    assert facts(trajectory) == after


@pytest.mark.parametrize(
    ("before", "kind", "reason"),
    [
        ("wet", FaultKind.ADDITIONAL_STEP, "clean already"),
        ("dirty wet", FaultKind.MISSING_STEP, "no soap"),
        ("muddy", FaultKind.AFFORDANCE, "dry"),
        ("dirty muddy", FaultKind.AFFORDANCE, "dry"),
    ],
)
def test_an_action_whose_tries_all_fail_reports_all_their_reasons(
    before: str, kind: FaultKind, reason: str
) -> None:
    (step,) = run(before, "CLEAN").steps
    assert step.fault is not None
    assert (step.fault.kind, step.fault.check.reason) == (kind, reason)


def test_the_precedence_of_the_domain_chooses_the_kind_of_fault() -> None:
    order = (FaultKind.MISSING_STEP, FaultKind.AFFORDANCE)
    (step,) = run("dirty muddy", "CLEAN", domain=replace(DOMAIN, precedence=order)).steps
    assert step.fault is not None
    assert (step.fault.kind, step.fault.check.reason) == (FaultKind.MISSING_STEP, "no soap")


@pytest.mark.parametrize(
    ("before", "undone"),
    [
        ("dirty soap muddy wet", []),
        ("dirty soap muddy", ["dry"]),
        ("dirty muddy wet", ["no soap"]),
        ("dirty soap wet", []),
    ],
)
def test_the_failed_tries_of_an_action_are_found(before: str, undone: list[str]) -> None:
    trajectory = run(before, "CLEAN")
    operator, start = DOMAIN.compiled_operators["CLEAN"], trajectory.states[0]
    left = operator.find_failed_operator_alternatives(start, trajectory.final_state, operator.bind(start, ()))
    assert [each.check.reason for each in left] == undone


def test_an_operator_has_its_other_effects_if_no_try_is_made() -> None:
    operator = replace(CLEAN, checks=())
    assert facts(run("wet soap", "CLEAN", domain=DOMAIN.replace_operators(operator))) == "soap"


def test_checks_of_tries_are_also_sorted_as_in_the_paper() -> None:
    mixed = (missing_step(SOAP(), "no soap"), additional_step(DIRTY(), "clean"), affordance(WET(), "dry"))
    operator = replace(CLEAN, alternatives=(OperatorAlternative(DIRTY(), mixed, ()),))
    (ordered,) = sort_checks_in_paper_order(operator).alternatives
    assert [check.reason for check in ordered.checks] == ["dry", "clean", "no soap"]


def test_checks_of_a_kind_that_the_paper_lacks_come_first() -> None:
    checks = (affordance(WET(), "dry"), Check(SOAP(), FaultKind.UNCATEGORISED, "abort"))
    ordered = sort_checks_in_paper_order(replace(CLEAN, checks=checks))
    assert [check.reason for check in ordered.checks] == ["abort", "dry"]


def wrong_order_of(domain: Domain, *sought: Formula) -> tuple[FaultKind, int | None]:
    """Return the outcomes of washing with soap that was there before, under both rules."""
    check = missing_step(SOAP() & WET(), "no water or no soap", sought or None)
    wash = Operator("WASH", (), (check,), ())
    domain = domain.replace_operators(wash)
    fault = run("dirty", "TAKE", "LOSE", "WASH", domain=domain).steps[-1].fault
    assert fault is not None
    return fault.kind, fault.earlier


def test_the_history_rules_differ_on_conditions_that_held_at_different_times() -> None:
    apart = replace(DOMAIN, history_rule=find_when_conditions_held)
    assert wrong_order_of(apart, SOAP()) == (FaultKind.WRONG_ORDER, 1)
    assert wrong_order_of(apart, SOAP(), DIRTY()) == (FaultKind.WRONG_ORDER, 2)
    assert wrong_order_of(apart) == (FaultKind.MISSING_STEP, None)
    assert wrong_order_of(DOMAIN, SOAP()) == (FaultKind.MISSING_STEP, None)


@pytest.mark.parametrize(
    ("before", "names", "expected"),
    [
        ("dirty", ("TAKE", "LOSE", "CLEAN"), (FaultKind.WRONG_ORDER, 1)),
        ("dirty soap", ("LOSE", "CLEAN"), (FaultKind.WRONG_ORDER, 0)),
        ("dirty", ("LOSE", "CLEAN"), (FaultKind.MISSING_STEP, None)),
    ],
)
def test_an_action_that_was_possible_in_an_earlier_state_is_in_the_wrong_order(
    before: str, names: tuple[str, ...], expected: tuple[FaultKind, int | None]
) -> None:
    fault = run(before, *names).steps[-1].fault
    assert fault is not None
    assert (fault.kind, fault.earlier) == expected


@pytest.mark.parametrize("rule", [find_when_conditions_held, find_when_action_was_possible])
def test_a_step_that_fails_repeatedly_tests_every_state_once(rule: HistoryRule) -> None:
    times = 0

    def never(state: State, arguments: tuple[int, ...]) -> bool:
        nonlocal times
        times += 1
        return False

    ready = ComputedPredicate("ready", 0, never, ())
    vocabulary = Vocabulary((WET, DIRTY, MUDDY, SOAP), (ready,))
    dry = Operator("DRY", (), (missing_step(ready(), "not ready"),), ())
    domain = Domain("bath", vocabulary, (TAKE, LOSE, dry), rule)
    history = History(Scene(vocabulary, (WorldObject("it", "thing"),)).state(()))
    for number in range(300):
        after = attempt_action(domain, history, Action(("TAKE", "LOSE")[number % 2], ()))
        assert isinstance(after, State)
        history = history.extend(after)
        assert isinstance(attempt_action(domain, history, Action("DRY", ())), Fault)
    assert times < 10 * 300


def test_a_condition_that_never_held_gives_no_wrong_order() -> None:
    silent = replace(CLEAN.alternatives[0], checks=(missing_step(SOAP(), "no soap", (FALSE,)),))
    domain = DOMAIN.replace_operators(replace(CLEAN, alternatives=(silent,)))
    fault = run("dirty", "TAKE", "LOSE", "CLEAN", domain=domain).steps[-1].fault
    assert fault is not None
    assert fault.kind is FaultKind.MISSING_STEP


def test_a_domain_declares_visible_objects_and_landmarks() -> None:
    state = toy.initial()
    everything = state.scene.everything
    assert toy.DOMAIN.visible_object_filter(state, everything) == everything
    assert toy.DOMAIN.initially_known_object_filter(state, everything) == 0
    limited = replace(toy.DOMAIN, visible=toy.beside(toy.X), landmarks=is_a(toy.X, "place"))
    assert state.scene.names(limited.visible_object_filter(state, everything)) == ("robot", "red")
    assert state.scene.names(limited.initially_known_object_filter(state, everything)) == ("hall", "shed")
