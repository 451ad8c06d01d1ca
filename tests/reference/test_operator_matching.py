from __future__ import annotations

import pytest

from eai.reference.operator_matching import NOTHING, CountingQuirk, compare_as_reference


@pytest.mark.parametrize(
    ("quirk", "predicted", "gold", "matched", "additional", "missing"),
    [
        (CountingQuirk.TEXT_LITERALS, "(p ?x)", "(p ?y)", "", "p", "p"),
        (CountingQuirk.TEXT_LITERALS, "(and (p  ?x))", "(and (p ?x))", "", "p", "p"),
        (CountingQuirk.JOINED_LISTS, "( (on ?x) (off ?x) )", "(on ?x)", "", "on", "on"),
        (CountingQuirk.UNREADABLE_IS_FREE, "(and (p ?x)", "(and (p ?x))", "", "", ""),
        (CountingQuirk.UNREADABLE_IS_FREE, "(not (p) (q))", "(and (p ?x))", "", "", ""),
        (CountingQuirk.PADDING, "(and (p))", "(and (p) (q))", "p", "", "q"),
        (
            CountingQuirk.POSITIONAL_RENAMING,
            "(and (exists (?a) (p ?a)))",
            "(and (exists (?b) (p ?b)))",
            "p",
            "",
            "",
        ),
        (
            CountingQuirk.POSITIONAL_RENAMING,
            "(and (q) (exists (?a) (p ?a)))",
            "(and (exists (?b) (p ?b)) (q))",
            "q",
            "p q",
            "p",
        ),
        (CountingQuirk.SHORTER_LIST, "(not (and (p) (q)))", "(not (and (p)))", "p q", "", ""),
        (CountingQuirk.FRACTIONS_ARE_ZERO, "(and (or (p) (q)))", "(and (or (p) (r)))", "", "p q", "p r"),
        (CountingQuirk.FRACTIONS_ARE_ZERO, "(not (and (p) (q)))", "(not (and (p) (r)))", "p q", "", ""),
        (CountingQuirk.ROW_AS_COLUMN, "(and (p) (q))", "(and (x) (p) (q))", "p q", "p", "x"),
        (CountingQuirk.SETS, "(and (p ?a) (p ?b) (p ?c))", "(and (p ?a) (p ?d))", "p", "p", "p"),
    ],
)
def test_each_quirk(
    quirk: CountingQuirk, predicted: str, gold: str, matched: str, additional: str, missing: str
) -> None:
    found = compare_as_reference(predicted, gold)
    sets = tuple(" ".join(sorted(names)) for names in (found.matched, found.additional, found.missing))
    assert sets == (matched, additional, missing), quirk


def test_every_quirk_has_a_test() -> None:
    marks = test_each_quirk.pytestmark  # type: ignore[attr-defined]
    assert {case[0] for case in marks[0].args[1]} == set(CountingQuirk)


def test_conditional_effects_match_as_a_whole() -> None:
    gold = "(and (when (p) (q)))"
    assert compare_as_reference(gold, gold).matched == {"p", "q"}
    assert compare_as_reference("(and (when (p) (r)))", gold).matched == frozenset()


def test_a_single_literal_is_no_list() -> None:
    found = compare_as_reference("(p)", "(and (p))")
    assert (found.matched, found.additional, found.missing) == (frozenset(), {"p"}, {"p"})


def test_nothing_against_nothing() -> None:
    assert compare_as_reference("()", "()") == NOTHING
