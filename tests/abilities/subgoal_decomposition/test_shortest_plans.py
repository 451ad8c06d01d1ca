from __future__ import annotations

from collections.abc import Sequence

import pytest

from abilities.subgoal_decomposition.test_scorer import TASK
from eai.abilities.subgoal_decomposition.shortest_plans import Bounds, ShortestPlans, is_movement
from eai.logic.formula import Variable
from eai.planning.subgoal import GroundAtom
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, ForEach
from eai.world.execution import Action
from eai.world.frame import AGENT
from eai.world.operator import Operator, missing
from eai.world.state import Scene, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy

SCENE = TASK.scene
PLANS = ShortestPlans(toy.DOMAIN)


def literal(text: str) -> GroundAtom:
    """A literal written as ``not at red shed``."""
    words = text.removeprefix("not ").split()
    return GroundAtom(words[0], tuple([SCENE.index[name] for name in words[1:]]), not text.startswith("not "))


def written(plans: Sequence[Sequence[Action]]) -> list[str]:
    return [
        ", ".join(" ".join([a.operator, *(SCENE.objects[i].name for i in a.arguments)]) for a in plan)
        for plan in plans
    ]


@pytest.mark.parametrize(
    ("literals", "plans"),
    [
        (["lit lamp"], ["GO shed, PRESS lamp"]),
        (["not lit lamp"], []),
        (["at robot shed"], ["GO shed"]),
        (["at red shed"], ["LIFT red, GO shed"]),
        (["not at red hall"], ["LIFT red, GO shed"]),
        (["at blue hall", "not holding blue"], ["GO shed, LIFT blue, GO hall, DROP blue"]),
        (["holding red", "lit lamp"], ["LIFT red, GO shed, PRESS lamp"]),
        (["holding red", "holding blue"], []),
        (["beside lamp"], ["GO shed"]),
    ],
)
def test_all_shortest_plans_are_found(literals: list[str], plans: list[str]) -> None:
    assert written(PLANS.plans([literal(text) for text in literals], TASK)(TASK.initial)) == plans


def test_few_deeds_are_done_for_a_literal() -> None:
    once = ShortestPlans(toy.DOMAIN, bounds=Bounds(deeds=1))
    assert written(once.plans([literal("holding blue")], TASK)(TASK.initial)) == ["GO shed, LIFT blue"]
    assert once.plans([literal("lit lamp")], TASK)(TASK.initial)
    blue = [literal("at blue hall"), literal("holding blue")]
    assert once.plans(blue, TASK)(TASK.initial), "movement is no deed"
    assert not ShortestPlans(toy.DOMAIN, (), Bounds(deeds=1)).plans(blue, TASK)(TASK.initial)
    few = ShortestPlans(toy.DOMAIN, bounds=Bounds(states=1))
    assert not few.plans([literal("holding blue")], TASK)(TASK.initial)


def test_several_shortest_plans_are_all_found_up_to_a_number() -> None:
    here = toy.at(AGENT, toy.X)
    ring = Operator("RING", (toy.X,), (missing(here, "the robot is elsewhere"),), (Add(toy.lit(toy.X)),))
    shout = Operator("SHOUT", (toy.X,), (missing(here, "the robot is elsewhere"),), (Add(toy.lit(toy.X)),))
    domain = toy.DOMAIN.with_operators(ring, shout)
    found = ShortestPlans(domain).plans([literal("lit hall")], TASK)(TASK.initial)
    assert written(found) == ["RING hall", "SHOUT hall"]
    assert (
        len(ShortestPlans(domain, bounds=Bounds(plans=1)).plans([literal("lit hall")], TASK)(TASK.initial))
        == 1
    )


@pytest.mark.parametrize(
    ("action", "plans"),
    [
        ("PRESS lamp", ["GO shed, PRESS lamp"]),
        ("LIFT red", ["LIFT red"]),
        ("DROP blue", ["DROP blue"]),  # no movement makes it possible
        ("GO hall", ["GO hall"]),  # it is there already: it does not leave in order to come back
    ],
)
def test_an_action_is_taken_after_the_movement_that_it_needs(action: str, plans: list[str]) -> None:
    operator, *names = action.split()
    ground = Action(operator, tuple([SCENE.index[name] for name in names]))
    assert written(PLANS.plans_to_take(ground, TASK)(TASK.initial)) == plans


def test_what_no_action_changes_is_not_brought_about() -> None:
    fixed = Predicate("fixed", 1, static=True)
    domain = Domain(
        "toy", Vocabulary((*toy.VOCABULARY.predicates, fixed), toy.VOCABULARY.derived), (toy.GO, toy.PRESS)
    )
    plans = ShortestPlans(domain)
    scene = Scene(domain.vocabulary, [WorldObject("lamp", "lamp")])
    for name, truth, expected in (
        ("fixed", True, False),
        ("holding", True, False),
        ("lit", True, True),
        ("lit", False, True),
        ("beside", True, True),
    ):
        assert plans.brings_about(GroundAtom(name, (0,), truth), scene) is expected


def test_movement_is_told_from_effects() -> None:
    assert [o.name for o in toy.DOMAIN.operators if is_movement(o)] == ["GO"]
    facing, sitting, has = Predicate("facing", 2), Predicate("sitting", 1), Predicate("has", 2)
    x, y, z = Variable("x"), Variable("y"), Variable("z")
    turn = (Delete(facing(AGENT, ANYTHING)), Add(facing(AGENT, x)))
    one_by_one = (ForEach(z, facing(AGENT, z), (Delete(facing(AGENT, z)),)), Add(facing(AGENT, x)))
    take, give, swap = Add(has(AGENT, x)), Delete(has(AGENT, x)), Add(has(AGENT, y))
    for effects, expected in (
        (turn, True),
        (one_by_one, True),
        ((*turn, Add(sitting(AGENT))), True),
        ((Delete(sitting(AGENT)),), True),
        ((*turn, Add(sitting(x))), False),
        ((take,), False),
        ((give,), False),
        ((give, swap), False),
        ((Add(facing(AGENT, x)),), False),
        ((), False),
    ):
        assert is_movement(Operator("O", (x, y), (), effects)) is expected, effects
