from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle

import pytest

from eai.households.virtualhome import domain as virtualhome
from eai.households.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import TRUE, Atom, Formula, Variable
from eai.world.conformance import check
from eai.world.derived import Computed, Defined
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, When
from eai.world.fault import FaultKind
from eai.world.frame import AGENT
from eai.world.operator import Check, Operator, additional, missing
from eai.world.state import Scene
from eai.world.vocabulary import Predicate, Vocabulary
from protocols import of_reference
from world import toy

X, Y = Variable("x"), Variable("y")


def test_the_toy_domain_conforms() -> None:
    assert check(toy.DOMAIN, [toy.initial()]) == ()


@pytest.mark.parametrize(
    "declared",
    [virtualhome.as_meant, lambda: of_reference("virtualhome_quirks").as_in_reference()],
    ids=["strict", "eai"],
)
def test_virtualhome_conforms(virtualhome_tasks: VirtualHomeTasks, declared: Callable[[], Domain]) -> None:
    assert check(declared(), [virtualhome_tasks[i].initial for i in ("27_2", "1003_2")], steps=150) == ()


def additional_where(condition: Formula, *effects: Effect) -> Domain:
    needless = additional(~condition, "{x} needs it no more")
    return toy.DOMAIN.with_operators(Operator("PRESS", (X,), (needless,), effects))


HELD, LIT, NOTED = toy.holding(X), toy.lit(X), Predicate("noted", 1, visible=False)


@pytest.mark.parametrize(
    ("domain", "still_to_come"),
    [
        (additional_where(LIT, Add(LIT)), None),
        (additional_where(~LIT, Delete(LIT)), None),
        (additional_where(TRUE, Add(LIT)), "lit(x)"),
        (additional_where(TRUE, Delete(toy.at(AGENT, X))), "not at(agent, x)"),
        (additional_where(TRUE, When(LIT, (Add(HELD),), (Add(LIT),))), "holding(x) or lit(x)"),
        (additional_where(HELD | LIT, When(LIT, (Add(HELD),), (Add(LIT),))), None),
        (additional_where(TRUE, When(~LIT, (Add(LIT),))), None),
        (additional_where(TRUE, ForEach(Y, toy.at(Y, X), (Add(toy.lit(Y)),))), None),
        (additional_where(TRUE, Delete(toy.at(X, ANYTHING))), None),
        (additional_where(TRUE, Delete(LIT), Add(LIT)), "lit(x)"),
        (additional_where(TRUE, Add(LIT), When(TRUE, (Delete(LIT),))), None),
    ],
)
def test_a_step_is_additional_only_if_its_intended_effect_is_there(
    domain: Domain, still_to_come: str | None
) -> None:
    found = {str(defect) for defect in check(domain, [toy.initial()])}
    expected = f"PRESS: an additional step that would bring about {still_to_come}"
    assert found == (set() if still_to_come is None else {expected})


def test_what_cannot_be_seen_is_no_intended_effect() -> None:
    vocabulary = Vocabulary((*toy.VOCABULARY.predicates, NOTED), toy.VOCABULARY.derived)
    press = Operator("PRESS", (X,), (additional(~TRUE, "never"),), (Add(NOTED(X)),))
    state = Scene(vocabulary, toy.initial().scene.objects, agent=0).state([])
    assert check(Domain("toy", vocabulary, (press,)), [state]) == ()


def defined_as(name: str, other: str) -> Defined:
    return Defined(name, (X,), ~Atom(other, (X,)))


def with_operator(operator: Operator) -> Domain:
    return toy.DOMAIN.with_operators(operator)


@pytest.mark.parametrize(
    ("domain", "problem"),
    [
        (with_operator(Operator("BAD", (X, X), (), ())), "BAD: two parameters have one name"),
        (
            with_operator(Operator("BAD", (X,), (missing(toy.lit(X), "{y} is dark"),), ())),
            "BAD: the reason of check 1 mentions y, no parameter",
        ),
        (
            with_operator(Operator("BAD", (X,), (Check(toy.lit(X), FaultKind.PARSING, "no"),), ())),
            "BAD: check 1 names parsing, which no check can find",
        ),
        (
            with_operator(Operator("BAD", (X,), (missing(toy.lit(X), ""),), ())),
            "BAD: check 1 gives no reason",
        ),
        (with_operator(Operator("BAD", (X,), (), (Add(Predicate("new", 1)(X)),))), "not a stored predicate"),
        (
            Domain("bad", Vocabulary((toy.lit,), (Defined("d", (X,), toy.at(X, X)),)), ()),
            "d: predicate at is not declared",
        ),
        (
            Domain("bad", Vocabulary((), (defined_as("d", "d"),)), ()),
            "d: derived predicate d is defined by itself",
        ),
        (
            Domain(
                "bad",
                Vocabulary((), (Defined("c", (X,), Atom("d", (X,))), Defined("d", (X,), Atom("c", (X,))))),
                (),
            ),
            "d: derived predicate d is defined by itself",
        ),
        (replace(toy.DOMAIN, visible=toy.lit(Variable("y"))), "what is visible: variable y is not bound"),
        (replace(toy.DOMAIN, landmarks=Atom("new", (X,))), "landmarks: predicate new is not declared"),
    ],
)
def test_what_does_not_conform_is_found(domain: Domain, problem: str) -> None:
    assert any(problem in str(defect) for defect in check(domain, [toy.initial()]))


FIXED = Predicate("fixed", 1, static=True)
TURNS = cycle((False, False, True))


def one_operator(operator: Operator, *derived: Computed) -> Domain:
    return Domain("bad", Vocabulary((*toy.VOCABULARY.predicates, FIXED), derived), (operator,))


@pytest.mark.parametrize(
    ("domain", "problem"),
    [
        (one_operator(Operator("MEND", (X,), (), (Add(FIXED(X)),))), "bad: operator MEND: an effect changes"),
        (
            one_operator(
                Operator("TRY", (X,), (missing(Atom("moody", (X,)), "it is not in the mood"),), ()),
                Computed("moody", 1, lambda *_: next(TURNS), ()),
            ),
            "TRY: the same action in the same state has two outcomes",
        ),
    ],
)
def test_what_breaks_a_law_of_execution_is_found(domain: Domain, problem: str) -> None:
    state = Scene(domain.vocabulary, toy.initial().scene.objects, agent=0).state([])
    found = check(domain, [state])
    assert [str(defect)[: len(problem)] for defect in found] == [problem]


def test_a_state_of_another_vocabulary_is_found() -> None:
    other = one_operator(Operator("WAIT", (), (), ()))
    assert [str(defect) for defect in check(other, [toy.initial()])] == [
        "bad: a state belongs to another vocabulary"
    ]


@pytest.mark.parametrize(("earlier", "outside"), [(-1, True), (0, False), (10_000, True)])
def test_a_rule_that_points_outside_the_trajectory_is_found(earlier: int, outside: bool) -> None:
    """The state at the start is within."""
    rule = Domain("toy", toy.VOCABULARY, toy.DOMAIN.operators, history_rule=lambda *_: earlier)
    found = [finding.problem for finding in check(rule, [toy.initial()])]
    assert any("outside the trajectory" in problem for problem in found) is outside
