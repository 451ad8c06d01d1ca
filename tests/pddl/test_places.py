"""The place of a mistake is that of the wrong use of a name, not of its first use."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.pddl.files import read_domain_text, read_problem_text

DOMAIN = """\
(define (domain d)
 (:types box table - thing)
 (:constants home - table)
 (:predicates (on ?x - thing ?y - table) (full ?x - box) (above ?x - thing))
 (:derived (above ?x - thing) (exists (?y - table) (on ?x ?y)))
 (:action put :parameters (?x - box ?y - table)
  :precondition (and (not (full ?x)) (exists (?z - box) (full ?z)))
  :effect (and (on ?x ?y) (when (full ?x) (not (on ?x home)))))
 (:action fill :parameters (?x - box) :precondition (not (full ?x)) :effect (full ?x)))
"""
PROBLEM = """\
(define (problem p) (:domain d)
 (:objects b c - box t - table)
 (:init (on b t) (full c))
 (:goal (and (on c t) (full b))))
"""


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("(full ?z)))", "(full ?x ?z)))", "line 7, column 58: expected full with as many"),
        (
            "(full ?z)))",
            "(and (full ?z) (ful ?z))))",
            "line 7, column 73: expected a declared predicate, not ful",
        ),
        ("(exists (?z - box) (full ?z))", "(exists (?z - box) (full ?z)) (full ?z)", "line 7, column 74: "),
        ("(?z - box)", "(?z - bax)", "line 7, column 52: expected a declared type, not bax"),
        ("(:action fill", "(:action put", "line 9, column 11: expected put once only"),
        ("(full ?x - box) (above", "(on ?x - box) (above", "line 4, column 42: expected on once only"),
        (
            "(above ?x - thing))",
            "(above ?x - thong))",
            "line 4, column 70: expected a declared type, not thong",
        ),
        ("(on ?x ?y)))\n", "(on ?x ?z)))\n", "line 5, column 59: expected a variable"),
        ("(?x - box ?y - table)\n", "(?x - box ?x - table)\n", "line 6, column 37: expected x once only"),
    ],
)
def test_a_mistake_in_a_domain_has_its_place(old: str, new: str, place: str) -> None:
    assert old in DOMAIN
    with pytest.raises(InputError) as caught:
        read_domain_text(DOMAIN.replace(old, new, 1), Path("d.pddl"))
    assert str(caught.value).startswith(f"d.pddl: {place}")


def read_with_domain(domain: str, problem: str) -> None:
    file = Path("d.pddl")
    read_problem_text(problem, Path("p.pddl"), read_domain_text(domain, file), (file, domain))


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("(and (on c t)", "(and (on c)", "line 4, column 15: expected on with as many arguments"),
        ("(full b)", "(full box)", "line 4, column 29: expected a declared object, not box"),
        ("(full b)", "(fulll b)", "line 4, column 24: expected a declared predicate, not fulll"),
        (
            "(full b)",
            "(exists (?t - tabel) (on b ?t))",
            "line 4, column 37: expected a declared type, not tabel",
        ),
        ("b c - box", "b c b - box", "line 2, column 16: expected b once only"),
        ("t - table", "t - box c - table", "line 2, column 30: expected c once only"),
        (
            "(full c)",
            "(full t)",
            "line 3, column 24: expected types (full box) in (full t), not t - table",
        ),
        (
            "(and (on c t)",
            "(and (on c t) (on b c)",
            "line 4, column 29: expected types (on thing table) in (on b c), not c - box",
        ),
        (
            "(full b)",
            "(exists (?x - (either table thing)) (and (above ?x) (full ?x)))",
            "line 4, column 81: expected types (full box) in (full ?x), not ?x - (either table thing)",
        ),
        ("t - table", "t", "line 3, column 15: expected types (on thing table) in (on b t), not t - object"),
    ],
)
def test_a_mistake_in_a_problem_has_its_place(old: str, new: str, place: str) -> None:
    assert old in PROBLEM
    with pytest.raises(InputError) as caught:
        read_with_domain(DOMAIN, PROBLEM.replace(old, new, 1))
    assert str(caught.value).startswith(f"p.pddl: {place}")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("(full c)", "(full c) (on home home)"),
        ("(full b)", "(and (full b) (above b) (above t))"),
        ("(full b)", "(exists (?x - (either box table)) (full ?x))"),
        ("(:domain d)", "(:domain D)"),
    ],
)
def test_subtypes_and_alternatives_fit_a_declared_type(old: str, new: str) -> None:
    assert old in PROBLEM
    domain = DOMAIN.replace("full ?x - box", "full ?x - (either box table)")
    read_with_domain(domain, PROBLEM.replace(old, new, 1))


@pytest.mark.parametrize(("old", "new"), [("(full b)", "(full t)"), ("(:domain d)", "(:domain e)")])
def test_types_and_the_name_of_a_domain_count_only_if_the_domain_is_in_a_file(old: str, new: str) -> None:
    problem = PROBLEM.replace(old, new, 1)
    read_problem_text(problem, Path("p.pddl"), read_domain_text(DOMAIN, Path("d.pddl")))
    with pytest.raises(InputError):
        read_with_domain(DOMAIN, problem)


def test_an_operator_may_use_arguments_of_other_types() -> None:
    """ALFRED's domain marks locations as checked, though it declares this predicate for receptacles."""
    read_domain_text(
        DOMAIN.replace("(?x - box) :precondition (not", "(?x - thing) :precondition (not"), Path("d.pddl")
    )
