"""BDDL: conditions and problem files, read, printed and read again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.base.errors import InputError, ParseError
from eai.logic.formula import (
    And,
    Atom,
    Constant,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Not,
    Or,
    Variable,
)
from eai.logic.traversal import MAX_FORMULA_DEPTH
from eai.pddl.bddl import parse_problem
from eai.pddl.model import TypedName
from logic.bddl_text import print_condition, print_problem, read_condition
from logic.random_formulas import formulas
from sweeps import examples

if TYPE_CHECKING:
    from eai.benchmarks.behavior.tasks import BehaviorTasks

PROBLEM = """(define (problem Sorting_0)   ; a comment with (brackets
    (:domain igibson)
    (:objects
        cup.n.01_1 cup.n.01_2 - cup.n.01
        shelf.n.01_1 - shelf.n.01
        agent.n.01_1 - agent.n.01
    )
    (:init
        (ontop cup.n.01_1 shelf.n.01_1)
        (not (dusty cup.n.01_2))
        (inroom shelf.n.01_1 kitchen)
    )
    (:goal
        (and
            (forall (?cup.n.01 - cup.n.01) (inside ?cup.n.01 ?shelf.n.01_1))
            (open ?shelf.n.01_1)
        )
    )
)
"""
CUP = Variable("cup", "cup.n.01")
SHELF = Constant("shelf.n.01_1")


def open_(term: Variable | Constant) -> Atom:
    return Atom("open", (term,))


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("(open ?shelf.n.01_1)", open_(SHELF)),
        ("(Open SHELF.n.01_1)", open_(SHELF)),
        ("(and)", And(())),
        ("(or (open shelf.n.01_1) (and (open shelf.n.01_1)))", Or((open_(SHELF), And((open_(SHELF),))))),
        ("(imply (open shelf.n.01_1) (not (open a)))", Implies(open_(SHELF), Not(open_(Constant("a"))))),
        ("(forall (?cup - cup.n.01) (open ?cup))", ForAll(CUP, open_(Variable("cup")))),
        ("(exists (?cup - cup.n.01) (open cup))", Exists(CUP, open_(Variable("cup")))),
        ("(forn (2) (?cup - cup.n.01) (open ?cup))", Exactly(2, CUP, open_(Variable("cup")))),
        (
            "(forn (999999999) (?cup - cup.n.01) (open ?cup))",
            Exactly(999_999_999, CUP, open_(Variable("cup"))),
        ),
        (
            "(forpairs (?cup - cup.n.01) (?y - b) (in ?cup ?y))",
            ForPairs(CUP, Variable("y", "b"), Atom("in", (Variable("cup"), Variable("y")))),
        ),
        (
            "(fornpairs (3) (?cup - cup.n.01) (?y - b) (in ?cup ?z))",
            ForPairs(CUP, Variable("y", "b"), Atom("in", (Variable("cup"), Constant("z"))), 3),
        ),
    ],
)
def test_conditions(text: str, formula: Formula) -> None:
    assert read_condition(text) == formula
    assert read_condition(print_condition(formula)) == formula


def test_problem() -> None:
    problem = parse_problem(PROBLEM)
    assert (problem.name, problem.domain) == ("sorting_0", "igibson")
    assert problem.objects == (
        TypedName("cup.n.01_1", "cup.n.01"),
        TypedName("cup.n.01_2", "cup.n.01"),
        TypedName("shelf.n.01_1", "shelf.n.01"),
        TypedName("agent.n.01_1", "agent.n.01"),
    )
    assert problem.denied == (Atom("dusty", (Constant("cup.n.01_2"),)),)
    assert len(problem.initial) == 2
    assert isinstance(problem.goal, And)
    assert problem.goal.operands[1] == open_(SHELF)
    assert isinstance(problem.goal.operands[0], ForAll)
    assert parse_problem(print_problem(problem)) == problem
    assert parse_problem(PROBLEM.replace("\n", "\r\n")) == problem


def test_a_goal_without_and_is_one_goal() -> None:
    problem = parse_problem("(define (problem p) (:domain d) (:objects a - b) (:init) (:goal (open a)))")
    assert problem.goal == open_(Constant("a"))
    assert parse_problem(print_problem(problem)) == problem


@pytest.mark.parametrize(
    ("text", "line", "column", "expected"),
    [
        ("()", 1, 2, "a name or a connective"),
        ("(and (open x)\n open y)", 2, 2, "'(' or ')'"),
        ("(open x)\n(open y)", 2, 1, "')'"),
        ("(forall (?x cup) (open ?x))", 1, 13, "'-'"),
        ("(forn 2 (?x - cup) (open ?x))", 1, 7, "'('"),
        ("(not (open x) (open x))", 1, 15, "')'"),
        ("(forn (1234567890) (?x - cup) (open ?x))", 1, 8, "a number of at most 9 digits"),
        ("(forn (two) (?x - cup) (open ?x))", 1, 8, "the number of objects"),
        ("(forpairs (?x - cup)\n (?y- cup) (in ?x ?y))", 2, 7, "'-'"),
        ("(forall (?x - cup) open)", 1, 20, "'('"),
        ("(in ?x - cup)", 1, 8, "a name or ')'"),
        ("(in ; a box)\n (cup))", 2, 2, "a name or ')'"),
    ],
)
def test_errors_in_conditions(text: str, line: int, column: int, expected: str) -> None:
    with pytest.raises(ParseError) as caught:
        read_condition(text)
    assert (caught.value.line - 1, caught.value.column, caught.value.expected) == (line, column, expected)


@pytest.mark.parametrize(
    ("old", "new", "line", "expected"),
    [
        ("(:init", "(:inits", 8, "':domain', ':objects', ':init' or ':goal'; did you mean :init?"),
        (
            "agent.n.01_1 - agent",
            "agent.n.01_1- agent",
            6,
            "a space before the hyphen, as in agent.n.01_1 - CATEGORY",
        ),
        ("- agent.n.01\n", "\n", 7, "a name or '-'"),
        ("(:domain igibson)", "", 20, "exactly one ':domain' section"),
        ("(:init", "(:init) (:init", 20, "exactly one ':init' section"),
        ("(define", "(defined", 1, "'define'"),
        ("(:domain igibson)", "(:domain igibson) (:requirements :adl", 3, "a name or ')'"),
        ("- shelf.n.01\n", "-)\n", 5, "a name"),
    ],
)
def test_errors_in_problems(old: str, new: str, line: int, expected: str) -> None:
    with pytest.raises(ParseError) as caught:
        parse_problem(PROBLEM.replace(old, new))
    assert (caught.value.line, caught.value.expected) == (line, expected)


def test_the_hyphen_before_a_category_needs_no_space_behind_it() -> None:
    joined = PROBLEM.replace("agent.n.01_1 - agent", "agent.n.01_1 -agent")
    assert joined != PROBLEM
    assert parse_problem(joined) == parse_problem(PROBLEM)


def test_a_domain_that_is_given_as_a_problem_is_named() -> None:
    with pytest.raises(ParseError, match="expected 'problem', as this is a domain"):
        parse_problem("(define (domain igibson) (:requirements :strips))")


@pytest.mark.parametrize("levels", [MAX_FORMULA_DEPTH, 1000, 16_000])
def test_too_deep_nesting_is_an_error(levels: int) -> None:
    with pytest.raises(ParseError, match="at most 100 levels of nesting"):
        read_condition("(not " * levels + "(open x)" + ")" * levels)


def test_the_deepest_condition_is_read_and_printed() -> None:
    text = "(not " * (MAX_FORMULA_DEPTH - 1) + "(open x)" + ")" * (MAX_FORMULA_DEPTH - 1)
    assert print_condition(read_condition(text)) == text


def test_long_conditions() -> None:
    formula = And((open_(Constant("a")),) * 10_000)
    assert read_condition(print_condition(formula)) == formula


@given(st.text(alphabet=" ()?-xandofr12;:\n", max_size=40))
@settings(max_examples=examples(100))
def test_any_text_is_a_condition_or_a_parse_error(text: str) -> None:
    try:
        formula = read_condition(text)
    except ParseError:
        return
    assert read_condition(print_condition(formula)) == formula


@given(st.text("()?-\n aonds3", max_size=40))
def test_a_comment_between_words_changes_nothing(text: str) -> None:
    """A fact with a comment inside is read word by word, one without in one go."""
    commented = text.replace(" ", " ;\n ")
    assert _outcome(commented) == _outcome(text)


def test_a_comment_ends_with_its_line() -> None:
    assert _outcome("(3; )") is None
    assert _outcome("(3; ;\n )") == Atom("3")


@given(formulas(temporal=False))
@settings(max_examples=examples(100))
def test_what_is_printed_is_read_back(formula: Formula) -> None:
    try:
        text = print_condition(formula)
    except InputError:
        return
    assert read_condition(text) == formula


def test_all_goals_of_the_data_set_survive_the_round_trip(behavior_tasks: BehaviorTasks) -> None:
    goals = [goal.formula for task in behavior_tasks.values() for goal in task.goals]
    assert len(goals) == 366
    for formula in goals:
        assert read_condition(print_condition(formula)) == formula


def _outcome(text: str) -> Formula | None:
    try:
        return read_condition(text)
    except ParseError:
        return None
