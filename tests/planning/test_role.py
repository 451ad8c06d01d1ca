from __future__ import annotations

import pytest

from eai.logic.formula import Variable
from eai.planning.role import role_of
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach
from eai.world.frame import AGENT
from eai.world.operator import Operator, Role
from eai.world.vocabulary import Predicate
from world import toy

FACING, SITTING, HAS = Predicate("facing", 2), Predicate("sitting", 1), Predicate("has", 2)
X, Y, Z = Variable("x"), Variable("y"), Variable("z")
TURN = (Delete(FACING(AGENT, ANYTHING)), Add(FACING(AGENT, X)))
ONE_BY_ONE = (ForEach(Z, FACING(AGENT, Z), (Delete(FACING(AGENT, Z)),)), Add(FACING(AGENT, X)))
TAKE, GIVE, SWAP = Add(HAS(AGENT, X)), Delete(HAS(AGENT, X)), Add(HAS(AGENT, Y))


def test_a_declared_role_counts() -> None:
    assert [role_of(o) for o in (toy.GO, toy.LIFT, toy.DROP, toy.PRESS)] == [
        Role.MOVEMENT,
        Role.TAKES,
        Role.LETS_GO,
        Role.DEED,
    ]
    assert role_of(Operator("O", (X,), (), (TAKE,), role=Role.DEED)) is Role.DEED


@pytest.mark.parametrize(
    ("effects", "role"),
    [
        (TURN, Role.MOVEMENT),
        (ONE_BY_ONE, Role.MOVEMENT),
        ((*TURN, Add(SITTING(AGENT))), Role.MOVEMENT),
        ((Delete(SITTING(AGENT)),), Role.MOVEMENT),
        ((*TURN, Add(SITTING(X))), Role.DEED),
        ((TAKE,), Role.TAKES),
        ((Delete(FACING(X, ANYTHING)), TAKE), Role.TAKES),
        ((GIVE,), Role.DEED),
        ((GIVE, SWAP), Role.DEED),
        ((), Role.DEED),
    ],
)
def test_otherwise_effects_tell_the_role(effects: tuple[Effect, ...], role: Role) -> None:
    assert role_of(Operator("O", (X, Y) if SWAP in effects else (X,), (), effects)) is role
