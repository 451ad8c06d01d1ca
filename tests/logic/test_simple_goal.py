"""Simple goals: expansion, and scores that equal the best over the whole expansion."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from eai.errors import InputError
from eai.logic.choice import Literal
from eai.logic.formula import Atom, Constant, Formula, Not, Occurs
from eai.logic.ltl import parse
from eai.logic.signature import Signature
from eai.logic.simple_goal import (
    Overlap,
    Satisfaction,
    SimpleGoal,
    best_overlap,
    count_simple_goals,
    partial_success,
    simple_goals,
)
from eai.logic.trajectory import Action, Trajectory
from logic.naive import Facts
from logic.random_formulas import ACTIONS, PREDICATES, SCENE, formulas, trajectories

SIGNATURE = Signature({"p": 1, "in": 2}, {"GRAB": 1, "WASH": 1, "POUR": 2})
OBJECTS = Facts(frozenset(), (("a", "cup"), ("b", "cup"), ("c", "shelf"), ("d", "shelf")))
MIXED = [HealthCheck.filter_too_much, HealthCheck.too_slow]


def goal(text: str) -> Formula:
    return parse(text, SIGNATURE).formula


def grab(name: str) -> Occurs:
    return Occurs("GRAB", (Constant(name),))


def p(name: str) -> Atom:
    return Atom("p", (Constant(name),))


def test_expansion_into_ordered_actions_and_a_conjunction() -> None:
    found = list(simple_goals(goal("exists x: cup. (GRAB(x)) then WASH(a) then p(c) and not p(d)"), OBJECTS))
    wash = Occurs("WASH", (Constant("a"),))
    final: frozenset[Literal] = frozenset({p("c"), Not(p("d"))})
    assert found == [SimpleGoal((grab("a"), wash), final), SimpleGoal((grab("b"), wash), final)]
    assert found[0].conditions() == {grab("a"), wash, p("c"), Not(p("d"))}


def test_expansion_is_lazy_and_counted_without_it() -> None:
    many = Facts(frozenset(), tuple((f"o{i}", "thing") for i in range(30)))
    formula = goal("exists x. (GRAB(x)) then forall x. (exists y. (in(x, y)))")
    assert next(simple_goals(formula, many)).actions == (grab("o0"),)
    assert count_simple_goals(formula, many) == 30 * 30**30


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("p(a) then GRAB(a)", "a proposition comes before 'then'"),
        ("GRAB(a) then (p(a) or GRAB(b)) then p(b)", "a proposition comes before 'then'"),
        ("not GRAB(a)", "an action is negated"),
        ("GRAB(a) implies p(a)", "an action is negated"),
        ("eventually p(a)", "no finite choice"),
    ],
)
def test_goals_that_are_not_simple(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        list(simple_goals(goal(text), OBJECTS))
    with pytest.raises(InputError, match=message):
        partial_success(goal(text), Trajectory([OBJECTS]))


def f1(overlap: Overlap) -> Fraction:
    return Fraction(2 * overlap.shared, max(1, overlap.predicted + overlap.gold))


def expansion(formula: Formula, objects: Facts) -> list[SimpleGoal]:
    try:
        assume(0 < count_simple_goals(formula, objects) < 2000)
        return list(simple_goals(formula, objects))
    except InputError:
        assume(False)
        raise


def literals() -> st.SearchStrategy[Literal]:
    return formulas(depth=0, beyond_paper=False).flatmap(
        lambda atom: st.sampled_from([atom, Not(atom)] if isinstance(atom, Atom) else [atom])
    )


@given(formulas(depth=2, temporal=False), st.frozensets(literals(), max_size=6))
@settings(max_examples=120, deadline=None, suppress_health_check=MIXED)
def test_overlap_is_the_best_over_the_expansion(formula: Formula, predicted: frozenset[Literal]) -> None:
    objects = Facts(frozenset(), SCENE)
    every = [goal.conditions() for goal in expansion(formula, objects)]
    best = max(f1(Overlap(len(gold & predicted), len(predicted), len(gold))) for gold in every)
    assert f1(best_overlap(predicted, formula, objects)) == best


def common_subsequence(wanted: tuple[Occurs, ...], taken: list[Action]) -> int:
    if not wanted or not taken:
        return 0
    first = Action(wanted[0].action, tuple(term.name for term in wanted[0].arguments))
    best = common_subsequence(wanted[1:], taken)
    if first in taken:
        best = max(best, 1 + common_subsequence(wanted[1:], taken[taken.index(first) + 1 :]))
    return best


@given(formulas(depth=2, beyond_paper=False), trajectories())
@settings(max_examples=120, deadline=None, suppress_health_check=MIXED)
def test_partial_success_is_the_best_over_the_expansion(
    formula: Formula, given_: tuple[list[Facts], list[Action]]
) -> None:
    states, actions = given_
    last = states[-1]

    def true(literal: Literal) -> bool:
        atom = literal.operand if isinstance(literal, Not) else literal
        assert isinstance(atom, Atom)
        names = tuple(term.name for term in atom.arguments)
        return last.holds(atom.predicate, names) != isinstance(literal, Not)

    shares = []
    for one in expansion(formula, last):
        satisfied = common_subsequence(one.actions, actions) + sum(map(true, one.propositions))
        shares.append(Fraction(satisfied, max(1, len(one.actions) + len(one.propositions))))
    found = partial_success(formula, Trajectory(states, actions))
    assert Fraction(found.satisfied, max(1, found.total)) == max(shares)


def test_pairings_are_scored_by_matching() -> None:
    size = 40
    things = tuple((f"{kind}{i}", kind) for kind in "ab" for i in range(size))
    formula = goal("forpairs x: a, y: b. (in(x, y)) and exists x: a. (p(x) and p(b3))")
    predicted = {
        Atom("in", (Constant(f"a{i}"), Constant(f"b{(i + j) % size}"))) for i in range(30) for j in (0, 1)
    }
    overlap = best_overlap(predicted | {p("a7")}, formula, Facts(frozenset(), things))
    assert overlap == Overlap(31, 61, 42)


def test_pairs_that_share_conditions_count_them_once() -> None:
    formula = goal("forpairs x: cup, y: shelf. (p(x) and in(a, y))")
    shared = best_overlap({p("a"), p("b")}, formula, OBJECTS)
    assert shared == Overlap(2, 2, 4)
    assert best_overlap({p("a")}, goal("p(a) and (p(a) or p(b))"), OBJECTS) == Overlap(1, 1, 1)


def test_actions_count_as_far_as_their_order_goes() -> None:
    formula = goal("GRAB(a) then WASH(a) then GRAB(b) then p(a) and p(b)")
    end = Facts(frozenset({("p", ("b",))}), OBJECTS.categories)
    taken = [Action("GRAB", ("b",)), Action("WASH", ("a",)), Action("GRAB", ("b",))]
    assert partial_success(formula, Trajectory([end] * 4, taken)) == Satisfaction(3, 5)


def test_rare_actions_of_many_objects() -> None:
    many = Facts(frozenset(), tuple((f"o{i}", "thing") for i in range(60)))
    formula = goal("exists x. (exists y. (POUR(x, y))) then exists x. (GRAB(x)) then p(o1)")
    path = Trajectory([many] * 2, [Action("POUR", ("o7", "o8"))])
    assert partial_success(formula, path) == Satisfaction(1, 3)


def test_goals_that_nothing_can_make_true() -> None:
    with pytest.raises(InputError, match="nothing can make this goal true"):
        best_overlap(frozenset(), goal("exists x: nothing. (p(x))"), OBJECTS)
    with pytest.raises(InputError, match="nothing can make this goal true"):
        partial_success(goal("fornpairs 3 x: cup, y: shelf. (in(x, y))"), Trajectory([OBJECTS]))


def test_the_vocabulary_of_the_random_formulas_is_disjoint() -> None:
    assert not set(PREDICATES) & set(ACTIONS)
