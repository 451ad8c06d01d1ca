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
    ],
)
def test_a_mistake_in_a_problem_has_its_place(old: str, new: str, place: str) -> None:
    assert old in PROBLEM
    with pytest.raises(InputError) as caught:
        read_problem_text(
            PROBLEM.replace(old, new, 1), Path("p.pddl"), read_domain_text(DOMAIN, Path("d.pddl"))
        )
    assert str(caught.value).startswith(f"p.pddl: {place}")
