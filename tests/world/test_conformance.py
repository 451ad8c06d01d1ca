from __future__ import annotations

from itertools import cycle

import pytest

from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import TRUE, Atom, Formula, Variable
from eai.world.conformance import check_domain
from eai.world.derived import ComputedPredicate
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, When
from eai.world.frame import AGENT
from eai.world.operator import Operator, additional_step, missing_step
from eai.world.state import Scene
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy

X, Y = Variable("x"), Variable("y")


def test_the_toy_domain_conforms() -> None:
    assert check_domain(toy.DOMAIN, [toy.initial()]) == ()


@pytest.fixture
def domain() -> Domain:
    """Return the domain by the paper's rules. Tests of other rules override this fixture."""
    return virtualhome.make_domain_with_checks_in_paper_order()


def test_virtualhome_conforms(virtualhome_tasks: VirtualHomeTasks, domain: Domain) -> None:
    assert check_domain(domain, [virtualhome_tasks[i].initial for i in ("27_2", "1003_2")], steps=150) == ()


def additional_where(condition: Formula, *effects: Effect) -> Domain:
    needless = additional_step(~condition, "{x} needs it no more")
    return toy.DOMAIN.replace_operators(Operator("PRESS", (X,), (needless,), effects))


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
    found = {*check_domain(domain, [toy.initial()])}
    expected = f"PRESS: an additional step that would bring about {still_to_come}"
    assert found == (set() if still_to_come is None else {expected})


def test_an_invisible_change_is_not_an_intended_effect() -> None:
    vocabulary = Vocabulary((*toy.VOCABULARY.predicates, NOTED), toy.VOCABULARY.derived)
    press = Operator("PRESS", (X,), (additional_step(~TRUE, "never"),), (Add(NOTED(X)),))
    state = Scene(vocabulary, toy.initial().scene.objects, agent=0).state([])
    assert check_domain(Domain("toy", vocabulary, (press,)), [state]) == ()


TURNS = cycle((False, False, True))


def one_operator(operator: Operator, *derived: ComputedPredicate) -> Domain:
    return Domain("bad", Vocabulary(toy.VOCABULARY.predicates, derived), (operator,))


def test_a_broken_law_of_execution_is_reported() -> None:
    moody = missing_step(Atom("moody", (X,)), "it is not in the mood")
    turns = ComputedPredicate("moody", 1, lambda *_: next(TURNS), ())
    domain = one_operator(Operator("TRY", (X,), (moody,), ()), turns)
    state = Scene(domain.vocabulary, toy.initial().scene.objects, agent=0).state([])
    assert check_domain(domain, [state]) == ("TRY: the same action in the same state has two outcomes",)


def test_a_walk_without_possible_actions_ends_at_once() -> None:
    state = Scene(toy.VOCABULARY, {}).state([])
    for operators in ((), (Operator("PRESS", (X,), (), ()),)):
        assert check_domain(Domain("toy", toy.VOCABULARY, operators), [state]) == ()


def test_a_state_of_another_vocabulary_is_reported() -> None:
    vocabulary = Vocabulary((*toy.VOCABULARY.predicates, NOTED), toy.VOCABULARY.derived)
    other = Domain("bad", vocabulary, toy.DOMAIN.operators)
    assert check_domain(other, [toy.initial()]) == ("bad: a state belongs to another vocabulary",)


@pytest.mark.parametrize(("earlier", "outside"), [(-1, True), (0, False), (10_000, True)])
def test_a_history_rule_that_points_outside_the_trajectory_is_reported(earlier: int, outside: bool) -> None:
    rule = Domain("toy", toy.VOCABULARY, toy.DOMAIN.operators, history_rule=lambda *_: earlier)
    found = check_domain(rule, [toy.initial()])
    assert any("outside the trajectory" in problem for problem in found) is outside
