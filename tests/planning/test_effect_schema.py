from __future__ import annotations

from eai.logic.formula import FALSE, TRUE, Equals, Exists, Or, Variable
from eai.planning.effect_schema import (
    find_predicates_changed_by_effects,
    make_effect_schemas,
    make_schema_without_effect,
)
from eai.world.effect import Add, Delete, Let, When
from eai.world.operator import Operator, missing_step
from eai.world.vocabulary import Predicate

X, H, Y = Variable("x"), Variable("h"), Variable("y")
held = Predicate("held", 1)
inside = Predicate("inside", 2)
larger = Predicate("larger", 2)
open_ = Predicate("open", 1)
EMPTY = ~Exists(H, held(H))
PLACE = Operator(
    "PLACE",
    (X,),
    (
        missing_step(~EMPTY, "nothing is held"),
        missing_step(~Exists(H, held(H) & larger(H, X)), "it is too big"),
        missing_step(EMPTY | open_(X), "{x} is closed"),
        missing_step(~held(X), "{x} is held itself"),
    ),
    (Let(H, held(H), (Delete(held(H)), When(open_(X), (Add(inside(H, X)),), (Delete(open_(X)),)))),),
)


def test_a_check_on_the_held_object_becomes_a_check_on_the_object_to_be_taken() -> None:
    (let_go, put, _) = make_effect_schemas(PLACE)
    assert (let_go.atom, let_go.adds, let_go.conditions) == (held(H), False, (held(H),))
    assert (put.atom, put.adds, put.conditions) == (inside(H, X), True, (held(H), open_(X)))
    assert put.variables == ("x", "h")
    assert put.checks == (
        TRUE,  # the hand holds an object
        ~larger(H, X),
        Or((FALSE, open_(X))),
        ~(held(X) | Equals(X, H)),
    )


def test_otherwise_means_that_the_condition_does_not_hold() -> None:
    *_, shut = make_effect_schemas(PLACE)
    assert (shut.atom, shut.adds, shut.conditions) == (open_(X), False, (held(H), ~open_(X)))


def test_an_operator_can_be_taken_for_its_own_sake() -> None:
    assert make_schema_without_effect(PLACE).checks == tuple(check.condition for check in PLACE.checks)


def test_changed_predicates_include_effects_whose_variable_hides_another() -> None:
    hiding = Operator("O", (X,), (), (Let(X, held(X), (Add(open_(X)),)), Delete(held(X))))
    assert [schema.atom for schema in make_effect_schemas(hiding)] == [held(X)]
    assert list(find_predicates_changed_by_effects(hiding.effects)) == ["open", "held"]
