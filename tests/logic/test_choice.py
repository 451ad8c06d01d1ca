"""Grounding a formula into its tree of choices."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from math import factorial, prod
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from eai.base.errors import InputError
from eai.logic.choice import (
    AndNode,
    AndOrTree,
    AndOrTreeLiteral,
    BipartiteMatchingNode,
    DnfTerm,
    ExactCountNode,
    Literal,
    OrNode,
    build_and_or_tree,
    count_dnf_terms,
    generate_dnf_terms,
    generate_dnf_terms_of_tree,
    make_finder_of_dnf_term_closest_to_answer,
)
from eai.logic.formula import And, Atom, Constant, Exactly, Formula, Not, Occurs, Variable
from eai.logic.ltl import parse
from eai.logic.semantics import holds
from eai.logic.trace import TakenAction, Trace
from eai.logic.traversal import walk_subformulas
from logic.activities import as_list, records, universe
from logic.bddl_text import read_condition
from logic.naive import Facts
from logic.random_formulas import SCENE, formulas, traces
from sweeps import examples

if TYPE_CHECKING:
    from eai.benchmarks.behavior.tasks import BehaviorTasks


@pytest.mark.parametrize(
    "text",
    [
        "not forn 2 x. (p(x))",
        "not (p() then q())",
        "always p()",
        "forn 1 x. (not forpairs x: a, y: a. (r(x, y)))",
    ],
)
def test_a_formula_without_a_finite_choice_is_an_error(text: str) -> None:
    with pytest.raises(InputError, match="can become true in infinitely many ways"):
        list(generate_dnf_terms(parse(text), universe(a=2).list_objects))


def test_unbound_variables_are_an_error() -> None:
    unbound = And((Atom("p", (Variable("x"),)),))
    with pytest.raises(InputError, match="variable x is not bound"):
        list(generate_dnf_terms(unbound, universe().list_objects))


def test_a_formula_is_grounded_to_its_tree_of_choices() -> None:
    formula = parse("forall x: a. (not (p(x) and q(x))) and forn 1 y: a. (p(y))")
    p, q = ([AndOrTreeLiteral(Atom(name, (Constant(f"a{i}"),))) for i in range(2)] for name in ("p", "q"))
    negated = [
        OrNode((AndOrTreeLiteral(Not(x.literal)), AndOrTreeLiteral(Not(y.literal))))
        for x, y in zip(p, q, strict=True)
    ]
    tree = build_and_or_tree(formula, universe(a=2).list_objects)
    assert tree == AndNode((AndNode(tuple(negated)), ExactCountNode(1, tuple(p))))


def test_no_object_is_paired_with_itself() -> None:
    formula = parse("forpairs x: a, y: a. (p(x, y))")
    tree = build_and_or_tree(formula, universe(a=2).list_objects)
    cells = [
        [AndOrTreeLiteral(Atom("p", (Constant(f"a{i}"), Constant(f"a{j}")))) for j in range(2)]
        for i in range(2)
    ]
    assert tree == BipartiteMatchingNode(2, ((None, cells[0][1]), (cells[1][0], None)))


def test_equations_are_decided() -> None:
    formula = parse("exists x: a. (x = a1 and not x = a0)")
    assert build_and_or_tree(formula, universe(a=2).list_objects) == OrNode(
        (AndNode((OrNode(()), OrNode(()))), AndNode((AndNode(()), AndNode(()))))
    )


def listed(formula: Formula, facts: Facts) -> list[DnfTerm]:
    try:
        return list(generate_dnf_terms(formula, facts.list_objects))
    except InputError:
        assume(False)
        raise


@given(formulas(depth=2, temporal=False), traces())
@settings(max_examples=examples(120), deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_a_goal_holds_if_and_only_if_one_of_its_options_holds(
    formula: Formula, given_: tuple[list[Facts], list[TakenAction]]
) -> None:
    assume(not any(isinstance(part, (Exactly, Occurs)) for part in walk_subformulas(formula)))
    state = Trace([given_[0][0]])
    found = listed(formula, given_[0][0])
    assert holds(formula, state) == any(all(holds(c, state) for c in option) for option in found)


@given(formulas(depth=2, temporal=False))
@settings(max_examples=examples(120), deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_counting_agrees_with_listing(formula: Formula) -> None:
    facts = Facts(frozenset(), SCENE)
    found = listed(formula, facts)
    assert count_dnf_terms(formula, facts.list_objects) == len(found)


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
def test_options_are_counted(text: str, count: int) -> None:
    formula = read_condition(text)
    objects = universe(a=2, b=5).list_objects
    assert count_dnf_terms(formula, objects) == count == len(list(generate_dnf_terms(formula, objects)))


def test_options_come_in_order_of_the_formula_and_the_objects() -> None:
    formula = read_condition("(and (or (p a) (q a)) (forpairs (?x - b) (?y - c) (not (in ?x ?y))))")
    found = [
        [as_list(c) for c in option]
        for option in generate_dnf_terms(formula, universe(b=1, c=2).list_objects)
    ]
    assert found == [
        [["p", "a"], ["not", ["in", "b0", "c0"]]],
        [["p", "a"], ["not", ["in", "b0", "c1"]]],
        [["q", "a"], ["not", ["in", "b0", "c0"]]],
        [["q", "a"], ["not", ["in", "b0", "c1"]]],
    ]


def test_huge_numbers_of_options_are_counted_and_listed_lazily() -> None:
    objects = universe(a=40, b=40).list_objects
    formula = read_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))")
    assert count_dnf_terms(formula, objects) == factorial(40)
    assert len(list(islice(generate_dnf_terms(formula, objects), 3))) == 3


def test_huge_goals_are_decided_by_matching() -> None:
    names = [f"{kind}{i}" for kind in "ab" for i in range(100)]
    everything = tuple((name, name[0]) for name in names)
    pairs = {("in", (f"a{i}", f"b{j}")) for i in range(100) for j in (i, (i + 1) % 100)}
    formula = read_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))")
    assert holds(formula, Trace([Facts(frozenset(pairs), everything)]))
    crowded = {("in", (a, b)) for _, (a, b) in pairs if b not in ("b0", "b1")} | {("in", ("a0", "b0"))}
    assert not holds(formula, Trace([Facts(frozenset(crowded), everything)]))


def test_the_reference_counts_the_same_numbers_of_options(oracle: Any) -> None:
    for task, (goals, objects, expected) in records(oracle).items():
        counts = [count_dnf_terms(goal, objects) for goal in goals]
        assert prod(counts) == expected, task


def test_real_goals_have_as_many_options_as_counted_and_as_in_the_paper(
    behavior_tasks: BehaviorTasks,
) -> None:
    total = 0
    for task in behavior_tasks.values():
        counts = [count_dnf_terms(goal.formula, task.scene.names_of_category) for goal in task.goals]
        assert counts == [
            len(list(generate_dnf_terms(goal.formula, task.scene.names_of_category))) for goal in task.goals
        ]
        total += prod(counts)
    assert round(total / len(behavior_tasks), 2) == 4164.41


class Numbers:
    """Numbers literals in the order of their first use."""

    def __init__(self) -> None:
        self.of: dict[Literal, int] = {}

    def __call__(self, literal: Literal) -> int:
        return self.of.setdefault(literal, len(self.of))

    def mask(self, is_in: Callable[[Literal], bool]) -> int:
        return sum(1 << number for literal, number in self.of.items() if is_in(literal))


def on_first(literal: Literal) -> bool:
    """Return the mask of all literals about objects numbered 0."""
    return isinstance(literal, Atom) and all(term.name.endswith("0") for term in literal.arguments)


@pytest.mark.parametrize(
    ("text", "shared", "size"),
    [
        ("p(a0)", 1, 1),
        ("not p(a0)", 0, 1),
        ("p(a0) and p(a1)", 1, 2),
        ("p(a1) or p(a0)", 1, 1),
        ("p(a1) and q(a1) or p(a2)", 0, 1),
        ("p(a0) and q(a1) or p(a0)", 1, 1),
        ("p(a1) or p(a0) and q(a0) and q(a1)", 2, 3),
        ("exists x: a. (p(x))", 1, 1),
        ("forall x: a. (p(x))", 1, 3),
        ("forall x: a. (p(x) or q(x) and r(x))", 2, 4),
        ("forn 2 x: a. (p(x))", 1, 2),
        ("forn 1 x: a. (p(x) or q(x) and r(x))", 2, 2),
        ("forpairs x: a, y: b. (in(x, y))", 1, 2),
        ("forpairs x: a, y: b. (p(x) and q(y))", 2, 4),
        ("fornpairs 1 x: a, y: b. (p(x) and q(y))", 2, 2),
        ("true", 0, 0),
    ],
)
def test_the_best_option_shares_most_conditions(text: str, shared: int, size: int) -> None:
    numbers = Numbers()
    find = make_finder_of_dnf_term_closest_to_answer(
        build_and_or_tree(parse(text), universe(a=3, b=2).list_objects), numbers
    )
    said = numbers.mask(on_first)
    best = find(said)
    assert best is not None
    assert ((best.conditions & said).bit_count(), best.conditions.bit_count()) == (shared, size)


@pytest.mark.parametrize(
    "text",
    [
        "false",
        "p(a0) and false",
        "forn 4 x: a. (p(x))",
        "fornpairs 3 x: a, y: b. (in(x, y))",
        "exists x: c. (p(x))",
    ],
)
def test_a_formula_that_cannot_be_true_has_no_option(text: str) -> None:
    assert (
        make_finder_of_dnf_term_closest_to_answer(
            build_and_or_tree(parse(text), universe(a=3, b=2).list_objects), Numbers()
        )(0)
        is None
    )


def choices(leaves: st.SearchStrategy[AndOrTree]) -> st.SearchStrategy[AndOrTree]:
    parts = st.lists(leaves, max_size=3).map(tuple)
    return (
        parts.map(AndNode)
        | parts.map(OrNode)
        | st.builds(ExactCountNode, st.integers(0, 2), parts)
        | st.tuples(st.integers(0, 2), st.lists(leaves, min_size=4, max_size=4)).map(
            lambda drawn: BipartiteMatchingNode(drawn[0], (tuple(drawn[1][:2]), tuple(drawn[1][2:])))
        )
    )


CHOICES = st.recursive(
    st.integers(0, 6).map(lambda n: AndOrTreeLiteral(Atom("p", (Constant(str(n)),)))), choices, max_leaves=8
)


@given(CHOICES, st.sets(st.integers(0, 6)))
def test_no_option_shares_more_than_the_best_or_is_shorter_with_as_many(
    choice: AndOrTree, said: set[int]
) -> None:
    seen: dict[int, Literal] = {}

    def apart(literal: Literal) -> int:
        """Give each condition a number of its own by its position."""
        seen[len(seen)] = literal
        return len(seen) - 1

    def is_said(literal: Literal) -> bool:
        return isinstance(literal, Atom) and int(literal.arguments[0].name) in said

    find = make_finder_of_dnf_term_closest_to_answer(choice, apart)
    best = find(sum(1 << place for place, literal in seen.items() if is_said(literal)))
    rated = [(sum(map(is_said, option)), -len(option)) for option in generate_dnf_terms_of_tree(choice)]
    if best is None:
        assert rated == []
        return
    chosen = [seen[place] for place in range(len(seen)) if best.conditions >> place & 1]
    assert (sum(map(is_said, chosen)), -len(chosen)) == max(rated)
    assert sorted(map(str, chosen)) in [
        sorted(map(str, option)) for option in generate_dnf_terms_of_tree(choice)
    ]


def test_the_best_of_astronomically_many_options_is_found_at_once() -> None:
    numbers = Numbers()
    text = "forpairs x: a, y: b. (in(x, y)) and forall x: a. (exists y: b. (on(x, y)))"
    find = make_finder_of_dnf_term_closest_to_answer(
        build_and_or_tree(parse(text), universe(a=12, b=12).list_objects), numbers
    )
    best = find(numbers.mask(on_first))
    assert best is not None
    assert best.conditions.bit_count() == 24
