"""How the reference cuts operators out of answers."""

from __future__ import annotations

import re

import pytest

from abilities.transition_modeling.test_extraction import BOTH, NAMES, OPEN, SHUT, wrapped
from eai.extensions.reference import operator_rules
from eai.extensions.reference.operator_rules import (
    compare_clauses_like_published_code,
    extract_operators_like_published_code,
)
from eai.pddl.matching import ClauseComparison


@pytest.mark.parametrize(
    ("answer", "names"),
    [
        (wrapped(BOTH), NAMES),
        (BOTH, NAMES),
        (f"```json{wrapped(BOTH)}```", NAMES),
        (
            f" ```json{wrapped(BOTH)}```",
            NAMES,
        ),  # The fence is no fence, but the text is searched all the same.
        (f"{OPEN} ; comment\n{SHUT}", ("open",)),  # Line ends go first, so the comment swallows the rest.
        (wrapped(f"{OPEN} ; comment\n{SHUT}"), NAMES),
        (BOTH.upper(), ()),
        (wrapped(BOTH.replace("close", "close-it")), ("open", "close")),
        (
            wrapped(f"(:action a :parameters () :precondition ()) {OPEN}"),
            ("a",),
        ),  # Borrows the effect of open.
        (wrapped(f"{OPEN} (:action a :parameters () :precondition ())"), ("open",)),
        (wrapped(f"{OPEN} {OPEN.replace('shut', 'locked')}"), ("open",)),
        (wrapped(""), ()),
        ("no operators", ()),
    ],
)
def test_the_reference_finds(answer: str, names: tuple[str, ...]) -> None:
    found = extract_operators_like_published_code(answer)
    assert found is not None
    assert tuple(operator.name for operator in found) == names


@pytest.mark.parametrize(
    "answer",
    [
        "[]",
        "3",
        '{"output": 3}',
        '{"output": null}',
        '{"a": 1}',
        "(:action a :parameters (:precondition :effect",
    ],
)
def test_the_reference_calls_a_format_error(answer: str) -> None:
    assert extract_operators_like_published_code(answer) is None


def test_the_reference_makes_unbalanced_parts_unreadable() -> None:
    found = extract_operators_like_published_code(
        "(:action a :parameters () :precondition (and (p) :effect (q)"
    )
    assert found is not None
    assert (found[0].precondition, found[0].effect) == ("(()", "(q)")


def test_the_reference_does_not_count_a_parenthesis_right_behind_the_first() -> None:
    found = extract_operators_like_published_code(
        "(:action a :parameters () :precondition ((p) (q)) :effect (q))"
    )
    assert found is not None
    assert found[0].precondition == "((p)"


@pytest.mark.parametrize(
    ("quirk", "predicted", "gold", "matched", "additional", "missing"),
    [
        ("text_literals", "(p ?x)", "(p ?y)", "", "p", "p"),
        ("text_literals", "(and (p  ?x))", "(and (p ?x))", "", "p", "p"),
        ("joined_lists", "( (on ?x) (off ?x) )", "(on ?x)", "", "on", "on"),
        ("unreadable_is_free", "(and (p ?x)", "(and (p ?x))", "", "", ""),
        ("unreadable_is_free", "(not (p) (q))", "(and (p ?x))", "", "", ""),
        ("padding", "(and (p))", "(and (p) (q))", "p", "", "q"),
        (
            "positional_renaming",
            "(and (exists (?a) (p ?a)))",
            "(and (exists (?b) (p ?b)))",
            "p",
            "",
            "",
        ),
        (
            "positional_renaming",
            "(and (q) (exists (?a) (p ?a)))",
            "(and (exists (?b) (p ?b)) (q))",
            "q",
            "p q",
            "p",
        ),
        ("shorter_list", "(not (and (p) (q)))", "(not (and (p)))", "p q", "", ""),
        ("fractions_are_zero", "(and (or (p) (q)))", "(and (or (p) (r)))", "", "p q", "p r"),
        ("fractions_are_zero", "(not (and (p) (q)))", "(not (and (p) (r)))", "p q", "", ""),
        ("row_as_column", "(and (p) (q))", "(and (x) (p) (q))", "p q", "p", "x"),
        ("sets", "(and (p ?a) (p ?b) (p ?c))", "(and (p ?a) (p ?d))", "p", "p", "p"),
    ],
)
def test_each_quirk(
    quirk: str, predicted: str, gold: str, matched: str, additional: str, missing: str
) -> None:
    found = compare_clauses_like_published_code(predicted, gold)
    sets = tuple(" ".join(names) for names in (found.matched, found.additional, found.missing))
    assert sets == (matched, additional, missing), quirk


def test_every_quirk_has_a_test() -> None:
    marks = test_each_quirk.pytestmark  # type: ignore[attr-defined]
    assert {case[0] for case in marks[0].args[1]} == set(
        re.findall(r"(?m)^\* (\w+) \(", operator_rules.__doc__ or "")
    )


def test_conditional_effects_match_as_a_whole() -> None:
    gold = "(and (when (p) (q)))"
    assert compare_clauses_like_published_code(gold, gold).matched == ("p", "q")
    assert compare_clauses_like_published_code("(and (when (p) (r)))", gold).matched == ()


def test_a_single_literal_is_no_list() -> None:
    found = compare_clauses_like_published_code("(p)", "(and (p))")
    assert (found.matched, found.additional, found.missing) == ((), ("p",), ("p",))


def test_nothing_against_nothing() -> None:
    assert compare_clauses_like_published_code("()", "()") == ClauseComparison()
