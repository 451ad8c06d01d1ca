"""Ground options: listed, counted, and compared with bddl's own on every goal of the data set."""

from __future__ import annotations

from itertools import islice
from math import factorial, prod
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings

from eai.errors import InputError
from eai.logic.bddl import parse_condition
from eai.logic.choice import Literal
from eai.logic.formula import And, Atom, Exactly, Formula, Not, Occurs, Variable
from eai.logic.ltl import parse
from eai.logic.options import Option, count_options, options
from eai.logic.semantics import holds_in
from eai.logic.trajectory import Action
from eai.logic.traversal import walk
from eai.logic.truncated_options import truncated_options
from logic.naive import Facts
from logic.random_formulas import SCENE, formulas, trajectories


def universe(**sizes: int) -> Facts:
    return Facts(
        frozenset(), tuple((f"{kind}{i}", kind) for kind, size in sizes.items() for i in range(size))
    )


def listed(formula: Formula, objects: Facts) -> list[Option]:
    try:
        return list(options(formula, objects))
    except InputError:
        assume(False)
        raise


@given(formulas(depth=2, temporal=False), trajectories())
@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_a_goal_holds_where_one_of_its_options_does(
    formula: Formula, given_: tuple[list[Facts], list[Action]]
) -> None:
    assume(not any(isinstance(part, (Exactly, Occurs)) for part in walk(formula)))
    state = given_[0][0]
    found = listed(formula, state)
    assert holds_in(formula, state) == any(all(holds_in(c, state) for c in option) for option in found)


@given(formulas(depth=2, temporal=False))
@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_counting_agrees_with_listing(formula: Formula) -> None:
    objects = Facts(frozenset(), SCENE)
    found = listed(formula, objects)
    assert count_options(formula, objects) == len(found)


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("(forpairs (?x - a) (?y - b) (in ?x ?y))", 20),
        ("(forpairs (?y - b) (?x - a) (in ?x ?y))", 20),
        ("(forpairs (?x - a) (?y - a) (in ?x ?y))", 1),
        ("(forpairs (?x - b) (?y - b) (in ?x ?y))", 44),
        ("(fornpairs (1) (?x - a) (?y - b) (in ?x ?y))", 10),
        ("(fornpairs (3) (?x - a) (?y - b) (in ?x ?y))", 0),
        ("(forpairs (?x - a) (?y - b) (or (in ?x ?y) (on ?x ?y)))", 80),
        ("(forn (2) (?y - b) (open ?y))", 10),
        ("(forn (2) (?y - b) (or (open ?y) (red ?y)))", 40),
        ("(forall (?y - b) (exists (?x - a) (in ?x ?y)))", 32),
        ("(not (forall (?y - b) (open ?y)))", 5),
        ("(exists (?x - nothing) (open ?x))", 0),
        ("(forall (?x - nothing) (open ?x))", 1),
    ],
)
def test_numbers_of_options(text: str, count: int) -> None:
    formula = parse_condition(text).formula
    objects = universe(a=2, b=5)
    assert count_options(formula, objects) == count == len(list(options(formula, objects)))


def test_options_come_in_order_of_the_formula_and_the_objects() -> None:
    formula = parse_condition("(and (or (p a) (q a)) (forpairs (?x - b) (?y - c) (not (in ?x ?y))))").formula
    found = [[as_list(c) for c in option] for option in options(formula, universe(b=1, c=2))]
    assert found == [
        [["p", "a"], ["not", ["in", "b0", "c0"]]],
        [["p", "a"], ["not", ["in", "b0", "c1"]]],
        [["q", "a"], ["not", ["in", "b0", "c0"]]],
        [["q", "a"], ["not", ["in", "b0", "c1"]]],
    ]


def test_huge_numbers_of_options_are_counted_and_listed_lazily() -> None:
    objects = universe(a=40, b=40)
    formula = parse_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))").formula
    assert count_options(formula, objects) == factorial(40)
    assert len(list(islice(options(formula, objects), 3))) == 3


def test_huge_goals_are_decided_by_matching() -> None:
    names = [f"{kind}{i}" for kind in "ab" for i in range(100)]
    everything = tuple((name, name[0]) for name in names)
    pairs = {("in", (f"a{i}", f"b{j}")) for i in range(100) for j in (i, (i + 1) % 100)}
    formula = parse_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))").formula
    assert holds_in(formula, Facts(frozenset(pairs), everything))
    crowded = {("in", (a, b)) for _, (a, b) in pairs if b not in ("b0", "b1")} | {("in", ("a0", "b0"))}
    assert not holds_in(formula, Facts(frozenset(crowded), everything))


@pytest.mark.parametrize(
    "text",
    [
        "not forn 2 x. (p(x))",
        "not (p() then q())",
        "always p()",
        "forn 1 x. (not forpairs x: a, y: a. (r(x, y)))",
    ],
)
def test_what_leaves_no_finite_choice_is_an_error(text: str) -> None:
    with pytest.raises(InputError, match="no finite choice"):
        list(options(parse(text).formula, universe(a=2)))


def test_unbound_variables_are_an_error() -> None:
    unbound = And((Atom("p", (Variable("x"),)),))
    with pytest.raises(InputError, match="variable x is not bound"):
        list(options(unbound, universe()))
    with pytest.raises(InputError, match="variable x is not bound"):
        truncated_options(unbound, universe())


def as_list(literal: Literal) -> list[Any]:
    if isinstance(literal, Not):
        assert isinstance(literal.operand, (Atom, Not))
        return ["not", as_list(literal.operand)]
    assert isinstance(literal, Atom)
    return [literal.predicate, *(term.name for term in literal.arguments)]


def as_text(tree: list[Any] | str) -> str:
    return tree if isinstance(tree, str) else f"({' '.join(map(as_text, tree))})"


def records(oracle: Any) -> dict[str, tuple[list[Formula], Facts, int]]:
    """Task -> its goals, its objects, and the reference's number of goal options."""
    found = {}
    for task, record in oracle("behavior", "", "reconstructed").items():
        goals = [parse_condition(as_text(goal)).formula for goal in record["bddl_goal"]]
        objects = tuple((thing["bddl_instance"], thing["category"]) for thing in record["objects"])
        found[task] = (goals, Facts(frozenset(), objects), record["n_goal_options"])
    return found


def test_numbers_of_options_are_those_of_the_reference(oracle: Any) -> None:
    for task, (goals, objects, expected) in records(oracle).items():
        counts = [count_options(goal, objects) for goal in goals]
        assert prod(counts) == expected, task
        assert counts == [len(list(options(goal, objects))) for goal in goals]


def test_the_average_task_has_the_papers_number_of_options(oracle: Any) -> None:
    total = sum(prod(count_options(g, o) for g in goals) for goals, o, _ in records(oracle).values())
    assert round(total / 100, 2) == 4164.41


def test_truncated_options_are_those_of_the_reference(oracle: Any) -> None:
    expected = oracle("behavior", "", "goal_options_truncated")
    for task, (goals, objects, _) in records(oracle).items():
        found = [[list(map(as_list, o)) for o in truncated_options(goal, objects)] for goal in goals]
        assert found == expected[task], task


def test_truncation_loses_options_of_large_pairings() -> None:
    formula = parse_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))").formula
    assert len(truncated_options(formula, universe(a=4, b=4))) == 10
    assert len(truncated_options(formula, universe(a=3, b=3))) == 6


def test_truncation_loses_the_last_options_of_small_products() -> None:
    formula = parse_condition("(forall (?x - a) (exists (?y - b) (in ?x ?y)))").formula
    objects = universe(a=2, b=2)
    missing = set(options(formula, objects)) - set(truncated_options(formula, objects))
    assert missing == set()
    assert (
        len(truncated_options(formula, universe(a=5, b=2))) < count_options(formula, universe(a=5, b=2)) == 32
    )


def test_negated_goals_choose_one_condition_of_every_option() -> None:
    formula = parse_condition("(imply (or (p a) (and (q a) (r a))) (not (s a)))").formula
    found = [list(map(as_list, option)) for option in truncated_options(formula, universe())]
    assert found == [
        [["not", ["p", "a"]], ["not", ["q", "a"]]],
        [["not", ["p", "a"]], ["not", ["r", "a"]]],
        [["not", ["s", "a"]]],
    ]
