from __future__ import annotations

import pytest

from eai.benchmarks.gold_operators import open_behavior, open_virtualhome
from eai.data.store import Store
from eai.pddl.matching import OperatorMatch, SideMatch, match_operators, missing_operator
from eai.pddl.model import PddlAction
from eai.pddl.reader import read_action

PARAMETERS = "(?c - character ?a - object ?b - object)"


def operator(precondition: str, effect: str = "()", parameters: str = PARAMETERS) -> PddlAction:
    return read_action(f"(:action o :parameters {parameters} :precondition {precondition} :effect {effect})")


def match(predicted: str, gold: str) -> SideMatch:
    return match_operators(operator(predicted), operator(gold)).precondition


@pytest.mark.parametrize(
    ("predicted", "gold", "matched", "additional", "missing"),
    [
        ("(and (p ?a) (q ?b))", "(and (q ?b) (p ?a))", "p q", "", ""),
        ("(p ?a)", "(and (p ?a) (q ?b))", "p", "", "q"),
        ("(and (p ?a) (and (q ?b) (r)))", "(and (p ?a) (q ?b) (r))", "p q r", "", ""),
        ("(not (p ?a))", "(p ?a)", "", "p", "p"),
        ("(not (not (p ?a)))", "(p ?a)", "p", "", ""),
        ("(and (p ?a) (p ?a))", "(p ?a)", "p", "p", ""),
        ("(p ?a)", "(and (p ?a) (p ?b))", "p", "", "p"),
        ("(or (p ?a) (q ?b))", "(and (p ?a) (q ?b))", "", "p q", "p q"),
        ("(or (q ?b) (and (p ?a) (x)))", "(or (and (p ?a) (y)) (q ?b))", "p q", "x", "y"),
        ("(and (r) (or (p ?a) (q ?b)))", "(or (p ?a) (q ?b))", "p q", "r", ""),
        ("(exists (?z) (q ?z ?a))", "(exists (?o) (q ?o ?a))", "q", "", ""),
        ("(exists (?z) (q ?a ?z))", "(exists (?o) (q ?o ?a))", "", "q", "q"),
        ("(exists (?z - object) (q ?z))", "(forall (?o - object) (q ?o))", "", "q", "q"),
        ("(exists (?z - character) (q ?z))", "(exists (?o - object) (q ?o))", "", "q", "q"),
        ("(not (and (p ?a) (q ?b)))", "(not (and (p ?a) (r)))", "p", "q", "r"),
        ("(imply (p ?a) (q ?b))", "(imply (p ?a) (r))", "p", "q", "r"),
        ("(p kitchen)", "(p kitchen)", "p", "", ""),
        ("(p kitchen)", "(p ?a)", "", "p", "p"),
        ("(p ?loose)", "(p ?a)", "", "p", "p"),
        ("()", "(p ?a)", "", "", "p"),
        ("(= ?a ?b)", "()", "", "=", ""),
    ],
)
def test_clauses(predicted: str, gold: str, matched: str, additional: str, missing: str) -> None:
    expected = SideMatch(*(tuple(names.split()) for names in (matched, additional, missing)))
    assert match(predicted, gold) == expected


def test_effects_give_credit_inside_conditional_parts() -> None:
    ours = operator("()", "(forall (?z - object) (when (p ?z ?a) (and (not (r ?z)) (s))))")
    gold = operator("()", "(forall (?o - object) (when (p ?o ?a) (not (r ?o))))")
    assert match_operators(ours, gold).effect == SideMatch(("p", "r"), ("s",), ())


def test_names_of_parameters_mean_nothing() -> None:
    ours = operator(
        "(and (near ?who ?x) (in ?x ?y))", parameters="(?who - character ?x - object ?y - object)"
    )
    gold = operator("(and (near ?c ?a) (in ?a ?b))")
    assert match_operators(ours, gold).precondition == SideMatch(("in", "near"))


def test_parameters_are_paired_as_the_clauses_suggest_within_their_types() -> None:
    gold = operator("(and (near ?c ?a) (in ?a ?b))")
    turned = operator("(and (near ?c ?b) (in ?b ?a))")
    assert match_operators(turned, gold).precondition == SideMatch(("in", "near"))
    mixed = operator("(near ?a ?c)")
    assert match_operators(mixed, gold).precondition == SideMatch((), ("near",), ("in", "near"))


def test_another_number_of_parameters_can_still_match_in_part() -> None:
    ours = operator("(and (near ?c ?a) (p ?a))", parameters="(?c - character ?a - object)")
    gold = operator("(and (near ?c ?a) (in ?a ?b))")
    assert match_operators(ours, gold).precondition == SideMatch(("near",), ("p",), ("in",))


def test_a_missing_operator_misses_all_its_predicates() -> None:
    gold = operator("(and (p ?a) (not (p ?b)))", "(when (q) (r))")
    assert missing_operator(gold) == OperatorMatch(
        SideMatch(missing=("p", "p")), SideMatch(missing=("q", "r"))
    )


def test_every_gold_operator_matches_itself_in_full(data_store: Store) -> None:
    for tasks in (open_virtualhome(data_store), open_behavior(data_store)):
        for name, text in tasks.domain.operators.items():
            action = read_action(text.pddl)
            found = match_operators(action, action)
            full = missing_operator(action)
            assert found.precondition == SideMatch(full.precondition.missing), name
            assert found.effect == SideMatch(full.effect.missing), name
