from __future__ import annotations

import pytest

from eai.benchmarks.registry import find_benchmark
from eai.logic.formula import Variable
from eai.planning.role import find_holding_and_location_predicates, infer_operator_role
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach
from eai.world.frame import AGENT
from eai.world.operator import Operator, OperatorRole
from eai.world.vocabulary import Predicate
from world import toy

FACING, SITTING, HAS = Predicate("facing", 2), Predicate("sitting", 1), Predicate("has", 2)
X, Y, Z = Variable("x"), Variable("y"), Variable("z")
TURN = (Delete(FACING(AGENT, ANYTHING)), Add(FACING(AGENT, X)))
ONE_BY_ONE = (ForEach(Z, FACING(AGENT, Z), (Delete(FACING(AGENT, Z)),)), Add(FACING(AGENT, X)))
TAKE, GIVE, SWAP = Add(HAS(AGENT, X)), Delete(HAS(AGENT, X)), Add(HAS(AGENT, Y))


def test_a_declared_role_is_used() -> None:
    assert [infer_operator_role(o) for o in (toy.GO, toy.LIFT, toy.DROP, toy.PRESS)] == [
        OperatorRole.MOVEMENT,
        OperatorRole.TAKES,
        OperatorRole.RELEASES,
        OperatorRole.CHANGE,
    ]
    assert (
        infer_operator_role(Operator("O", (X,), (), (TAKE,), role=OperatorRole.CHANGE)) is OperatorRole.CHANGE
    )


@pytest.mark.parametrize(
    ("effects", "role"),
    [
        (TURN, OperatorRole.MOVEMENT),
        (ONE_BY_ONE, OperatorRole.MOVEMENT),
        ((*TURN, Add(SITTING(AGENT))), OperatorRole.MOVEMENT),
        ((Delete(SITTING(AGENT)),), OperatorRole.MOVEMENT),
        ((*TURN, Add(SITTING(X))), OperatorRole.CHANGE),
        ((TAKE,), OperatorRole.TAKES),
        ((Delete(FACING(X, ANYTHING)), TAKE), OperatorRole.TAKES),
        ((GIVE,), OperatorRole.CHANGE),
        ((GIVE, SWAP), OperatorRole.CHANGE),
        ((), OperatorRole.CHANGE),
    ],
)
def test_an_undeclared_role_is_inferred_from_the_effects(
    effects: tuple[Effect, ...], role: OperatorRole
) -> None:
    assert infer_operator_role(Operator("O", (X, Y) if SWAP in effects else (X,), (), effects)) is role


@pytest.mark.parametrize(
    ("name", "held", "supports"),
    [
        ("virtualhome", ("HOLDS_RH", "HOLDS_LH"), {"INSIDE", "ONTOP"}),
        ("behavior", ("in_left_hand", "in_right_hand"), {"stands_on", "lies_on", "lies_in", "stands_under"}),
    ],
)
def test_the_predicates_of_places_are_found_in_household_domains(
    name: str, held: tuple[str, ...], supports: set[str]
) -> None:
    found, put = find_holding_and_location_predicates(find_benchmark(name).domain)
    assert (found, {*put}) == (held, supports)


def test_a_world_without_release_operators_has_no_predicates_of_places() -> None:
    without = toy.DOMAIN.replace_operators(without=[each.name for each in toy.DOMAIN.operators])
    assert find_holding_and_location_predicates(without) == ((), ())
