from __future__ import annotations

from dataclasses import replace

import pytest

from eai.benchmarks.reference import virtualhome_domain
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import Atom, Variable
from eai.world.conformance import check
from eai.world.derived import Defined
from eai.world.domain import Domain
from eai.world.effect import Add
from eai.world.fault import FaultKind
from eai.world.operator import Check, Operator, missing
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy

X = Variable("x")


def test_the_toy_domain_conforms() -> None:
    assert check(toy.DOMAIN, [toy.initial()]) == ()


@pytest.mark.parametrize(
    "domain", [virtualhome.as_meant(), virtualhome_domain.as_in_reference()], ids=["strict", "eai"]
)
def test_virtualhome_conforms(virtualhome_tasks: VirtualHomeTasks, domain: Domain) -> None:
    assert check(domain, [virtualhome_tasks[i].initial for i in ("27_2", "1003_2")], steps=150) == ()


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


def test_a_rule_that_points_outside_the_trajectory_is_found() -> None:
    wrong = Domain("toy", toy.VOCABULARY, toy.DOMAIN.operators, history_rule=lambda *_: 10_000)
    assert any("outside the trajectory" in finding.problem for finding in check(wrong, [toy.initial()]))
