"""A small domain for tests: a robot, boxes and a lamp."""

from __future__ import annotations

from eai.world import (
    AGENT,
    ANYTHING,
    Add,
    DefinedPredicate,
    Delete,
    Domain,
    Exists,
    ForEach,
    Operator,
    OperatorRole,
    Predicate,
    Scene,
    State,
    Variable,
    Vocabulary,
    When,
    WorldObject,
    additional_step,
    affordance,
    is_a,
    missing_step,
)

X, Y = Variable("x"), Variable("y")
at, holding, lit = Predicate("at", 2), Predicate("holding", 1), Predicate("lit", 1)
beside = DefinedPredicate("beside", (X,), Exists(Y, at(AGENT, Y) & at(X, Y)))
VOCABULARY = Vocabulary((at, holding, lit), (beside,))
BESIDE = missing_step(beside(X), "the robot is not beside {x}")

GO = Operator(
    "GO",
    (X,),
    (
        affordance(is_a(X, "place"), "{x} is no place"),
        additional_step(~at(AGENT, X), "the robot is there already"),
    ),
    (
        Delete(at(AGENT, ANYTHING)),
        Add(at(AGENT, X)),
        ForEach(Y, holding(Y), (Delete(at(Y, ANYTHING)), Add(at(Y, X)))),
    ),
)
LIFT = Operator(
    "LIFT",
    (X,),
    (
        affordance(is_a(X, "box"), "{x} is no box"),
        BESIDE,
        missing_step(~Exists(Y, holding(Y)), "the hand is full"),
    ),
    (Add(holding(X)),),
    role=OperatorRole.TAKES,
)
DROP = Operator(
    "DROP",
    (X,),
    (missing_step(holding(X), "{x} is not held"),),
    (Delete(holding(X)),),
    role=OperatorRole.RELEASES,
)
PRESS = Operator(
    "PRESS",
    (X,),
    (affordance(is_a(X, "lamp"), "{x} is no lamp"), BESIDE),
    (When(lit(X), (Delete(lit(X)),)), When(~lit(X), (Add(lit(X)),))),
)
DOMAIN = Domain("toy", VOCABULARY, (GO, LIFT, DROP, PRESS))


def initial() -> State:
    """Return the state with the robot and a box in the hall, and a box and the lamp in the shed."""
    names = {"robot": "robot", "hall": "place", "shed": "place", "red": "box", "blue": "box", "lamp": "lamp"}
    scene = Scene(VOCABULARY, (WorldObject(n, c) for n, c in names.items()), agent=0)
    places = {"robot": "hall", "red": "hall", "blue": "shed", "lamp": "shed"}
    return scene.state(("at", (scene.index[x], scene.index[p])) for x, p in places.items())
