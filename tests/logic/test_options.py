"""Ground options: listed, counted, and compared with bddl's own on every goal of the data set."""

from __future__ import annotations

from itertools import islice
from math import factorial, prod
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings

from eai.errors import InputError
from eai.logic.formula import Exactly, Formula, Occurs
from eai.logic.options import Option, count_options, options
from eai.logic.semantics import holds
from eai.logic.trace import TakenAction, Trace
from eai.logic.traversal import walk
from logic.activities import as_list, records, universe
from logic.bddl_text import read_condition
from logic.naive import Facts
from logic.random_formulas import SCENE, formulas, traces
from sweeps import examples


def listed(formula: Formula, facts: Facts) -> list[Option]:
    try:
        return list(options(formula, facts.objects))
    except InputError:
        assume(False)
        raise


@given(formulas(depth=2, temporal=False), traces())
@settings(max_examples=examples(120), deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_a_goal_holds_where_one_of_its_options_does(
    formula: Formula, given_: tuple[list[Facts], list[TakenAction]]
) -> None:
    assume(not any(isinstance(part, (Exactly, Occurs)) for part in walk(formula)))
    state = Trace([given_[0][0]])
    found = listed(formula, given_[0][0])
    assert holds(formula, state) == any(all(holds(c, state) for c in option) for option in found)


@given(formulas(depth=2, temporal=False))
@settings(max_examples=examples(120), deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_counting_agrees_with_listing(formula: Formula) -> None:
    facts = Facts(frozenset(), SCENE)
    found = listed(formula, facts)
    assert count_options(formula, facts.objects) == len(found)


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
        ("(forn (6) (?y - b) (open ?y))", 0),
        ("(forn (999999999) (?y - b) (open ?y))", 0),
        ("(fornpairs (999999999) (?x - a) (?y - b) (in ?x ?y))", 0),
        ("(forall (?y - b) (exists (?x - a) (in ?x ?y)))", 32),
        ("(not (forall (?y - b) (open ?y)))", 5),
        ("(exists (?x - nothing) (open ?x))", 0),
        ("(forall (?x - nothing) (open ?x))", 1),
    ],
)
def test_numbers_of_options(text: str, count: int) -> None:
    formula = read_condition(text)
    objects = universe(a=2, b=5).objects
    assert count_options(formula, objects) == count == len(list(options(formula, objects)))


def test_options_come_in_order_of_the_formula_and_the_objects() -> None:
    formula = read_condition("(and (or (p a) (q a)) (forpairs (?x - b) (?y - c) (not (in ?x ?y))))")
    found = [[as_list(c) for c in option] for option in options(formula, universe(b=1, c=2).objects)]
    assert found == [
        [["p", "a"], ["not", ["in", "b0", "c0"]]],
        [["p", "a"], ["not", ["in", "b0", "c1"]]],
        [["q", "a"], ["not", ["in", "b0", "c0"]]],
        [["q", "a"], ["not", ["in", "b0", "c1"]]],
    ]


def test_huge_numbers_of_options_are_counted_and_listed_lazily() -> None:
    objects = universe(a=40, b=40).objects
    formula = read_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))")
    assert count_options(formula, objects) == factorial(40)
    assert len(list(islice(options(formula, objects), 3))) == 3


def test_huge_goals_are_decided_by_matching() -> None:
    names = [f"{kind}{i}" for kind in "ab" for i in range(100)]
    everything = tuple((name, name[0]) for name in names)
    pairs = {("in", (f"a{i}", f"b{j}")) for i in range(100) for j in (i, (i + 1) % 100)}
    formula = read_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))")
    assert holds(formula, Trace([Facts(frozenset(pairs), everything)]))
    crowded = {("in", (a, b)) for _, (a, b) in pairs if b not in ("b0", "b1")} | {("in", ("a0", "b0"))}
    assert not holds(formula, Trace([Facts(frozenset(crowded), everything)]))


def test_numbers_of_options_are_those_of_the_reference(oracle: Any) -> None:
    for task, (goals, objects, expected) in records(oracle).items():
        counts = [count_options(goal, objects) for goal in goals]
        assert prod(counts) == expected, task
        assert counts == [len(list(options(goal, objects))) for goal in goals]


def test_the_average_task_has_the_papers_number_of_options(oracle: Any) -> None:
    total = sum(prod(count_options(g, o) for g in goals) for goals, o, _ in records(oracle).values())
    assert round(total / 100, 2) == 4164.41
