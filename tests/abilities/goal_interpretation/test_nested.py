from __future__ import annotations

from typing import Any

import pytest

from eai.abilities.goal_interpretation.nested import read_nested
from eai.logic.formula import Atom, Formula
from eai.logic.signature import term
from logic.bddl_text import print_condition

JAR = ["jar", "-", "jar"]
OPEN = ["open", "jar"]


def literal(entry: object, variables: frozenset[str]) -> Formula | None:
    """A list of words."""
    match entry:
        case [str(predicate), *names] if all(isinstance(name, str) for name in names):
            return Atom(predicate, tuple(term(str(name), variables) for name in names))
        case _:
            return None


@pytest.mark.parametrize(
    ("entry", "condition"),
    [
        (OPEN, "(open jar)"),
        (["not", OPEN], "(not (open jar))"),
        (["not", ["not", OPEN]], "(not (not (open jar)))"),
        (["or", OPEN, ["lit", "lamp"]], "(or (open jar) (lit lamp))"),
        (["or", [OPEN, ["lit", "lamp"]]], "(or (open jar) (lit lamp))"),
        (["and", OPEN, ["or", OPEN, OPEN]], "(and (open jar) (or (open jar) (open jar)))"),
        (["and", OPEN], "(and (open jar))"),
        (["imply", OPEN, ["lit", "lamp"]], "(imply (open jar) (lit lamp))"),
        (["forall", JAR, ["not", OPEN]], "(forall (?jar - jar) (not (open ?jar)))"),
        (["forall", "jar", ["not", OPEN]], "(forall (?jar - jar) (not (open ?jar)))"),
        (["exists", ["x", "-", "jar"], ["open", "x"]], "(exists (?x - jar) (open ?x))"),
        (["forn", ["2"], JAR, OPEN], "(forn (2) (?jar - jar) (open ?jar))"),
        (["forn", 2, JAR, OPEN], "(forn (2) (?jar - jar) (open ?jar))"),
        (["forn", 0, JAR, OPEN], "(forn (0) (?jar - jar) (open ?jar))"),
        (["forn", "9" * 9, JAR, OPEN], "(forn (999999999) (?jar - jar) (open ?jar))"),
        (
            ["forpairs", JAR, ["lid", "-", "lid"], ["ontop", "lid", "jar"]],
            "(forpairs (?jar - jar) (?lid - lid) (ontop ?lid ?jar))",
        ),
        (
            ["fornpairs", "2", JAR, "lid", ["ontop", "lid", "jar"]],
            "(fornpairs (2) (?jar - jar) (?lid - lid) (ontop ?lid ?jar))",
        ),
        (
            ["exists", JAR, ["forall", "lid", ["ontop", "lid", "jar"]]],
            "(exists (?jar - jar) (forall (?lid - lid) (ontop ?lid ?jar)))",
        ),
    ],
)
def test_conditions(entry: list[Any], condition: str) -> None:
    read = read_nested(entry, literal)
    assert read is not None
    assert print_condition(read) == condition


@pytest.mark.parametrize(
    "entry",
    [
        *(None, 1, [], [[]], "open", {"open": "jar"}, ["open", 1], ["open", ["jar"]]),
        *(["not", [1]], ["not", OPEN, OPEN, 3], ["and", OPEN, 1], ["or", [OPEN, 2]], ["imply", OPEN, 1]),
        *(["forall", JAR], ["forall", OPEN], ["forall", 1, OPEN], ["forall", JAR, JAR, OPEN]),
        *(["forn", JAR, OPEN], ["forn", "two", JAR, OPEN], ["forn", True, JAR, OPEN]),
        *(["forn", -1, JAR, OPEN], ["forn", "9" * 10, JAR, OPEN], ["fornpairs", 1, JAR, OPEN]),
        ["forpairs", JAR, OPEN],
    ],
)  # fmt: skip
def test_what_is_no_condition(entry: object) -> None:
    assert read_nested(entry, literal) is None
