from __future__ import annotations

import pytest

from eai.reference.operator_matching import NOTHING, _CountingQuirk, compare_as_reference


@pytest.mark.parametrize(
    ("quirk", "predicted", "gold", "matched", "additional", "missing"),
    [
        (_CountingQuirk.TEXT_LITERALS, "(p ?x)", "(p ?y)", "", "p", "p"),
        (_CountingQuirk.TEXT_LITERALS, "(and (p  ?x))", "(and (p ?x))", "", "p", "p"),
        (_CountingQuirk.JOINED_LISTS, "( (on ?x) (off ?x) )", "(on ?x)", "", "on", "on"),
        (_CountingQuirk.UNREADABLE_IS_FREE, "(and (p ?x)", "(and (p ?x))", "", "", ""),
        (_CountingQuirk.UNREADABLE_IS_FREE, "(not (p) (q))", "(and (p ?x))", "", "", ""),
        (_CountingQuirk.PADDING, "(and (p))", "(and (p) (q))", "p", "", "q"),
        (
            _CountingQuirk.POSITIONAL_RENAMING,
            "(and (exists (?a) (p ?a)))",
            "(and (exists (?b) (p ?b)))",
            "p",
            "",
            "",
        ),
        (
            _CountingQuirk.POSITIONAL_RENAMING,
            "(and (q) (exists (?a) (p ?a)))",
            "(and (exists (?b) (p ?b)) (q))",
            "q",
            "p q",
            "p",
        ),
        (_CountingQuirk.SHORTER_LIST, "(not (and (p) (q)))", "(not (and (p)))", "p q", "", ""),
        (_CountingQuirk.FRACTIONS_ARE_ZERO, "(and (or (p) (q)))", "(and (or (p) (r)))", "", "p q", "p r"),
        (_CountingQuirk.FRACTIONS_ARE_ZERO, "(not (and (p) (q)))", "(not (and (p) (r)))", "p q", "", ""),
        (_CountingQuirk.ROW_AS_COLUMN, "(and (p) (q))", "(and (x) (p) (q))", "p q", "p", "x"),
        (_CountingQuirk.SETS, "(and (p ?a) (p ?b) (p ?c))", "(and (p ?a) (p ?d))", "p", "p", "p"),
    ],
)
def test_each_quirk(
    quirk: _CountingQuirk, predicted: str, gold: str, matched: str, additional: str, missing: str
) -> None:
    found = compare_as_reference(predicted, gold)
    sets = tuple(" ".join(sorted(names)) for names in (found.matched, found.additional, found.missing))
    assert sets == (matched, additional, missing), quirk


def test_every_quirk_has_a_test() -> None:
    marks = test_each_quirk.pytestmark  # type: ignore[attr-defined]
    assert {case[0] for case in marks[0].args[1]} == set(_CountingQuirk)


def test_conditional_effects_match_as_a_whole() -> None:
    gold = "(and (when (p) (q)))"
    assert compare_as_reference(gold, gold).matched == {"p", "q"}
    assert compare_as_reference("(and (when (p) (r)))", gold).matched == frozenset()


def test_a_single_literal_is_no_list() -> None:
    found = compare_as_reference("(p)", "(and (p))")
    assert (found.matched, found.additional, found.missing) == (frozenset(), {"p"}, {"p"})


def test_nothing_against_nothing() -> None:
    assert compare_as_reference("()", "()") == NOTHING
