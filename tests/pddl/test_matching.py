from __future__ import annotations

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.published import open_behavior_transition_tasks, open_virtualhome_transition_tasks
from eai.pddl.matching import (
    ClauseComparison,
    find_predicates_in_text,
    mark_all_clauses_missing,
    match_operators,
    normalize_condition,
    normalize_effect,
    write_clause,
)
from eai.pddl.model import PddlAction
from eai.pddl.reader import read_action
from eai.tasks.source import Source

PARAMETERS = "(?c - character ?a - object ?b - object)"


def operator(precondition: str, effect: str = "()", parameters: str = PARAMETERS) -> PddlAction:
    return read_action(f"(:action o :parameters {parameters} :precondition {precondition} :effect {effect})")


def match(predicted: str, gold: str) -> ClauseComparison:
    return match_operators(operator(predicted), operator(gold)).precondition


P, Q, R = "(p ?a)", "(q ?b)", "(r)"


@pytest.mark.parametrize(
    ("predicted", "gold", "clauses", "in_literals"),
    [
        (f"(and {P} {Q})", f"(and {Q} {P})", ([Q, P], [], []), (2, 0, 0)),
        (P, f"(and {P} {Q})", ([P], [], [Q]), (1, 0, 1)),
        (f"(and {P} (and {Q} {R}))", f"(and {P} {Q} {R})", ([P, Q, R], [], []), (3, 0, 0)),
        (f"(not {P})", P, ([], [f"(not {P})"], [P]), (0, 1, 1)),
        (f"(not (not {P}))", P, ([P], [], []), (1, 0, 0)),
        (f"(and {P} {P})", P, ([P], [P], []), (1, 1, 0)),
        (P, f"(and {P} (p ?b))", ([P], [], ["(p ?b)"]), (1, 0, 1)),
        (
            f"(or {Q} (and {P} (x)))",
            f"(or (and {P} (y)) {Q})",
            ([Q], [f"(and {P} (x))"], [f"(and {P} (y))"]),
            (2, 1, 1),
        ),
        (f"(and {R} (or {P} {Q}))", f"(and (or {Q} {P}) {R})", ([f"(or {Q} {P})", R], [], []), (3, 0, 0)),
        (
            f"(and {R} (or {P} {Q}))",
            f"(and {R} (or {P} {Q} (x)))",
            ([R], [f"(or {P} {Q})"], [f"(or {P} {Q} (x))"]),
            (3, 0, 1),
        ),
        ("(exists (?z) (q ?z ?a))", "(exists (?o) (q ?o ?a))", ([1], [], []), (1, 0, 0)),
        ("(exists (?z) (q ?a ?z))", "(exists (?o) (q ?o ?a))", ([], [1], [1]), (0, 1, 1)),
        ("(exists (?z - object) (q ?z))", "(forall (?o - object) (q ?o))", ([], [1], [1]), (0, 1, 1)),
        ("(exists (?z - character) (q ?z))", "(exists (?o - object) (q ?o))", ([], [1], [1]), (0, 1, 1)),
        (
            "(exists (?y) (forall (?z) (q ?y ?z)))",
            "(exists (?z) (forall (?y) (q ?z ?y)))",
            ([1], [], []),
            (1, 0, 0),
        ),
        (f"(not (and {P} {Q}))", f"(not (and {P} {R}))", ([], [1], [1]), (1, 1, 1)),
        (f"(imply {P} {Q})", f"(or {Q} (not {P}))", ([Q, f"(not {P})"], [], []), (2, 0, 0)),
        (f"(and {R} (imply {P} {Q}))", f"(and {R} (imply {P} (x)))", ([R], [1], [1]), (2, 1, 1)),
        ("(p kitchen)", "(p kitchen)", ([1], [], []), (1, 0, 0)),
        ("(p kitchen)", P, ([], ["(p kitchen)"], [P]), (0, 1, 1)),
        ("(p ?loose)", P, ([], ["(p ?loose)"], [P]), (0, 1, 1)),
        ("()", P, ([], [], [P]), (0, 0, 1)),
        ("()", "()", ([], [], []), (0, 0, 0)),
        ("(= ?a ?b)", "()", ([], ["(= ?a ?b)"], []), (0, 1, 0)),
    ],
)
def test_a_clause_is_matched_with_all_that_is_in_it_and_literals_one_by_one(
    predicted: str,
    gold: str,
    clauses: tuple[list[str | int], list[str | int], list[str | int]],
    in_literals: tuple[int, int, int],
) -> None:
    found = match_operators(operator(predicted), operator(gold))
    side = found.precondition
    for parts, expected in zip((side.matched, side.additional, side.missing), clauses, strict=True):
        assert len(parts) == len(expected)
        assert all(text in (part, 1) for part, text in zip(parts, expected, strict=True))
    assert found.precondition_literals == in_literals


@pytest.mark.parametrize(
    ("predicted", "gold", "clauses"),
    [
        (f"(or {P} {Q})", f"(and {P} {Q})", ([], [f"(or {P} {Q})"], [P, Q])),
        (f"(and {P} {Q})", f"(or (and {Q} {P}) (and {P} {R}))", ([f"(and {Q} {P})"], [], [f"(and {P} {R})"])),
        (f"(and {P} {Q})", f"(or {P} {R})", ([], [f"(and {P} {Q})"], [P, R])),
        (f"(or {P} {Q})", f"(and {R} (or {Q} {P}))", ([f"(or {Q} {P})"], [], [R])),
        (f"(or {P} {Q})", "()", ([], [P, Q], [])),
        ("()", f"(or {P} {Q})", ([], [], [P, Q])),
        (P, f"(or {P} {Q})", ([P], [], [Q])),
    ],
)
def test_beside_a_disjunction_a_conjunction_is_one_clause_and_the_other_way_round(
    predicted: str, gold: str, clauses: tuple[list[str], list[str], list[str]]
) -> None:
    assert match(predicted, gold) == ClauseComparison(*map(tuple, clauses))


def test_a_conditional_effect_is_matched_as_a_whole_and_gives_partial_credit_in_literals() -> None:
    ours = operator("()", "(forall (?z - object) (when (p ?z ?a) (and (not (r ?z)) (s))))")
    gold = operator("()", "(forall (?o - object) (when (p ?o ?a) (not (r ?o))))")
    found = match_operators(ours, gold)
    assert found.effect == ClauseComparison(
        additional=("(forall (?z - object) (when (p ?z ?a) (and (not (r ?z)) (s))))",),
        missing=("(forall (?o - object) (when (p ?o ?a) (not (r ?o))))",),
    )
    assert found.effect_literals == (2, 1, 0)


def test_names_of_parameters_mean_nothing() -> None:
    ours = operator(
        "(and (near ?who ?x) (in ?x ?y))", parameters="(?who - character ?x - object ?y - object)"
    )
    gold = operator("(and (near ?c ?a) (in ?a ?b))")
    assert match_operators(ours, gold).precondition == ClauseComparison(("(near ?c ?a)", "(in ?a ?b)"))


def test_parameters_are_paired_as_the_clauses_suggest_within_their_types() -> None:
    gold = operator("(and (near ?c ?a) (in ?a ?b))")
    turned = operator("(and (near ?c ?b) (in ?b ?a))")
    assert match_operators(turned, gold).precondition == ClauseComparison(("(near ?c ?a)", "(in ?a ?b)"))
    mixed = operator("(near ?a ?c)")
    missing = ("(near ?c ?a)", "(in ?a ?b)")
    assert match_operators(mixed, gold).precondition == ClauseComparison((), ("(near ?a ?c)",), missing)


def test_another_number_of_parameters_can_still_match_in_part() -> None:
    ours = operator("(and (near ?c ?a) (p ?a))", parameters="(?c - character ?a - object)")
    gold = operator("(and (near ?c ?a) (in ?a ?b))")
    assert match_operators(ours, gold).precondition == ClauseComparison(
        ("(near ?c ?a)",), (P,), ("(in ?a ?b)",)
    )


def test_a_missing_operator_misses_all_its_clauses() -> None:
    found = mark_all_clauses_missing(operator("(and (p ?a) (not (p ?b)))", "(when (q) (r))"))
    assert found.precondition == ClauseComparison(missing=(P, "(not (p ?b))"))
    assert found.effect == ClauseComparison(missing=("(when (q) (r))",))
    assert (found.precondition_literals, found.effect_literals) == ((0, 0, 2), (0, 0, 2))


def test_every_gold_operator_matches_itself_in_full(data_store: DataPackStore) -> None:
    for tasks in (
        open_virtualhome_transition_tasks(Source(data_store)),
        open_behavior_transition_tasks(Source(data_store)),
    ):
        for name, text in next(iter(tasks.values())).domain.operators.items():
            action = read_action(text.write_pddl)
            found, full = match_operators(action, action), mark_all_clauses_missing(action)
            assert found.precondition == ClauseComparison(full.precondition.missing), name
            assert found.effect == ClauseComparison(full.effect.missing), name
            assert found.effect_literals == (full.effect_literals[2], 0, 0), name


def test_a_clause_is_written_as_it_is_read_and_its_predicates_are_found(data_store: DataPackStore) -> None:
    for tasks in (
        open_virtualhome_transition_tasks(Source(data_store)),
        open_behavior_transition_tasks(Source(data_store)),
    ):
        for text in next(iter(tasks.values())).domain.operators.values():
            action = read_action(text.write_pddl)
            for tree, read in (
                (
                    normalize_condition(action.precondition),
                    lambda t: normalize_condition(operator(t).precondition),
                ),
                (normalize_effect(action.effect), lambda t: normalize_effect(operator("()", t).effect)),
            ):
                assert read(write_clause(tree)) == tree
    clause = "(forall (?o - object) (when (not (= ?o ?a)) (and (not (p ?o)) (q))))"
    assert find_predicates_in_text(clause) == {"=", "p", "q"}
    assert find_predicates_in_text("next_to") == {"next_to"}
